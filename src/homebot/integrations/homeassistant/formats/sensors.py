"""Sensors, events and pictures: the components that are read and not commanded. Pure.

A retained event happened before and is ignored: an old doorbell must not ring again. Of a picture only the topic is
known; it is not carried.

Source: Home Assistant core 2025.4, ``components/mqtt``: binary_sensor.py, camera.py, device_tracker.py,
device_trigger.py, event.py, image.py, sensor.py, tag.py and update.py; ``components/sensor/__init__.py``.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache, partial

from homebot.conventions.description import AutoExpiry, DescribedPart
from homebot.conventions.device_classes import condition_of, is_quantity, quantity_of
from homebot.conventions.payload import (
    NO_READINGS,
    Readings,
    clean_text,
    fields_of,
    meaning_reader,
    read_number,
    read_progress,
    shown,
)
from homebot.conventions.secrets import names_secret
from homebot.conventions.units import Quantity
from homebot.conventions.unreadable import unreadable
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity

_MAX_TEXT_CHARACTERS = 255
_MAX_PLACE_CHARACTERS = 120
_MAX_UNIT_CHARACTERS = 40
_IMAGE = Capability(name="image", readable=False)
_UNKNOWN: Readings = {"value": None}
_TEXT_CLASSES = frozenset({"date", "enum", "timestamp"})
_NUMERIC_FIELDS = ("unit_of_measurement", "state_class", "suggested_display_precision")


def build_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor: of numbers if class, unit or statistics imply them, of texts otherwise.

    A number is reported in the unit of the vocabulary, or in its own if that cannot be converted.
    """
    source = config.required_source("state_topic").without_payload()
    device_class = config.device_class
    if device_class not in _TEXT_CLASSES and (is_quantity(device_class) or any(map(config.has, _NUMERIC_FIELDS))):
        quantity = quantity_of(device_class, config.clean_text("unit_of_measurement", _MAX_UNIT_CHARACTERS))
        entity = Entity(config, quantity.service_type)
        if entity.read_text_from(source, _number_reader(quantity)):
            entity.add_capability(quantity.capability, unit=quantity.unit)
            entity.expire(quantity.capability)
        return entity.build()
    entity = Entity(config, "x_sensor")
    options = config.options("options")
    is_moment = device_class in ("date", "timestamp")
    read = partial(_read_moment, device_class) if is_moment else partial(_read_text, dict.fromkeys(options))
    if entity.read_text_from(source, read):
        entity.add_capability("value", options=options)
        entity.expire("value")
    return entity.build()


@lru_cache(maxsize=512)  # one for all sensors of a kind: it would be a tenth of a part's memory
def _number_reader(quantity: Quantity) -> Callable[[object], Readings]:
    return partial(read_number, quantity.capability, convert=quantity.value)


def _read_text(options: Mapping[str, object], text: str) -> Readings:
    if text == "None":
        return _UNKNOWN
    if len(text) > _MAX_TEXT_CHARACTERS or (options and text not in options):
        return unreadable(text, options or f"at most {_MAX_TEXT_CHARACTERS} characters")
    if text.startswith("{") and names_secret(text):  # the whole message of a lock, without a template
        return NO_READINGS
    return {"value": clean_text(text, _MAX_TEXT_CHARACTERS)}


def _read_moment(device_class: str, text: str) -> Readings:
    """Read a date or a timestamp; one without time zone is ambiguous and ignored."""
    try:
        moment = datetime.fromisoformat(text[:_MAX_TEXT_CHARACTERS])
    except ValueError:
        unreadable(text, f"a {device_class} in ISO 8601")
        return _UNKNOWN
    if device_class == "date":
        return {"value": moment.date().isoformat()}
    try:
        if moment.tzinfo:
            return {"value": moment.astimezone(UTC).isoformat(timespec="seconds")}
    except OverflowError:
        pass
    return unreadable(text, "a timestamp with its zone")


