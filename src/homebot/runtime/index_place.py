"""Path of the file in which a homebot keeps its index: one for each home and network."""

from __future__ import annotations

from pathlib import Path

from homebot.config import Config
from homebot.discovery.store import index_path
from homebot.runtime.plan import make_plan

__all__ = ["index_place"]


def index_place(config: Config) -> Path:
    """Return where the index of *config* is kept.

    The network is that of the first gateway: the broker's host and port without any credentials, ``embedded`` for
    homebot's own broker, else the gateway's name.

    Raises:
        ConfigError: As :func:`homebot.runtime.plan.make_plan`.
    """
    plan = make_plan(config)
    for gateway in plan.gateways:
        return index_path(plan.home, gateway.kind.network(gateway.settings) or gateway.name)
    return index_path(plan.home, "none")
