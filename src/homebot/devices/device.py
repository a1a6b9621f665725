"""Messages about a device, as the directory knows it."""

from collections.abc import Iterable
from typing import ClassVar, Literal, TypeAlias

from homebot.devices.capabilities import EVENTS
from homebot.devices.part import Part
from homebot.devices.value import Reading, Value
from homebot.errors import InvalidNameError, RefusedError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message
from homebot.names import validate_node_name

__all__ = [
    "EVERYTHING",
    "ChangeKind",
    "ChangedSetting",
    "ChangedSettings",
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
    "is_commanded",
    "part_names",
    "target_of",
]

Freshness: TypeAlias = Literal["fresh", "unconfirmed", "stale"]
ChangeKind: TypeAlias = Literal[
    "appeared", "changed", "stale", "returned", "removed", "merged", "unmerged", "conflict", "resolved"
]

EVERYTHING: tuple[str, ...] = ("*",)
"""The capabilities of a :class:`Route` that accepts every command of the part."""


class Endpoint(Message):
    """One way to reach a device.

    Attributes:
        address: The address on which the device publishes, in the gateway's own terms (MQTT: the topic).
        command_address: The address to which it is subscribed; empty when it takes no commands.
        freshness: As for :class:`Device`, from messages of this gateway alone.
        last_seen: The time of its latest message or announcement there.
        reachable: ``yes``, ``no`` or ``unknown``: whether it can be reached there, as it or the gateway reports it.
        claimed: Whether nothing but its own announcement says that it is this device. It gets no commands until it has
            reported the same changes as another endpoint, or the owner has confirmed it.
    """

    gateway: str
    key: str
    address: str
    command_address: str
    freshness: Freshness = "fresh"
    last_seen: Time = Time(sec=0, nanosec=0)
    reachable: Literal["yes", "no", "unknown"] = "unknown"
    claimed: bool = False


class Route(Message):
    """One way to reach a part, by the gateway's ``send_command`` and ``readings``.

    Attributes:
        takes: Names of the capabilities that can be set by it, or :data:`EVERYTHING`.
        approved: The digest of its description, if the owner approved exactly that; else empty. See
            :mod:`homebot.devices.command_description`.
        topics: The announced addresses for commands, which were compared with those of other devices.
    """

    gateway: str
    key: str
    part: str
    convention: str = ""
    takes: tuple[str, ...] = EVERYTHING
    approved: str = ""
    topics: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Its gateway and key, such as ``mqtt/shelly:hall``."""
        return f"{self.gateway}/{self.key}"

    def can(self, capability: str) -> bool:
        """Return whether *capability* can be set by it."""
        return self.takes == EVERYTHING or capability in self.takes


class DevicePart(Message):
    """A part of a device, merged from all announcements of it.

    Attributes:
        id: Unique in the device; it stays the same when announcements are added or replaced.
        part: Its description by the best route, with the capabilities of all routes.
        routes: The ways to send it commands, best first: those by which it can be reached and was heard lately, then
            those of the device's own announcements, then the older ones. Of those that accept a command, the first
            with a running gateway is used. Empty while another device claims its topics; see
            :attr:`Device.conflicts`.
    """

    id: str
    part: Part
    routes: tuple[Route, ...]


class Fact(Message):
    """One fact about a device, with its source and time.

    Attributes:
        name: Its subject: ``name``, ``area``, or a name of the metadata such as ``model``.
        gateway: The gateway of the announcement; empty for a fact that the owner states.
        convention: The convention of the announcement; ``owner`` for a fact that the owner states.
        key: In which announcement; for a fact that the owner states ``configuration``, ``command`` or ``import``.
        said_at: The time at which this was first announced there, or stated.
    """

    name: str
    value: str
    gateway: str
    convention: str
    key: str
    said_at: Time


class Reachability(Message):
    """The reachability of a device, as it or its last will reports it."""

    state: Literal["yes", "no", "unknown"] = "unknown"
    since: Time = Time(sec=0, nanosec=0)
    why: str = "it does not report it"


class State(Message):
    """The latest value of one capability of a device, or its latest event.

    Attributes:
        value: The value, in the unit of the vocabulary; ``value.plain()`` gives it as a Python value.
        since: The time of the first report of this value.
        told_at: The time of the latest report.
        live: Whether the device itself reported it; False if it is known only from a retained message.
        is_first: Whether it is the first value since homebot started: it may have been so before *since*.
    """

    part: str
    capability: str
    value: Value
    since: Time
    told_at: Time
    live: bool
    is_first: bool = False


class Device(Message):
    """A device in the house, as all its announcements together describe it.

    Attributes:
        id: Unique in this homebot, for example ``lights/roomlights405``; renaming the device does not change it.
        service_type: Its main type: the level SERVICE_TYPE of the topic of a device that does not announce itself, for
            example ``lights``; otherwise a device type of the vocabulary, for example ``light``.
        endpoints: The addresses for raw messages and texts: one for each gateway, at least one, in the order of
            :attr:`DevicePart.routes`.
        first_seen: The time of its first message or announcement.
        last_seen: The time of its latest message or announcement, to about a second.
        expires: The time at which it becomes stale if nothing more is received.
        freshness: ``fresh``: the device itself reported; ``unconfirmed``: it is known only from a retained message or
            from the index file; ``stale``: it has not reported for too long.
        service_types: The types of all its parts: device types of the vocabulary, then the types that it advertised.
        area: The room that it is in: the one that the owner states, else the one that it announces; empty if none is
            known.
        outer_areas: The areas that the room is in: its floor, where one is stated, and the home.
        tags: The words that the owner tagged it with.
        names: Every name it has, :attr:`name` first.
        identifiers: Its identifiers, such as hardware addresses; see :func:`homebot.devices.identity.identifiers`.
        facts: Facts about it, each with its source and time; of several with one name, the one in use comes first.
            Those that the owner states are ``area``, ``name`` for an alias, ``tag``, and ``approved``; a change
            since is ``changed_since_approval``, with the announcement that changed.
        reachable: Whether it can be reached, as its parts together report.
        offline_parts: The ids of parts that report that they cannot be reached.
        states: The latest value of each capability of its parts.
        events: The latest event of each capability that has events, such as a button press.
        evidence: The reasons why its announcements are one device, as text; empty for a single announcement.
        conflicts: Contradictions between its announcements, as text; the facts concerned are not used until they are
            resolved.
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
    outer_areas: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()

    def part(self, part_id: str) -> DevicePart | None:
        """Return the part, or None if the device has none of that id."""
        for part in self.parts:
            if part.id == part_id:
                return part
        return None