def build_binary_sensor(config: DiscoveryConfig) -> DescribedPart:
    """Describe a sensor of one condition, by its class; of an unknown class it is a ``state``."""
    source = config.required_source("state_topic")
    service_type, capability = condition_of(config.device_class)
    states = {"None": None, config.text("payload_off", "OFF"): False, config.text("payload_on", "ON"): True}
    meanings = {text: state for text, state in states.items() if text.strip()}
    delay = config.seconds("off_delay")
    is_of_remote = any(map(_CODE.fullmatch, meanings)) or (delay is not None and not config.has("payload_off"))
    read = partial(_read_code, capability, meanings) if is_of_remote else meaning_reader(capability, meanings)
    entity = Entity(config, service_type)
    if entity.read_text_from(source, read):
        entity.add_capability(capability)
        if delay is not None:
            entity.add_expiry(AutoExpiry(capability, delay, value=False, only=True))
        entity.expire(capability)
    return entity.build()


_CODE = re.compile("(?=.*[0-9])[0-9A-Fa-f]{4,}")
"""A code of a radio remote: its receiver publishes those of all remotes on one topic, also a neighbour's."""


def _read_code(capability: str, meanings: Mapping[str, bool | None], text: str) -> Readings:
    return {capability: meanings[text]} if text in meanings else NO_READINGS


def build_device_tracker(config: DiscoveryConfig) -> DescribedPart:
    """Describe a tracker of a person or a thing. One that reports only coordinates has no ``place``."""
    source = config.source("state_topic")
    if source is None and not config.has("json_attributes_topic"):
        raise WireError("device_tracker: it has neither state_topic nor json_attributes_topic")
    places: dict[str, str | None] = {
        config.text("payload_reset", "None"): None,
        config.text("payload_not_home", "not_home"): "not_home",
        config.text("payload_home", "home"): "home",
    }

    def read(text: str) -> Readings:
        if not text.strip():
            return NO_READINGS
        return {"place": places[text] if text in places else clean_text(text, _MAX_PLACE_CHARACTERS)}

    entity = Entity(config, "x_tracker", config.clean_text("source_type"))
    entity.add_value("place", source, read)
    return entity.build()


def build_event(config: DiscoveryConfig) -> DescribedPart:
    """Describe a source of events of declared types, such as a doorbell."""
    if not config.has("event_types"):
        raise WireError("event: event_types is None, not a list of texts")
    types = config.options("event_types")

    def read(text: str) -> str:
        event = fields_of(text).get("event_type", text)
        event = str(event) if isinstance(event, (bool, int, float)) else event
        if isinstance(event, str) and event in types and event is not text:
            return event
        unreadable(event, ["event_type", *types] if event is text else types)
        return ""

    return _build_events(config, "generic_switch", "press", "state_topic", read, options=types)


def build_trigger(config: DiscoveryConfig) -> DescribedPart:
    """Describe one event of a remote: its subtype if its type is ``action``, otherwise ``type subtype``."""
    kind, subtype = (config.clean_text(key) for key in ("type", "subtype"))
    automation = config.text("automation_type")
    if automation != "trigger":
        raise WireError(f"device_automation: automation_type is {shown(automation)}, not trigger")
    if not kind or not subtype:
        raise WireError("device_automation: it lacks type or subtype")
    expected = config.text("payload")
    press = subtype if kind == "action" else f"{kind} {subtype}"

    def read(text: str) -> str:
        return press if expected in ("", text) else ""

    return _build_events(config, "generic_switch", "press", "topic", read, tag=kind, options=(press,))


def build_tag(config: DiscoveryConfig) -> DescribedPart:
    """Describe a reader of tags; each message is one scanned tag."""
    return _build_events(config, "x_tag_reader", "scan", "topic", lambda text: clean_text(text, _MAX_TEXT_CHARACTERS))


