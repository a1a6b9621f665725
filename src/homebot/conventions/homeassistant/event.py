"""The components ``event``, ``device_automation`` and ``tag``: what happens, and is over at once. Pure.

A message that the broker had kept happened before and is ignored: an old doorbell must not ring again.

Source: Home Assistant core 2025.4, ``components/mqtt/event.py``, ``device_trigger.py`` and ``tag.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import StateMessage
from homebot.conventions.payload import NO_READINGS, Readings, clean_text, fields_of, shown
from homebot.errors import WireError

__all__ = ["build_event", "build_tag", "build_trigger"]


def build_event(config: DiscoveryConfig) -> DescribedPart:
    """Describe something that reports events of declared types, such as a doorbell."""
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
        raise WireError("device_automation: it lacks type or subtype")
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
        tag = "" if message.retained else clean_text(text, _LONGEST)
        return {"scan": tag} if tag else NO_READINGS

    entity = Entity(config, "x_tag_reader")
    if entity.read_message_from(source, read):
        entity.add_capability("scan")
    return entity.build()


_LONGEST = 255
