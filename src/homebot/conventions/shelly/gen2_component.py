"""One component of a Shelly of the second generation: its topics, its calls, and a part made of it. Pure.

What a component reports comes on three topics: all of it on ``<prefix>/status/<component>`` and in the answer to
``Shelly.GetStatus``, or to ``Shelly.GetComponents`` where people or gateways added it, and what changed on
``<prefix>/events/rpc``.

Source: Shelly Gen2+ API, General, RPC Protocol, RPC Channels (MQTT), Notifications.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeAlias

from homebot.conventions.description import Publication, Publications
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import NO_READINGS, Readings, as_fields, compact_json, read_number, text_of
from homebot.devices.part import Category
from homebot.devices.value import PlainValue

__all__ = [
    "COMPONENTS",
    "Fields",
    "Gen2Topics",
    "ShellyComponent",
    "StatusDecoder",
    "call",
    "components_from",
    "flag",
    "measured",
]


def call(prefix: str, source: str, method: str, params: Mapping[str, object] | None = None) -> Publication:
    """Return the call of *method* of the device at *prefix*; it answers on ``<source>/rpc``."""
    frame: dict[str, object] = {"id": 1, "src": source, "method": method}
    if params is not None:
        frame["params"] = params
    return Publication(f"{prefix}/rpc", compact_json(frame).encode())


COMPONENTS = "Shelly.GetComponents"
"""The method whose answer, in pages, has the components that are not part of the other answers."""


def components_from(offset: int) -> Mapping[str, object]:
    """Return the parameters of :data:`COMPONENTS` for the page that begins at *offset*."""
    return {"dynamic_only": True, "include": ["status", "config"], "offset": offset}


Fields: TypeAlias = Mapping[str, object]
"""A status or a configuration, or a part of one."""

StatusDecoder: TypeAlias = Callable[[Fields], Readings]
"""The readings of a status, or of what changed of one. Never raises."""

_NO_FIELDS: Fields = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Gen2Topics:
    """The topics of a device of the second generation.

    Attributes:
        prefix: What its topics begin with.
        source: As whom we call it; its answers come on ``<source>/rpc``.
        answers: Where it answers questions for its state.
        is_plug: Whether its relays are sockets.
    """

    prefix: str
    source: str
    answers: str
    is_plug: bool = False


@dataclass(frozen=True, slots=True)
class ShellyComponent:
    """One component.

    Attributes:
        topics: Those of its device.
        key: Its name, for example ``switch:0``.
        status: What it reported when it was asked.
        config: How it is set up; empty where that is not known.
        load: What people say that it feeds: ``light``; empty where they say nothing.
        is_inside: Whether it measures the device itself and not its surroundings.
        sender: Name of the device that a gateway hears it from; empty where there is none.
    """

    topics: Gen2Topics
    key: str
    status: Fields
    config: Fields = field(default_factory=dict)
    load: str = ""
    is_inside: bool = False
    sender: str = ""

    @property
    def kind(self) -> str:
        """Type of the component, for example ``switch``."""
        return self.key.partition(":")[0]

    @property
    def index(self) -> int:
        """Number among the components of its type."""
        return int(self.key.partition(":")[2] or 0)

    @property
    def name(self) -> str:
        """Name that people gave it, or what sends it; empty where there is none."""
        name = self.config.get("name")
        return text_of(name) or self.sender

    def part(self, suffix: str, service_type: str, *, tag: str = "", category: Category = "") -> JsonPart:
        """Return a part of it without capabilities; its *suffix* is empty for the main part of the component."""
        part_id = f"{self.key}/{suffix}" if suffix else self.key
        return JsonPart(part_id, service_type, name=self.name, advertised=self.kind, tag=tag, category=category)

    def read_status(self, part: JsonPart, decode: StatusDecoder, key: str = "") -> None:
        """Have *part* read the component, or the one called *key*, with *decode*."""
        key = key or self.key
        prefix = self.topics.prefix
        part.read_from(f"{prefix}/events/rpc", lambda frame: _read(as_fields(frame.get("params")), key, decode))
        part.read_from(f"{prefix}/status/{key}", decode)
        part.read_from(self.topics.answers, lambda frame: _read_answer(as_fields(frame.get("result")), key, decode))

    def add_measure(self, part: JsonPart, field: str, capability: str, factor: float = 1.0, key: str = "") -> None:
        """Have *part* report the number *field* of the component, or of the one called *key*, as *capability*."""
        self.read_status(part, measured(field, capability, factor), key)
        part.add_capability(capability)

    def read_presses(self, part: JsonPart, presses: Mapping[str, str]) -> None:
        """Have *part* read its events, named as in *presses*."""
        key = self.key
        part.read_events_from(f"{self.topics.prefix}/events/rpc", lambda frame: _read_events(frame, key, presses))
        part.add_capability("press", options=tuple(presses.values()))

    def add_command_topic(self, part: JsonPart) -> None:
        """Name the topic that commands to *part* go to."""
        part.add_command_topics(f"{self.topics.prefix}/rpc")

    def call(self, method: str, /, **params: object) -> Publications:
        """Return the call of *method* of this component."""
        return (call(self.topics.prefix, self.topics.source, method, {"id": self.index, **params}),)


def measured(field: str, capability: str, factor: float = 1.0) -> StatusDecoder:
    """Return a reader of one number; ``null`` in its place is *unknown*."""

    def decode(status: Fields) -> Readings:
        if field not in status:
            return NO_READINGS
        return read_number(capability, status[field], lambda number: number * factor)

    return decode


def flag(field: str, capability: str) -> StatusDecoder:
    """Return a reader of one truth; ``null`` in its place is *unknown*."""

    def decode(status: Fields) -> Readings:
        value: object = status.get(field, _NO_FIELDS)
        return {capability: value} if value is None or isinstance(value, bool) else NO_READINGS

    return decode


def _read(components: Fields, key: str, decode: StatusDecoder) -> Readings:
    status = components.get(key)
    return decode(status) if isinstance(status, dict) else NO_READINGS


def _read_answer(result: Fields, key: str, decode: StatusDecoder) -> Readings:
    listed = result.get("components")
    if not isinstance(listed, list):
        return _read(result, key, decode)
    found = next((one for one in map(as_fields, listed) if one.get("key") == key), _NO_FIELDS)
    return _read({key: found.get("status")}, key, decode)


_MOST_EVENTS = 32


def _read_events(frame: Fields, key: str, presses: Mapping[str, str]) -> Readings:
    events = as_fields(frame.get("params")).get("events")
    if not isinstance(events, list):
        return NO_READINGS
    found: dict[str, PlainValue] = {}
    for event in events[:_MOST_EVENTS]:
        fields = as_fields(event)
        name = fields.get("event") if fields.get("component") == key else None
        if isinstance(name, str) and name in presses:
            found["press"] = presses[name]
    return found
