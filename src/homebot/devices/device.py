"""Messages about a device as known to the directory."""

from collections.abc import Iterable
from typing import ClassVar, Literal, TypeAlias

from homebot.devices.capabilities import DANGERS, EVENTS
from homebot.devices.part import Part
from homebot.devices.value import UNKNOWN, Reading, SetBy, Value
from homebot.errors import InvalidNameError, RefusedError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.key_value import KeyValue as KeyValue
from homebot.messages.message import Message
from homebot.names import validate_node_name

Freshness: TypeAlias = Literal["fresh", "unconfirmed", "stale"]
ChangeKind: TypeAlias = Literal[
    "appeared", "changed", "stale", "returned", "removed", "merged", "unmerged", "conflict", "resolved"
]

EVERYTHING: tuple[str, ...] = ("*",)
"""The capabilities of a :class:`Route` that accepts every command of the part."""

FIRST_REPORTS = 600.0
"""Seconds in which a new device reports each of its values."""


class Endpoint(Message):
    """One way to reach a device.

    Attributes:
        address: The address on which the device publishes, in the gateway's own terms (MQTT: the topic).
        command_address: The address to which it is subscribed; empty if it takes no commands.
        freshness: As for :class:`Device`, judged by messages of this gateway alone.
        last_seen: The time of its latest message or announcement there.
        reachable: ``yes``, ``no`` or ``unknown``: whether it is reachable there, as reported by it or the gateway.
        claimed: Whether only its own announcement says that it is this device. It gets no commands until it has
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
    """One way to reach a part, through ``send_command`` and ``readings`` of a gateway.

    Attributes:
        takes: Names of the capabilities that can be set through it, or :data:`EVERYTHING`.
        approved: The digest of its description if the owner approved exactly this description, else empty; see
            :mod:`homebot.devices.part`.
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
        """Return whether *capability* can be set through it."""
        return self.takes == EVERYTHING or capability in self.takes


class DevicePart(Message):
    """A part of a device, merged from all its announcements.

    Attributes:
        id: Unique in the device; it stays the same when announcements are added or replaced.
        part: Its description from the best route, with the capabilities of all routes.
        routes: The ways to send it commands, best first: those by which it is reachable and was heard recently, then
            those of the device's own announcements, then the older ones. The first that accepts a command and has a
            running gateway is used. Empty while another device claims its topics; see
            :attr:`Device.conflicts`.
    """

    id: str
    part: Part
    routes: tuple[Route, ...]


class Fact(Message):
    """One fact about a device, with its source and time.

    Attributes:
        name: Its subject: ``name``, ``area``, or a metadata key such as ``model``.
        gateway: The gateway of the announcement; empty for a fact that the owner states.
        convention: The convention of the announcement; ``owner`` for a fact that the owner states.
        key: The announcement's key; for a fact that the owner states, ``configuration``, ``command`` or ``import``.
        said_at: When it was first announced there, or stated.
    """

    name: str
    value: str
    gateway: str
    convention: str
    key: str
    said_at: Time


class Reachability(Message):
    """The reachability of a device, as reported by itself or its last will."""

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
        is_first: Whether it is the first value since homebot started; it may be older than *since*.
    """

    part: str
    capability: str
    value: Value
    since: Time
    told_at: Time
    live: bool
    is_first: bool = False


class Device(Message):
    """A device in the house, described by all its announcements together.

    Attributes:
        id: Unique in this homebot, for example ``lights/roomlights405``; renaming the device does not change it.
        service_type: Its main type: a device type of the vocabulary, for example ``light``; for a device that does not
            announce itself, the topic level SERVICE_TYPE, for example ``lights``.
        endpoints: The addresses for raw messages and texts, at least one, one for each gateway, in the order of
            :attr:`DevicePart.routes`.
        first_seen: The time of its first message or announcement.
        last_seen: The time of its latest message or announcement, to about a second.
        expires: When it becomes stale unless something is received.
        freshness: ``fresh``: the device itself reported; ``unconfirmed``: it is known only from a retained message or
            from the index file; ``stale``: it has not reported for too long.
        service_types: The types of all its parts: device types of the vocabulary, then the types that it advertised.
        area: Its room: the one that the owner states, else the one that it announces; empty if none is known.
        outer_areas: The areas that contain the room: its floor, if one is stated, and the home.
        tags: The words with which the owner tagged it.
        names: All its names, :attr:`name` first.
        identifiers: Its identifiers, such as hardware addresses; see :func:`homebot.devices.identity.identifiers`.
        facts: Facts about it, each with its source and time; among those with one name, the one in use comes first. The
            owner states ``area``, ``name`` for an alias, ``tag``, and ``approved``; ``changed_since_approval`` has the
            announcement that changed since.
        reachable: Whether it can be reached, as its parts together report.
        offline_parts: The ids of parts that report that they cannot be reached.
        states: The latest value of each capability of its parts.
        events: The latest event of each capability that has events, such as a button press.
        evidence: Why its announcements are considered one device, as text; empty for a single announcement.
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

    def may_be_old(self, state: State) -> bool:
        """Return whether the value of *state* may be older than its time: the first one, but for dangers.

        A leak sensor may report nothing but water: of a device that was known long before, also if it was away
        meanwhile, that is new, unless the message is retained.
        """
        if not (state.is_first and state.live and state.capability in DANGERS and state.value.flag):
            return state.is_first
        return state.since.to_seconds() - self.first_seen.to_seconds() <= FIRST_REPORTS

    def part(self, part_id: str) -> DevicePart | None:
        """Return the part with that id; None if there is none."""
        for part in self.parts:
            if part.id == part_id:
                return part
        return None


