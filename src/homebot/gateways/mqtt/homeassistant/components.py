"""Which builder understands which component: one line each. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeAlias

from homebot.gateways.mqtt.description import DescribedPart
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.cover import build_cover
from homebot.gateways.mqtt.homeassistant.fan import build_fan
from homebot.gateways.mqtt.homeassistant.light import build_light
from homebot.gateways.mqtt.homeassistant.lock import build_lock
from homebot.gateways.mqtt.homeassistant.siren import build_siren
from homebot.gateways.mqtt.homeassistant.switch import build_switch
from homebot.gateways.mqtt.homeassistant.valve import build_valve

__all__ = ["BUILDERS", "Builder"]

Builder: TypeAlias = Callable[[Config], DescribedPart]
"""Makes a part of a component's config; raises WireError where Home Assistant would refuse the config."""

BUILDERS: Mapping[str, Builder] = MappingProxyType(
    {
        "cover": build_cover,
        "fan": build_fan,
        "light": build_light,
        "lock": build_lock,
        "siren": build_siren,
        "switch": build_switch,
        "valve": build_valve,
    }
)
"""By component. One that is not here is ignored quietly."""
