"""The component ``sensor``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/sensor.py`` and ``components/sensor/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from functools import lru_cache, partial

from homebot.conventions.description import DescribedPart
from homebot.conventions.device_classes import is_quantity, quantity_of
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings, clean_text, read_number
from homebot.conventions.secrets import names_secret
from homebot.conventions.units import Quantity

__all__ = ["build_sensor"]


def build_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor: of numbers where class, unit or statistics say so, and else of texts.

    A number is reported in the unit of the vocabulary; where its own cannot be converted, in that. One of a class that
    we do not know has a meaning of its own.
    """
    source = config.required_source("state_topic").without_payload()
    device_class = config.clean_text("device_class")
    if device_class not in _TEXTS and (is_quantity(device_class) or any(config.has(key) for key in _NUMERIC)):
        quantity = quantity_of(device_class, config.clean_text("unit_of_measurement", _MAX_UNIT))
        entity = Entity(config, quantity.service_type)
        if entity.read_text_from(source, _number_reader(quantity)):
            entity.add_capability(quantity.capability, unit=quantity.unit)
            entity.expire(quantity.capability)
        return entity.build()
    entity = Entity(config, "x_sensor")
    options = config.options("options")
    read = _MOMENTS.get(device_class) or partial(_read_text, frozenset(options))
    if entity.read_text_from(source, read):
        entity.add_capability("value", options=options)
        entity.expire("value")
    return entity.build()


@lru_cache(maxsize=512)  # one for all sensors of a kind: it would be a tenth of what a part takes
def _number_reader(quantity: Quantity) -> Callable[[object], Readings]:
    return partial(read_number, quantity.capability, convert=quantity.value)


_TEXTS = frozenset({"date", "enum", "timestamp"})
_NUMERIC = ("unit_of_measurement", "state_class", "suggested_display_precision")
_MAX_TEXT = 255
_MAX_UNIT = 40


def _read_text(options: frozenset[str], text: str) -> Readings:
    if text == "None":
        return _UNKNOWN
    if len(text) > _MAX_TEXT or (options and text not in options):
        return NO_READINGS
    if text.startswith("{") and names_secret(text):  # the message of a lock, which no template takes apart
        return NO_READINGS
    return {"value": clean_text(text, _MAX_TEXT)}


def _read_date(text: str) -> Readings:
    moment = _moment(text)
    return {"value": moment.date().isoformat()} if moment else _UNKNOWN


def _read_timestamp(text: str) -> Readings:
    """Read a timestamp; one without time zone is no report: it may be any of many."""
    moment = _moment(text)
    if moment is None:
        return _UNKNOWN
    try:
        return {"value": moment.astimezone(UTC).isoformat(timespec="seconds")} if moment.tzinfo else NO_READINGS
    except OverflowError:
        return NO_READINGS


def _moment(text: str) -> datetime | None:
    try:
        return datetime.fromisoformat(text[:_MAX_TEXT])
    except ValueError:
        return None


_UNKNOWN: Readings = {"value": None}
_MOMENTS: Mapping[str, Callable[[str], Readings]] = {"date": _read_date, "timestamp": _read_timestamp}
