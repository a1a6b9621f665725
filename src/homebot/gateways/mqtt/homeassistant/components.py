"""Which builder understands which component: one line each. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from homebot.gateways.mqtt.description import DescribedPart
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.light import build_light
from homebot.gateways.mqtt.homeassistant.switch import build_switch

__all__ = ["BUILDERS", "Builder"]

Builder: TypeAlias = Callable[[Config], DescribedPart]
"""Makes a part of a component's config; raises WireError where Home Assistant would refuse the config."""

BUILDERS: Mapping[str, Builder] = MappingProxyType(
    {
        "light": build_light,
        "switch": build_switch,
    }
)
"""By component. One that is not here is ignored quietly."""
