"""What the directory knows of a device."""

from __future__ import annotations

from typing import ClassVar, Literal, TypeAlias

from homebot.devices.part import Part
from homebot.devices.value import Value
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = [
    "EVERYTHING",
    "ChangeKind",
    "Device",
    "DeviceChange",
    "DevicePart",
    "Endpoint",
    "Fact",
    "Freshness",
    "KeyValue",
    "Reachability",
    "Route",
    "State",
    "StateChange",
]

Freshness: TypeAlias = Literal["fresh", "unconfirmed", "stale"]
ChangeKind: TypeAlias = Literal[
    "appeared", "changed", "stale", "returned", "removed", "merged", "unmerged", "conflict", "resolved"
]

EVERYTHING: tuple[str, ...] = ("*",)
"""What a :class:`Route` takes by which the part can be told all that it can be told at all."""


class KeyValue(Message):
    """One fact about a device, as its gateway heard it."""

    ros_type: ClassVar[str] = "diagnostic_msgs/msg/KeyValue"

    key: str
    value: str


class Endpoint(Message):
    """One way to reach a device.

    Attributes:
        gateway: Name of the gateway that hears the device.
        key: What that gateway calls the device.
        address: Where the device speaks, in the gateway's own terms (MQTT: the topic of its messages).
        command_address: Where the device listens; empty when it takes no commands.
    """

    gateway: str
    key: str
    address: str
    command_address: str


class Route(Message):
    """One way to reach a part, by the gateway's ``send_command`` and ``readings``.

    Attributes:
        gateway: Name of the gateway.
        key: What that gateway calls the announcement.
        part: What the part is called there.
        convention: By which convention it was announced.
        takes: Names of the capabilities that can be told by it, or :data:`EVERYTHING`.
    """

    gateway: str
    key: str
    part: str
    convention: str = ""
    takes: tuple[str, ...] = EVERYTHING

    def can(self, capability: str) -> bool:
        """Whether the part can be told *capability* by it."""
        return self.takes == EVERYTHING or capability in self.takes


class DevicePart(Message):
    """Something a device offers, however many announcements speak of it.

    Attributes:
        id: Unique in the device, and lasting: it stays when other announcements tell of the part too, or instead.
        part: What it is, as its best route describes it, with the capabilities of all routes.
        routes: The ways to it, best first: a command goes by the first that takes it and whose gateway is there. Empty
            while another device has a claim to its topics; see :attr:`Device.conflicts`.
    """

    id: str
    part: Part
    routes: tuple[Route, ...]


class Fact(Message):
    """One thing that was said of a device, and who said it when.

    Attributes:
        name: What it is about: ``name``, ``area``, or a name of the metadata such as ``model``.
        value: What was said.
        gateway: The gateway that heard it.
        convention: By which convention it was said.
        key: In which announcement.
        said_at: When this was first said there.
    """

    name: str
    value: str
    gateway: str
    convention: str
    key: str
    said_at: Time


class Reachability(Message):
    """Whether a device can be reached, by what it or its last will says.

    Attributes:
        state: ``yes``, ``no`` or ``unknown``.
        since: Since when that is so.
        why: The reason, in words.
    """

    state: Literal["yes", "no", "unknown"] = "unknown"
    since: Time = Time(sec=0, nanosec=0)
    why: str = "it does not say"


class State(Message):
    """The value of a capability, as it was last told.

    Attributes:
        part: Which part of the device; see :attr:`DevicePart.id`.
        capability: Which capability.
        value: Its value in the vocabulary's unit.
        since: Since when it has this value, as far as was heard.
        told_at: When it was last told.
        live: Whether the device told it, rather than a message that the broker had kept.
    """

    part: str
    capability: str
    value: Value
    since: Time
    told_at: Time
    live: bool


class Device(Message):
    """A device in the house, as all its announcements together describe it.

    Attributes:
        id: Unique in this homebot, for example ``lights/roomlights405``; renaming the device does not change it.
        name: The name for people.
        service_type: What it offers in the first place: the word of a device that speaks plain words by itself, for
            example ``lights``, else a device type of the vocabulary.
        endpoints: The ways to reach it in raw or plain words, at least one.
        metadata: Further facts.
        first_seen: The time of its first message or announcement.
        last_seen: The time of its latest message or announcement, to about a second.
        expires: The time at which it becomes stale if nothing more is received.
        freshness: ``fresh``: it spoke itself; ``unconfirmed``: only a message that the broker had kept, or the index
            file, speaks for it; ``stale``: it has been silent for too long.
        service_types: All that it offers: device types of the vocabulary, then the advertised words.
        area: The room that it is in; empty where none is known.
        names: Every name it has, :attr:`name` first.
        identifiers: Who it is; see :func:`homebot.devices.identity.identifiers`.
        parts: Its parts, each once.
        facts: What was said of it, by whom, and when; of each name the one that counts first.
        reachable: Whether it can be reached, as its parts together report.
        offline_parts: The ids of parts that report that they cannot be reached.
        states: The latest value of each capability of its parts.
        events: The latest event of each capability that has events, such as a button press.
        evidence: Why its announcements are one device, in words; empty for a single announcement.
        conflicts: What is disputed about it, in words; nothing of that counts until it is resolved.
    """

    id: str
    name: str
    service_type: str
    endpoints: tuple[Endpoint, ...]
    metadata: tuple[KeyValue, ...]
    first_seen: Time
    last_seen: Time
    expires: Time
    freshness: Freshness
    service_types: tuple[str, ...] = ()
    area: str = ""
    names: tuple[str, ...] = ()
    identifiers: tuple[str, ...] = ()
    parts: tuple[DevicePart, ...] = ()
    facts: tuple[Fact, ...] = ()
    reachable: Reachability = Reachability()
    states: tuple[State, ...] = ()
    events: tuple[State, ...] = ()
    offline_parts: tuple[str, ...] = ()
    evidence: tuple[str, ...] = ()
    conflicts: tuple[str, ...] = ()


class DeviceChange(Message):
    """Something happened to a device.

    Attributes:
        kind: ``appeared``, ``changed``, ``stale``, ``returned`` (from stale) or ``removed``; ``merged``: further
            announcements, or the device *other*, turned out to be this device; ``unmerged``: some of them are a device
            of their own, *other*; ``conflict``: somebody else claims what is this device's, and nothing changed;
            ``resolved``: a conflict is over.
        device: The device after the change; before it where it was removed.
        sequence: Grows with every change and never goes back; a snapshot names the last one it holds.
        why: The reason, in words.
        other: Id of the other device that is concerned; empty where there is none.
    """

    key_field: ClassVar[str | None] = "device.id"

    kind: ChangeKind
    device: Device
    sequence: int
    why: str
    other: str = ""


class StateChange(Message):
    """A capability of a device has another value, or an event happened.

    Attributes:
        stream: Device, part and capability in one: of each the newest change is never lost. Each event has a stream of
            its own, so that a reader who is behind loses none of the last hundred.
        device: Id of the device.
        state: The new state.
        sequence: In one series with those of :class:`DeviceChange`.
    """

    key_field: ClassVar[str | None] = "stream"

    stream: str
    device: str
    state: State
    sequence: int
