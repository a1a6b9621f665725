"""Echoes: states of which a config says that they may only repeat the command. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: with ``optimistic`` a command is taken for the new state.
"""

from __future__ import annotations

from dataclasses import replace

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.devices.part import Capability

__all__ = ["with_echoes"]


def with_echoes(described: DescribedPart, config: DiscoveryConfig) -> DescribedPart:
    """Return *described* with its echoed capabilities marked.

    These are all that can be set where the config is ``optimistic``, and where every state topic is a command topic
    too: whatever is published there is a command.
    """
    part = described.part
    is_optimistic = config.flag("optimistic")
    if not is_optimistic and not (part.reads and set(part.reads) <= set(part.writes)):
        return described
    capabilities = tuple([_echoed(one) for one in part.capabilities])
    return replace(described, part=part.model_copy(update={"capabilities": capabilities}).slimmed())


def _echoed(capability: Capability) -> Capability:
    is_echoed = capability.readable and capability.settable
    return capability.model_copy(update={"echoed": True}).slimmed() if is_echoed else capability
