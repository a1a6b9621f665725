"""Exposes that Zigbee2MQTT lists for each kind of device."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["EXPOSES"]

PUBLISHED = 1
SETTABLE = 2
GETTABLE = 4
FULL = PUBLISHED | SETTABLE | GETTABLE


def _numeric(name: str, access: int, unit: str = "", **more: object) -> dict[str, object]:
    spelled = {"type": "numeric", "name": name, "property": name, "label": name, "access": access, **more}
    return {**spelled, "unit": unit} if unit else spelled


def _binary(name: str, access: int, on: object, off: object) -> dict[str, object]:
    return {
        "type": "binary",
        "name": name,
        "property": name,
        "label": name,
        "access": access,
        "value_on": on,
        "value_off": off,
    }


def _enum(name: str, access: int, *values: str) -> dict[str, object]:
    return {"type": "enum", "name": name, "property": name, "label": name, "access": access, "values": list(values)}


_COVER: tuple[dict[str, object], ...] = (
    {
        "type": "cover",
        "features": [
            _enum("state", PUBLISHED | SETTABLE, "OPEN", "CLOSE", "STOP"),
            _numeric("position", FULL, "%", value_min=0, value_max=100),
        ],
    },
    _enum("moving", PUBLISHED, "UP", "STOP", "DOWN"),
)

EXPOSES: Mapping[str, tuple[dict[str, object], ...]] = MappingProxyType(
    {
        "lamp": (
            {
                "type": "light",
                "features": [
                    _binary("state", FULL, "ON", "OFF"),
                    _numeric("brightness", FULL, value_min=0, value_max=254),
                    _numeric("color_temp", FULL, "mired", value_min=112, value_max=666),
                ],
            },
        ),
        "window": _COVER,
        "cover": _COVER,
        "lock": (
            {
                "type": "lock",
                "features": [
                    _binary("state", FULL, "LOCK", "UNLOCK"),
                    _enum("lock_state", PUBLISHED, "not_fully_locked", "locked", "unlocked"),
                ],
            },
        ),
        "contact": (_binary("contact", PUBLISHED, on=False, off=True),),
        "motion": (_binary("occupancy", PUBLISHED, on=True, off=False),),
        "lux": (_numeric("illuminance", PUBLISHED, "lx"),),
        "power_meter": (_numeric("power", PUBLISHED, "W"),),
        "thermostat": (
            {
                "type": "climate",
                "features": [
                    _numeric("occupied_heating_setpoint", FULL, "°C", value_min=5, value_max=30, value_step=0.5),
                    _numeric("local_temperature", PUBLISHED | GETTABLE, "°C"),
                    _enum("system_mode", FULL, "heat"),
                    _enum("running_state", PUBLISHED | GETTABLE, "idle", "heat"),
                ],
            },
        ),
    }
)
"""By kind."""
