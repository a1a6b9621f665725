"""``homebot config check``."""

from __future__ import annotations

import argparse
from pathlib import Path

from homebot.config import load_config
from homebot.errors import ConfigError, UsageError
from homebot.gateways.mqtt.settings import EMBEDDED, MqttGatewaySettings
from homebot.runtime.plan import Plan, make_plan

__all__ = ["check"]


def check(options: argparse.Namespace) -> int:
    """Read the file, find its plug-ins, check every table, and say what would run."""
    config = load_config(Path(options.config))
    plan = make_plan(config)
    _check_credentials(plan, config.source)
    print(f"{config.source} is fine: home {plan.home}")
    print(f"  gateways: {_names(plan.gateways)}")
    print(f"  apps:     {_names(plan.apps)}")
    print(f"  door:     {plan.door.host}:{plan.door.port}")
    return 0


def _check_credentials(plan: Plan, source: str) -> None:
    for gateway in plan.gateways:
        settings = gateway.settings
        if isinstance(settings, MqttGatewaySettings) and settings.url != EMBEDDED:
            try:
                settings.options()
            except UsageError as exc:
                raise ConfigError(source, f"gateways.{gateway.name}", str(exc)) from exc


def _names(components: tuple[object, ...]) -> str:
    return ", ".join(getattr(component, "name", "") for component in components) or "none"
