"""Entry of ``definition.exposes`` of a Zigbee device, checked. Pure.

Source: zigbee2mqtt.io, Usage > Exposes; Zigbee2MQTT 2.14.1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TypeAlias

from homebot.conventions.bounded_dict import BoundedDict
from homebot.conventions.payload import clean_text
from homebot.devices.part import Category
from homebot.support.folding import words_of
from homebot.support.numbers import finite_number

Scalar: TypeAlias = str | bool | int | float
"""A value in the spelling of the device; values of different types differ."""

SPECIFIC_TYPES: Mapping[str, frozenset[str]] = {
    "light": frozenset({"state", "brightness", "color_temp", "color_xy", "color_hs"}),
    "switch": frozenset({"state"}),
    "cover": frozenset({"state", "position", "tilt"}),
    "lock": frozenset({"state", "lock_state"}),
    "climate": frozenset(
        {
            *("system_mode", "local_temperature", "occupied_heating_setpoint", "current_heating_setpoint"),
            *("occupied_cooling_setpoint", "fan_mode", "swing_mode", "preset", "running_state"),
        }
    ),
    "fan": frozenset({"state", "mode", "speed"}),
}
"""Types of a whole part, each with its own features; other features are parts of their own, mostly settings."""


@dataclass(frozen=True)
class Expose:
    """One property of a device, or a part with several of them.

    Attributes:
        type: ``binary``, ``numeric``, ``enum``, ``text``, ``composite``, ``list``, or one of :data:`SPECIFIC_TYPES`.
        name: Its name, for example ``state``; empty for specific types.
        key: Its property in messages, for example ``state_l1``; empty for specific types.
        endpoint: Distinguishes equal parts; empty for a single one.
        access: The sum of 1 (published), 2 (settable) and 4 (can be requested).
        value_on: The true value of a binary; None for none.
        least: Smallest number; None if undeclared.
    """

    type: str
    name: str = ""
    key: str = ""
    endpoint: str = ""
    label: str = ""
    category: Category = ""
    access: int = 0
    unit: str = ""
    value_on: Scalar | None = None
    value_off: Scalar | None = None
    least: float | None = None
    most: float | None = None
    step: float | None = None
    values: tuple[Scalar, ...] = ()
    features: tuple[Expose, ...] = ()

    @property
    def is_published(self) -> bool:
        """True if the device publishes it by itself."""
        return bool(self.access & 1)

    @property
    def is_settable(self) -> bool:
        """True if it can be set."""
        return bool(self.access & 2)

    @property
    def is_gettable(self) -> bool:
        """True if it can be requested."""
        return bool(self.access & 4)

    @property
    def suffix(self) -> str:
        """Suffix of the properties of its endpoint."""
        return f"_{self.endpoint}" if self.endpoint else ""

    @property
    def title(self) -> str:
        """The label, with the endpoint unless it is part of the label."""
        is_titled = not self.endpoint or set(words_of(self.endpoint)) <= set(words_of(self.label))
        return self.label if is_titled else clean_text(f"{self.label} {self.endpoint}", _MAX_TEXT)

    @cached_property
    def options(self) -> Mapping[str, Scalar]:
        """Options of an enum: the value in the spelling of the device, by its text."""
        return MappingProxyType({_option(value): value for value in self.values})

    def of_commands(self) -> tuple[object, ...]:
        """Return the fields from which the payloads of its commands follow."""
        features = tuple(
            [
                (feature.name, feature.of_commands())
                for feature in self.features
                if feature.is_settable or feature.features
            ]
        )
        return self.key, self.endpoint, self.value_on, self.value_off, self.least, self.most, self.values, features

    @property
    def own_features(self) -> tuple[Expose, ...]:
        """The features of the part of a specific type itself."""
        return tuple([feature for feature in self.features if feature.name in SPECIFIC_TYPES[self.type]])

    def feature(self, *names: str) -> Expose | None:
        """Return the first feature with one of *names*; None if there is none."""
        return next((feature for feature in self.features if feature.name in names), None)


def read_exposes(entries: object) -> tuple[Expose, ...]:
    """Return the valid entries, at most :data:`_MAX_ENTRIES`."""
    if not isinstance(entries, list):
        return ()
    return tuple([expose for entry in entries[:_MAX_ENTRIES] if (expose := _read_known(entry)) is not None])


_MAX_ENTRIES = 500
_MAX_VALUES = 1_000
_MAX_DEPTH = 3
_MAX_KNOWN = 2000
_MAX_KNOWN_CHARACTERS = 2048
_MAX_TEXT = 120
_MAX_PROPERTY = 120
_GENERIC_TYPES = frozenset({"binary", "numeric", "enum", "text", "composite", "list"})
_CATEGORIES: Mapping[object, Category] = {"config": "config", "diagnostic": "diagnostic"}


_known: BoundedDict[Expose] = BoundedDict(_MAX_KNOWN)


def _read_known(entry: object) -> Expose | None:
    """Return an entry as :func:`_read`: the same one for the battery of each device in a list."""
    text = repr(entry)
    expose = _known.get(text)
    if expose is None:
        expose = _read(entry, 0)
        if expose is not None and len(text) <= _MAX_KNOWN_CHARACTERS:
            _known.add(text, expose)
    return expose


def _read(entry: object, depth: int) -> Expose | None:
    if not isinstance(entry, dict):
        return None
    kind, name, key = _text(entry.get("type")), _text(entry.get("name")), _text(entry.get("property"))
    is_specific = kind in SPECIFIC_TYPES
    if not is_specific and (kind not in _GENERIC_TYPES or not key):
        return None
    access = entry.get("access")
    values, listed = entry.get("values"), entry.get("features")
    known_values = map(_scalar, values[:_MAX_VALUES]) if isinstance(values, list) else ()
    features = listed[:_MAX_ENTRIES] if isinstance(listed, list) and depth < _MAX_DEPTH else ()
    return Expose(
        type=kind,
        name=clean_text(name or key),
        key="" if is_specific else key,
        endpoint=clean_text(_text(entry.get("endpoint"))),
        label=clean_text(_text(entry.get("label")) or name or key, _MAX_TEXT),
        category=_category(entry),
        access=access & 7 if isinstance(access, int) else 0,
        unit=clean_text(_text(entry.get("unit")), 20),
        value_on=_scalar(entry.get("value_on")),
        value_off=_scalar(entry.get("value_off")),
        least=finite_number(entry.get("value_min")),
        most=finite_number(entry.get("value_max")),
        step=finite_number(entry.get("value_step")),
        values=tuple([value for value in known_values if value is not None]),
        features=tuple([expose for feature in features if (expose := _read(feature, depth + 1)) is not None]),
    )


def _category(entry: Mapping[str, object]) -> Category:
    """Return the category; the definition's entry for Home Assistant precedes its general one."""
    override = entry.get("homeassistant")
    if isinstance(override, dict) and isinstance(override.get("entityCategory"), str):
        return _CATEGORIES.get(override["entityCategory"], "")
    declared = entry.get("category")
    return _CATEGORIES.get(declared, "") if isinstance(declared, str) else ""


def _scalar(value: object) -> Scalar | None:
    if isinstance(value, str):
        return value if len(value) <= _MAX_TEXT and value.isprintable() else None
    if isinstance(value, bool):
        return value
    if isinstance(value, (int, float)) and finite_number(value) is not None:
        return value
    return None


def _option(value: Scalar) -> str:
    return ("false", "true")[value] if isinstance(value, bool) else str(value)


def _text(value: object) -> str:
    return value if isinstance(value, str) and len(value) <= _MAX_PROPERTY else ""
