"""The properties of simulated things, by the kind of the device. Pure.

Source of the semantic types: WebThings, https://webthings.io/schemas.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.house.dialect import DeviceState
from homebot.house.wire import lamp_order
from homebot.support.numbers import to_number


@dataclass(frozen=True, slots=True)
class ThingProperty:
    """One property of a thing.

    Attributes:
        schema: The property's description without forms.
        read: Returns its value.
        order: Returns the commands that make it a value, or None for a value that it does not take; None where it
            cannot be written.
    """

    schema: Mapping[str, object]
    read: Callable[[DeviceState], object]
    order: Callable[[object], tuple[str, ...] | None] | None = None


def _switched(value: object) -> tuple[str, ...] | None:
    return lamp_order(is_on=value) if isinstance(value, bool) else None


def _dimmed(value: object) -> tuple[str, ...] | None:
    number = to_number(value)
    return None if number is None or not 0 <= number <= 100 else lamp_order(brightness=number / 100)


def _tinted(value: object) -> tuple[str, ...] | None:
    number = to_number(value)
    return None if number is None or not 2000 <= number <= 6500 else lamp_order(kelvin=number)


def _moved(value: object) -> tuple[str, ...] | None:
    number = to_number(value)
    return None if number is None or not 0 <= number <= 100 else (f"{number / 100:g}",)


def _locked(value: object) -> tuple[str, ...] | None:
    return {"locked": ("lock",), "unlocked": ("unlock",)}.get(value) if isinstance(value, str) else None


def _set_to(value: object) -> tuple[str, ...] | None:
    number = to_number(value)
    return None if number is None or not 5 <= number <= 35 else (f"{number:g}",)


_PERCENT = {"type": "integer", "minimum": 0, "maximum": 100, "unit": "percent"}
_POSITION = {
    "position": ThingProperty({**_PERCENT, "@type": "LevelProperty"}, lambda state: round(state.position * 100), _moved)
}
THING_PROPERTIES: Mapping[str, tuple[str, Mapping[str, ThingProperty]]] = MappingProxyType(
    {
        "lamp": (
            "Light",
            {
                "on": ThingProperty(
                    {"type": "boolean", "@type": "OnOffProperty"}, lambda state: state.is_on, _switched
                ),
                "brightness": ThingProperty(
                    {**_PERCENT, "@type": "BrightnessProperty"}, lambda state: round(state.brightness * 100), _dimmed
                ),
                "colorTemperature": ThingProperty(
                    {
                        "type": "number",
                        "minimum": 2000,
                        "maximum": 6500,
                        "unit": "kelvin",
                        "@type": "ColorTemperatureProperty",
                    },
                    lambda state: state.kelvin,
                    _tinted,
                ),
            },
        ),
        "cover": ("WindowCovering", _POSITION),
        "window": ("WindowCovering", _POSITION),
        "lock": (
            "Lock",
            {
                "locked": ThingProperty(
                    {"type": "string", "enum": ["locked", "unlocked"], "@type": "LockedProperty"},
                    lambda state: "locked" if state.text == "locked" else "unlocked",
                    _locked,
                )
            },
        ),
        "contact": (
            "DoorSensor",
            {"open": ThingProperty({"type": "boolean", "@type": "OpenProperty"}, lambda state: state.text == "open")},
        ),
        "motion": (
            "MotionSensor",
            {
                "motion": ThingProperty(
                    {"type": "boolean", "@type": "MotionProperty"}, lambda state: state.text == "motion"
                )
            },
        ),
        "lux": (
            "",
            {"illuminance": ThingProperty({"type": "number", "unit": "lux"}, lambda state: state.value)},
        ),
        "power_meter": (
            "EnergyMonitor",
            {
                "power": ThingProperty(
                    {"type": "number", "unit": "watt", "@type": "InstantaneousPowerProperty"},
                    lambda state: state.value,
                )
            },
        ),
        "thermostat": (
            "Thermostat",
            {
                "temperature": ThingProperty(
                    {"type": "number", "unit": "degree celsius", "@type": "TemperatureProperty"},
                    lambda state: state.celsius,
                ),
                "targetTemperature": ThingProperty(
                    {
                        "type": "number",
                        "minimum": 5,
                        "maximum": 35,
                        "unit": "degree celsius",
                        "@type": "TargetTemperatureProperty",
                    },
                    lambda state: state.target,
                    _set_to,
                ),
            },
        ),
    }
)
"""For each kind of device the semantic type of the thing, and its properties by name."""