class DeviceChange(Message):
    """A change of a device in the directory.

    Attributes:
        kind: ``appeared``, ``changed``, ``stale``, ``returned`` (from stale) or ``removed``; ``merged``: further
            announcements, or the device *other*, are now part of this device; ``unmerged``: some of its announcements
            are now the device *other*; ``conflict``: another announcement contradicts it, and nothing else changed;
            ``resolved``: a contradiction has ended.
        device: The device after the change; before it where it was removed.
        sequence: A number that grows with every change; a snapshot has the number of the last change in it.
        other: The id of the other device concerned; empty if there is none.
    """

    key_field: ClassVar[str | None] = "device.id"

    kind: ChangeKind
    device: Device
    sequence: int
    why: str
    other: str = ""


class ChangedSetting(Message):
    """A new value of a setting of people and programs (:data:`homebot.devices.capabilities.SETTABLE`)."""

    device: str
    part: str
    capability: str
    value: Value
    told_at: Time


class ChangedSettings(Message):
    """The settings that devices reported anew within half a second.

    Attributes:
        changes: The first new value of each, and the newest one; of a number that changes to another the newest alone.
    """

    changes: tuple[ChangedSetting, ...]


class StateChange(Message):
    """The values that one message of a device changed, or an event.

    Attributes:
        stream: The device with the parts and capabilities that changed, as one key: the newest change of the same ones
            is never lost. Each event has a key of its own, so that a slow reader loses none of the last hundred.
        readings: The new values, at least one; or the event alone.
        live: Whether the device itself reported them; False if they are known only from a retained message.
        sequence: A number that grows with every change, in one series with those of :class:`DeviceChange`.
    """

    key_field: ClassVar[str | None] = "stream"

    stream: str
    device: str
    readings: tuple[Reading, ...]
    told_at: Time
    live: bool
    sequence: int

    @property
    def is_event(self) -> bool:
        """True if it is an event, which has no duration, such as a button press."""
        return self.readings[0].capability in EVENTS

    @property
    def states(self) -> tuple[State, ...]:
        """The new values, or the event, as states of the device."""
        return tuple([self.state_of(reading) for reading in self.readings])

    def state_of(self, reading: Reading) -> State:
        """Return the state that *reading*, one of :attr:`readings`, tells."""
        return State(
            part=reading.part,
            capability=reading.capability,
            value=reading.value,
            since=self.told_at,
            told_at=self.told_at,
            live=self.live,
            is_first=False,
        )


def part_names(devices: Iterable[Device]) -> dict[str, str]:
    """Return the names of *devices* by their ids, and those of their parts by ``ID#PART``.

    Parts are named only where several of them take commands, settings aside; else the name of the device tells enough.
    """
    names: dict[str, str] = {}
    for device in devices:
        names[device.id] = device.name
        parts = [one for one in device.parts if is_commanded(one.part)]
        if len(parts) > 1:
            names |= {f"{device.id}#{one.id}": f"{device.name} {one.part.name or one.id}".rstrip() for one in parts}
    return names


def target_of(device_id: str, part_id: str) -> str:
    """Return the name of a part: the id of its device, with ``#`` and the id of the part if it has one."""
    return f"{device_id}#{part_id}" if part_id else device_id


def is_commanded(part: Part) -> bool:
    """Return whether *part* takes commands, and is no setting."""
    return not part.category and any(one.settable for one in part.capabilities)


def check_gateway(endpoint: Endpoint) -> None:
    """Refuse an endpoint of something that cannot be a gateway: an app must not end because of it.

    Raises:
        RefusedError: The name of its gateway is no name of a node.
    """
    try:
        validate_node_name(endpoint.gateway)
    except InvalidNameError as exc:
        raise RefusedError(f"the endpoint {endpoint.key[:100]}", str(exc)) from exc
