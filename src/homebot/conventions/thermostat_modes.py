"""Modes of a thermostat by their effect: its type, on, off, and the setpoints that they use. Pure.

Source: Home Assistant core 2025.4, ``components/climate/__init__.py``.
"""

from collections.abc import Collection

__all__ = ["climate_type", "modes_of_switch", "setpoints_of"]

_PAIR = 2
_SWITCHED_ON = ("heat_cool", "heat", "cool")
_HEATS = frozenset({"heat", "heat_cool", "auto"})
_COOLS = frozenset({"cool", "heat_cool"})


def climate_type(modes: Collection[str]) -> str:
    """Return the service type: an air conditioner cools, and dries or only blows."""
    return "room_air_conditioner" if "cool" in modes and ("dry" in modes or "fan_only" in modes) else "thermostat"


def modes_of_switch(modes: Collection[str]) -> dict[bool, str]:
    """Return the modes of on and off among *modes*. Of two modes, any other one than off is on."""
    is_pair = len(modes) == _PAIR and "off" in modes
    on = [mode for mode in (modes if is_pair else _SWITCHED_ON) if mode in modes and mode != "off"]
    return {**({True: on[0]} if on else {}), **({False: "off"} if "off" in modes else {})}


def setpoints_of(modes: Collection[str]) -> tuple[str, ...]:
    """Return the capabilities of a single setpoint.

    It is a ``cooling_setpoint`` if the device cools, and a ``heating_setpoint`` if it heats or has no such modes.
    """
    cools = ("cooling_setpoint",) if _COOLS.intersection(modes) else ()
    return (*cools, "heating_setpoint") if not cools or _HEATS.intersection(modes) else cools