class DeviceChange(Message):
    """A change of a device in the directory.

    Attributes:
        kind: ``appeared``, ``changed``, ``stale``, ``returned`` (from stale) or ``removed``; ``merged``: further
            announcements, or the device *other*, are now part of this device; ``unmerged``: some of its announcements
            are now the device *other*; ``conflict``: another announcement contradicts it, but nothing else changed;
            ``resolved``: a contradiction has ended.
        device: The device after the change; for a removed device, before it.
        sequence: A number that grows with every change; a snapshot has the number of its last change.
        other: The id of the other device concerned; empty if there is none.
    """

    key_field: ClassVar[str | None] = "device.id"

    kind: ChangeKind
    device: Device
    sequence: int
    why: str
    other: str = ""


class ChangedSetting(Message):
    """A new value of something that people and programs set (:data:`homebot.devices.capabilities.SETTABLE`).

    Or of something that alerts are about (:data:`homebot.devices.capabilities.ALERTING`).

    Attributes:
        was_absent: Whether the device was unreachable since the value before, so that it may have changed by itself.
        set_by: See :attr:`homebot.devices.gateway_messages.Report.set_by`.
        before: The last known value before it by any route of the part; unknown if there was none.
        before_since: When that was first reported.
    """

    device: str
    part: str
    capability: str
    value: Value
    told_at: Time
    was_absent: bool = False
    set_by: SetBy = ""
    before: Value = UNKNOWN
    before_since: Time = Time(sec=0, nanosec=0)


class ChangedSettings(Message):
    """The changes of settings that devices reported within half a second.

    Attributes:
        changes: The first and the newest value of each setting; of two numbers other than 0, only the newest.
    """

    changes: tuple[ChangedSetting, ...]


class StateChange(Message):
    """An event, or the values that one message of a device changed.

    Attributes:
        stream: A key of the device, parts and capabilities that changed: the newest change of each key is never lost.
            Each event has its own key, so a slow reader loses none of the last hundred.
        readings: The new values, at least one; or only the event.
        live: Whether the device itself reported them; False if they are known only from a retained message.
        sequence: A number that grows with every change, in the same series as those of :class:`DeviceChange`.
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

    def state_of(self, reading: Reading, *, is_first: bool = False) -> State:
        """Return the state that corresponds to *reading*, one of :attr:`readings`; *is_first* as in it."""
        return State(
            part=reading.part,
            capability=reading.capability,
            value=reading.value,
            since=self.told_at,
            told_at=self.told_at,
            live=self.live,
            is_first=is_first,
        )


def part_names(devices: Iterable[Device]) -> dict[str, str]:
    """Return the names of *devices* by id, and those of their parts by ``ID#PART``.

    Parts are named only if several of them, not counting settings, take commands; else the device's name is enough.
    """
    names: dict[str, str] = {}
    for device in devices:
        names[device.id] = device.name
        parts = [part for part in device.parts if is_commanded(part.part)]
        if len(parts) > 1:
            names |= {f"{device.id}#{part.id}": f"{device.name} {part.part.name or part.id}".rstrip() for part in parts}
    return names


def target_of(device_id: str, part_id: str) -> str:
    """Return the id of a part in the house: the id of its device, with ``#`` and the part's own id if it has one."""
    return f"{device_id}#{part_id}" if part_id else device_id


def is_commanded(part: Part) -> bool:
    """Return whether *part* takes commands and is not a setting."""
    return not part.category and any(capability.settable for capability in part.capabilities)


def check_gateway(endpoint: Endpoint) -> None:
    """Refuse an endpoint whose gateway cannot exist, so that it does not end an app.

    Raises:
        RefusedError: The name of its gateway is not a valid node name.
    """
    try:
        validate_node_name(endpoint.gateway)
    except InvalidNameError as exc:
        raise RefusedError(f"the endpoint {endpoint.key[:100]}", str(exc)) from exc
