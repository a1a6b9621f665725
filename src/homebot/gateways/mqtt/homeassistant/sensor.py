"""The component ``sensor``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/sensor.py`` and ``components/sensor/__init__.py``.
"""

from __future__ import annotations

from datetime import datetime
from functools import partial

from homebot.gateways.mqtt.description import DescribedPart
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.entity import NOTHING, Entity, Readings
from homebot.gateways.mqtt.homeassistant.expiry import expire
from homebot.gateways.mqtt.homeassistant.quantities import Quantity, quantity_of
from homebot.gateways.mqtt.homeassistant.rendered import number_of
from homebot.gateways.mqtt.payload import clean_text

__all__ = ["build_sensor"]


def build_sensor(config: Config) -> DescribedPart:
    """Describe a sensor: of numbers where class, unit or statistics say so, and else of texts.

    A number is reported in the unit of the vocabulary; where its own cannot be converted, in that. A class that we do
    not know tells only a number or a text with a meaning of its own.
    """
    source = config.required_source("state_topic")
    device_class = config.text("device_class")
    if device_class not in _TEXTS and (device_class or any(config.has(key) for key in _NUMERIC)):
        quantity = quantity_of(device_class, config.text("unit_of_measurement"))
        entity = Entity(config, quantity.service_type)
        if entity.hears(source, partial(_read_number, quantity)):
            entity.offers(quantity.capability, unit=quantity.unit)
            expire(entity, config, quantity.capability)
        return entity.described()
    options = config.options("options")
    entity = Entity(config, "x_sensor")
    if entity.hears(source, partial(_read_text, options, is_time=device_class in _TIMES)):
        entity.offers("value", options=options)
        expire(entity, config, "value")
    return entity.described()


_TIMES = frozenset({"date", "timestamp"})
_TEXTS = _TIMES | {"enum"}
_NUMERIC = ("unit_of_measurement", "state_class", "suggested_display_precision")
_MAX_TEXT = 255


def _read_number(quantity: Quantity, text: str) -> Readings:
    if text == "None":
        return {quantity.capability: None}
    number = number_of(text)
    return NOTHING if number is None else {quantity.capability: quantity.value(number)}


def _read_text(options: tuple[str, ...], text: str, *, is_time: bool) -> Readings:
    if text == "None" or (is_time and not _is_time(text)):
        return {"value": None}
    if len(text) > _MAX_TEXT or (options and text not in options):
        return NOTHING
    return {"value": clean_text(text, _MAX_TEXT)}


def _is_time(text: str) -> bool:
    try:
        datetime.fromisoformat(text[:_MAX_TEXT])
    except ValueError:
        return False
    return True
