"""The components that take no command: events, triggers, tags, trackers, cameras, images, updates. Pure.

A message that the broker had kept happened before and is no event: an old doorbell must not ring again.

Source: Home Assistant core 2025.4, ``components/mqtt``: event.py, device_trigger.py, tag.py, device_tracker.py,
camera.py, image.py, update.py.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import Codec, DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.conversion import fields_of
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import StateMessage
from homebot.conventions.payload import clean_text, shown
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

__all__ = [
    "build_camera",
    "build_device_tracker",
    "build_event",
    "build_image",
    "build_tag",
    "build_trigger",
    "build_update",
]


def build_event(config: DiscoveryConfig) -> DescribedPart:
    """Describe something that tells events of declared types, such as a doorbell."""
    source = config.required_source("state_topic").without_payload()
    if not config.has("event_types"):
        raise WireError("event: event_types is None, not a list of texts")
    types = config.options("event_types")

    def read(message: StateMessage, text: str) -> Readings:
        event = None if message.retained else fields_of(text).get("event_type")
        if isinstance(event, (bool, int, float)):
            event = str(event)
        return {"press": event} if isinstance(event, str) and event in types else NO_READINGS

    entity = Entity(config, "generic_switch")
    if entity.read_message_from(source, read):
        entity.add_capability("press", options=types)
    return entity.build()


def build_trigger(config: DiscoveryConfig) -> DescribedPart:
    """Describe one event of a remote: ``single`` where its type is only ``action``, and else ``type subtype``."""
    kind, subtype = (config.clean_text(key) for key in ("type", "subtype"))
    automation = config.text("automation_type")
    if automation != "trigger":
        raise WireError(f"device_automation: automation_type is {shown(automation)}, not trigger")
    if not kind or not subtype:
        raise WireError("device_automation: it misses type or subtype")
    source = config.required_source("topic").without_payload()
    expected = config.text("payload")
    press = subtype if kind == "action" else f"{kind} {subtype}"

    def read(message: StateMessage, text: str) -> Readings:
        return {"press": press} if not message.retained and expected in ("", text) else NO_READINGS

    entity = Entity(config, "generic_switch", kind)
    if entity.read_message_from(source, read):
        entity.add_capability("press", options=(press,))
    return entity.build()


def build_tag(config: DiscoveryConfig) -> DescribedPart:
    """Describe a reader of tags: each of its messages is one that it read."""
    source = config.required_source("topic").without_payload()

    def read(message: StateMessage, text: str) -> Readings:
        tag = "" if message.retained else clean_text(text, _TAG_LONGEST)
        return {"scan": tag} if tag else NO_READINGS

    entity = Entity(config, "x_tag_reader")
    if entity.read_message_from(source, read):
        entity.add_capability("scan")
    return entity.build()


_TAG_LONGEST = 255


def build_device_tracker(config: DiscoveryConfig) -> DescribedPart:
    """Describe what tells where somebody is. One that tells only coordinates has no place to say."""
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
        return {"place": places[text] if text in places else clean_text(text, _PLACE_LONGEST)}

    entity = Entity(config, "x_tracker", config.clean_text("source_type"))
    entity.add_capability("place", readable=entity.read_text_from(source, read))
    return entity.build()


_PLACE_LONGEST = 120


def build_camera(config: DiscoveryConfig) -> DescribedPart:
    """Describe a camera: its part names the topic of its pictures, and its codec does not listen there."""
    return _seen(config, "camera", config.required_source("topic").topic)


def build_image(config: DiscoveryConfig) -> DescribedPart:
    """Describe a picture, such as the map of a vacuum cleaner, in the same way."""
    topic = config.state_topic("image_topic") or config.state_topic("url_topic")
    if not topic:
        raise WireError("image: it has neither image_topic nor url_topic")
    return _seen(config, "camera", topic)


_IMAGE = Capability(name="image", readable=False)


def _seen(config: DiscoveryConfig, service_type: str, topic: str) -> DescribedPart:
    described = Entity(config, service_type, config.clean_text("device_class") or "image").build()
    return replace(described, part=described.part.model_copy(update={"capabilities": (_IMAGE,), "reads": (topic,)}))


def build_update(config: DiscoveryConfig) -> DescribedPart:
    """Describe the software of a device. It is never told to install anything: that is for people to decide."""
    source = config.required_source("state_topic").without_payload()
    latest = config.source("latest_version_topic", "latest_version_template")
    entity = Entity(config, "x_update")
    if entity.read_text_from(source, partial(_read, is_all=latest is None)):
        entity.add_capability("version")
        entity.add_capability("update_available", readable=latest is None)
    has_latest = entity.read_text_from(latest, _read_latest)
    entity.add_capability("latest_version", readable=has_latest or not source.problem)
    described = entity.build()
    return replace(described, codec=_ReadOnlyCodec(described.codec))


_VERSION_LONGEST = 255


def _read(text: str, *, is_all: bool) -> Readings:
    if not text or text == "{}":
        return NO_READINGS
    if not text.lstrip().startswith("{"):
        return {"version": None if text == "None" else clean_text(text, _VERSION_LONGEST)}
    message = fields_of(text)
    found: dict[str, PlainValue] = {}
    installed, latest = (_version(message.get(key)) for key in ("installed_version", "latest_version"))
    if installed is not None:
        found["version"] = installed
    if latest is not None:
        found["latest_version"] = latest
    if found and is_all:
        found["update_available"] = _is_newer(latest, installed)
    return found


def _read_latest(text: str) -> Readings:
    return {"latest_version": None if text == "None" else clean_text(text, _VERSION_LONGEST)} if text else NO_READINGS


def _version(value: object) -> str | None:
    if isinstance(value, (int, float)):
        return shown(value)
    return clean_text(value, _VERSION_LONGEST) if isinstance(value, str) else None


def _is_newer(latest: str | None, installed: str | None) -> bool | None:
    """Numbers are compared as such; of other versions only whether they differ is known."""
    if latest is None or installed is None:
        return None
    if latest.isdecimal() and installed.isdecimal():
        return int(latest) > int(installed)
    return latest != installed


@dataclass(frozen=True, slots=True)
class _ReadOnlyCodec:
    """Reads as another codec does, and refuses all commands."""

    reader: Codec

    def topics(self) -> tuple[str, ...]:
        return self.reader.topics()

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        return self.reader.read(topic, payload, retained=retained)

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:  # noqa: ARG002 - the interface has them
        raise RefusedError(f"{shown(capability)} of an update", "installing software is for people to decide")
