"""Parts of a Shelly of the second generation, by its components. Pure."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.shelly.gen2_bluetooth import build_bluetooth_device, build_bluetooth_sensor
from homebot.conventions.shelly.gen2_component import Fields, Gen2Topics, ShellyComponent
from homebot.conventions.shelly.gen2_controls import (
    build_cover,
    build_radiator_valve,
    build_switch,
    build_thermostat,
)
from homebot.conventions.shelly.gen2_lights import LIGHTS, build_light
from homebot.conventions.shelly.gen2_meters import build_meters, build_own_temperature
from homebot.conventions.shelly.gen2_sensors import (
    SENSORS,
    build_input,
    build_power,
    build_sensor,
)
from homebot.conventions.shelly.gen2_virtual import VIRTUAL, build_virtual, build_virtual_button
from homebot.conventions.shelly.rpc import call

__all__ = ["MAX_COMPONENTS", "build_parts"]

MAX_COMPONENTS = 300
"""Components of one device that are looked at; a gateway with all the sensors it takes has about 150."""


def build_parts(topics: Gen2Topics, status: Fields, config: Fields) -> tuple[DescribedPart, ...]:
    """Return the parts of the device at *topics*; first what it is there for.

    Args:
        topics: Its topics.
        status: By component, as it answers ``Shelly.GetStatus``.
        config: By component, as it answers ``Shelly.GetConfig``; empty where it did not.
    """
    parts: list[JsonPart] = []
    for component in _components(topics, status, config):
        for build in _BUILDERS[component.kind]:
            parts.extend(build(component))
    for part in parts[:1]:
        part.add_state_request(call(topics.prefix, topics.answers.removesuffix("/rpc"), "Shelly.GetStatus"))
    return tuple(part.build() for part in parts)


_KEY = re.compile(r"[a-z0-9]{1,20}:[0-9]{1,5}")
_Build = Callable[[ShellyComponent], tuple[JsonPart, ...]]
_LOAD: tuple[_Build, ...] = (build_meters, build_own_temperature)
_BUILDERS: Mapping[str, tuple[_Build, ...]] = {
    "thermostat": (build_thermostat,),
    "switch": (build_switch, *_LOAD),
    "cover": (build_cover, *_LOAD),
    **dict.fromkeys(LIGHTS, (build_light, *_LOAD)),
    **dict.fromkeys(("pm1", "em", "em1"), (build_meters,)),
    **dict.fromkeys(SENSORS, (build_sensor,)),
    "blutrv": (build_radiator_valve,),
    "bthomesensor": (build_bluetooth_sensor,),
    "bthomedevice": (build_bluetooth_device,),
    "input": (build_input,),
    "devicepower": (build_power,),
    **dict.fromkeys(VIRTUAL, (build_virtual,)),
    "button": (build_virtual_button,),
}
_ORDER = {kind: topics for topics, kind in enumerate(_BUILDERS)}


def _components(topics: Gen2Topics, status: Fields, config: Fields) -> tuple[ShellyComponent, ...]:
    found: list[ShellyComponent] = []
    for key, fields in status.items():
        if len(found) >= MAX_COMPONENTS:
            break
        if isinstance(fields, dict) and _KEY.fullmatch(key) and key.partition(":")[0] in _ORDER:
            settings = config.get(key)
            found.append(ShellyComponent(topics, key, fields, settings if isinstance(settings, dict) else {}))
    return tuple(sorted(found, key=lambda one: (_ORDER[one.kind], one.index)))