def _build_events(
    config: DiscoveryConfig,
    service_type: str,
    capability: str,
    topic_key: str,
    event_of: Callable[[str], str],
    *,
    tag: str | None = None,
    options: tuple[str, ...] = (),
) -> DescribedPart:
    """Describe a source of events; *event_of* returns the event of a text, or an empty text."""
    entity = Entity(config, service_type, tag)
    source = entity.usable(config.required_source(topic_key).without_payload())
    if source is not None:

        def read(payload: bytes) -> Readings:
            text = source.text(payload)
            event = event_of(text) if text is not None else ""
            return {capability: event} if event else NO_READINGS

        entity.read_events_from(source.topic, read)
        entity.add_capability(capability, options=options)
    return entity.build()


def build_camera(config: DiscoveryConfig) -> DescribedPart:
    """Describe a camera: its part names the topic of its pictures, and its codec does not read there."""
    return _build_picture(config, config.required_source("topic").topic)


def build_image(config: DiscoveryConfig) -> DescribedPart:
    """Describe a picture, such as the map of a vacuum cleaner, in the same way."""
    topic = config.state_topic("image_topic") or config.state_topic("url_topic")
    if not topic:
        raise WireError("image: it has neither image_topic nor url_topic")
    return _build_picture(config, topic)


def _build_picture(config: DiscoveryConfig, topic: str) -> DescribedPart:
    described = Entity(config, "camera", config.device_class or "image").build()
    return described._replace(part=described.part.model_copy(update={"capabilities": (_IMAGE,), "reads": (topic,)}))


def build_update(config: DiscoveryConfig) -> DescribedPart:
    """Describe the installed and the latest version of a device's software, which homebot does not install."""
    source = config.required_source("state_topic").without_payload()
    versions = _Versions()
    entity = Entity(config, "x_update")
    has_state = entity.read_text_from(source, versions.read)
    has_latest = entity.read_text_from(
        config.source("latest_version_topic", "latest_version_template"), versions.read_latest
    )
    entity.add_capability("version", readable=has_state)
    entity.add_capability("update_available", readable=has_state)
    entity.add_capability("latest_version", readable=has_state or has_latest)
    entity.add_capability("running", readable=has_state)
    entity.add_capability("update_progress", readable=has_state, unit="%")
    entity.remembers()
    return entity.build()


@dataclass(slots=True)
class _Versions:
    """Reader of the installed and the latest version, which may come on two topics."""

    known: dict[str, PlainValue] = field(default_factory=dict)

    def read(self, text: str) -> Readings:
        """Read the installed version, or an object with both."""
        if text.lstrip().startswith("{"):
            message = fields_of(text)
            versions = {name: _version(message.get(key)) for name, key in _VERSION_KEYS.items()}
            known: dict[str, PlainValue] = {name: text for name, text in versions.items() if text is not None}
            return {**self._found(known), **read_progress(message, "in_progress", "update_percentage")}
        return self._found({"version": _version(text)} if text else {})

    def read_latest(self, text: str) -> Readings:
        return self._found({"latest_version": _version(text)} if text else {})

    def _found(self, readings: dict[str, PlainValue]) -> Readings:
        if not readings:
            return NO_READINGS
        self.known.update(readings)
        latest, installed = (self.known.get(name, "") for name in ("latest_version", "version"))
        return readings if "" in (latest, installed) else {**readings, "update_available": _is_newer(latest, installed)}


_VERSION_KEYS = {"version": "installed_version", "latest_version": "latest_version"}
_NUMBERS = re.compile(r"v?([0-9]{1,9}(?:\.[0-9]{1,9}){0,9})(?![0-9A-Za-z])")


def _version(value: object) -> str | None:
    if isinstance(value, str):
        return None if value == "None" else clean_text(value, _MAX_TEXT_CHARACTERS)
    return str(value) if isinstance(value, float) else shown(value) if isinstance(value, int) else None


def _is_newer(latest: PlainValue, installed: PlainValue) -> bool | None:
    """Return whether a version is newer: by the numbers at its beginning, or else if it differs; None for unknown."""
    if not isinstance(latest, str) or not isinstance(installed, str):
        return None
    numbers = [
        tuple(map(int, match[1].split("."))) for version in (latest, installed) if (match := _NUMBERS.match(version))
    ]
    return latest != installed and (len(numbers) < 2 or numbers[0] >= numbers[1])
