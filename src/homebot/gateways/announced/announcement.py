"""One registered announcement: the description of its device, and the device's last sign of life. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import starmap
from types import MappingProxyType
from typing import Any, Literal, TypeAlias

from homebot.conventions.description import Availability, DescribedPart, DeviceAnnounced, Publications, TextEndpoint
from homebot.conventions.unreadable import Unreadable
from homebot.devices import KeyValue, Sighting
from homebot.devices.capabilities import EVENTS, MOMENTARY
from homebot.devices.gateway_messages import Command
from homebot.devices.names import text_address
from homebot.devices.part import Part
from homebot.devices.text.commands import accepts_text, main_part
from homebot.devices.value import PlainValue, Reading, Value
from homebot.errors import WireError
from homebot.gateways.raw_delivery import PartTexts
from homebot.messages import Time

SightingKind: TypeAlias = Literal["appeared", "updated", "removed"]

_NOTHING: Mapping[str, Any] = MappingProxyType({})
"""A shared empty mapping: most devices need none of their own, and an empty dict takes 64 bytes."""

# Looked up once: pydantic's metaclass makes each look-up on a message type cost as much as a call.
_reading_of, _sighting_of, _value_of = Reading.of_checked, Sighting.of_checked, Value.of

_PLAIN = frozenset({bool, float})
_MAX_STREAMS = 1000
"""Report streams of one device, which may have 500 properties with a topic each; the rest share one."""

_MAX_READINGS = 100
_NEVER = Time(sec=0, nanosec=0)
_UNPUBLISHED: Mapping[str, Any] = {
    "kind": "updated",
    "why": "",
    "seen_at": _NEVER,
    "expires_at": _NEVER,
    "confirmed": False,
    "heard_at": 0.0,
}
"""The fields that differ from one sighting to the next, with their values before the first."""

_NO_ENDPOINT = TextEndpoint("", "", "")
_ONLY_TEXTS = frozenset({str})


@dataclass(slots=True)
class UnreadableCount:
    """The payloads that a part could not read.

    Attributes:
        found: The values of the last payload, which came on *address*.
        reported: How many of them are reported.
        report_at: When one more may be reported, by the monotonic clock.
    """

    count: int = 0
    found: tuple[Unreadable, ...] = ()
    address: str = ""
    is_retained: bool = False
    reported: int = 0
    report_at: float = 0.0


@dataclass(slots=True, eq=False)
class AnnouncedPart(PartTexts):
    """One part of a described device, and its last reports.

    Attributes:
        address: Address of its texts: the gateway's text address, or the one on which the device publishes text.
        filters: The filters on which it is read.
        known: The last value of each capability with its reading; None before the first report.
        names: The capabilities of its last short state; states with the same capabilities share the tuple.
        is_plain: Whether it has only ever reported numbers and flags, and no events.
        unreadable: The payloads that it could not read; None for none.
        sent: The last command with its messages, which its reports may refuse; None for none.
    """

    stored: StoredAnnouncement
    described: DescribedPart
    address: str
    filters: tuple[str, ...] = field(default=(), init=False)
    known: dict[str, tuple[PlainValue, Reading]] | None = field(default=None, init=False)
    names: tuple[str, ...] = field(default=(), init=False)
    is_plain: bool = field(default=True, init=False)
    unreadable: UnreadableCount | None = field(default=None, init=False)
    sent: tuple[Command, Publications] | None = field(default=None, init=False)

    def reports(self, capability: str) -> bool:
        """Return whether it reports *capability* as a lasting value, which can confirm a command."""
        capabilities = self.described.part.capabilities
        return capability not in MOMENTARY and any(
            candidate.name == capability and candidate.readable for candidate in capabilities
        )

    def readings(self, values: Mapping[str, PlainValue]) -> list[Reading]:
        """Return *values* as readings; an unchanged value keeps its reading.

        Raises:
            pydantic.ValidationError: A value or the name of a capability is invalid.
        """
        readings = []
        if (known := self.known) is None:
            known = self.known = {}
        part = self.described.part.id
        for name, value in values.items():
            if name in known:
                last, reading = known[name]
                if last != value or type(last) is not type(value):
                    reading = _reading_of(part=part, capability=name, value=_value_of(value))
                    known[name] = value, reading
                    if type(value) not in _PLAIN:
                        self.is_plain = False
            else:
                make = _reading_of if str.isascii(name) else Reading
                reading = make(part=part, capability=name, value=_value_of(value))
                self.is_plain = self.is_plain and type(value) in _PLAIN and name not in EVENTS
                if len(known) < _MAX_READINGS:
                    known[name] = value, reading
            readings.append(reading)
        return readings


class SharedReachability:
    """The last availability reports of a device, and what they mean together.

    All announcements of a device with equal availabilities share it, as most have.

    Attributes:
        value: True if the device can be reached; None for unknown.
        members: The announcements that use it, each with a part; ``""`` is the whole device.
        subscriptions: The filters on which it is read, each with its reader.
    """

    __slots__ = ("_latest", "_reports", "address", "availability", "members", "subscriptions", "value")

    def __init__(self, availability: Availability) -> None:
        self.availability = availability
        self.value: bool | None = None
        self.members: list[tuple[StoredAnnouncement, str]] = []
        self.subscriptions: list[tuple[str, AvailabilityReader]] = []
        self.address = ""
        self._reports: list[tuple[bool, bool] | None] = [None] * len(availability.sources)
        self._latest: tuple[bool, bool] | None = None

    def update(self, index: int, is_reachable: bool, *, retained: bool) -> None:  # noqa: FBT001 - the report of the source
        """Record the report of source *index*."""
        self._reports[index] = self._latest = is_reachable, retained
        self.value = self._combine()

    def discard_retained_offline(self) -> None:
        """Forget each retained "offline", now that the device has spoken: many are never cleared.

        An "offline" received live stays, and so does every "online".
        """
        if self._latest == _RETAINED_OFFLINE:
            self._latest = None
        self._reports = [None if report == _RETAINED_OFFLINE else report for report in self._reports]
        self.value = self._combine()

    def _combine(self) -> bool | None:
        if self.availability.mode == "latest":
            return self._latest[0] if self._latest is not None else None
        known = [report[0] for report in self._reports if report is not None]
        decisive = self.availability.mode == "any"
        if decisive in known:
            return decisive
        return not decisive if len(known) == len(self._reports) else None


_RETAINED_OFFLINE = (False, True)


@dataclass(frozen=True, slots=True)
class AvailabilityReader:
    """One address that reports whether a device, or some of its parts, can be reached."""

    reachability: SharedReachability
    index: int


@dataclass(slots=True, eq=False)
class StoredAnnouncement:
    """A device, or one announcement of a device, that a gateway publishes.

    Attributes:
        excess: Bytes beyond the length that its number of parts justifies.
        since: Its place in the order of announcements with these topics; 0 if it was retained, as their order is lost.
        reachability: Reported reachability of the device (``""``) and of the parts that report it.
        is_confirmed: Whether the last sighting was a sign of life of the device itself.
        heard_at: When it last reported or was announced live, on the monotonic clock; -inf for never.
        refresh_at: When, on the monotonic clock, the next sign of life is due for a sighting.
        reachable: Whether the device (``""``) and its parts can be reached, as last published.
        report_streams: The report streams that late joiners get, by address and reported values.
        template: Its last sighting; before the first one, the fields that all of them share.
    """

    gateway: str
    key: str
    described: DeviceAnnounced
    excess: int = 0
    since: int = 0
    parts: dict[str, AnnouncedPart] = field(init=False)
    reachability: Mapping[str, SharedReachability] = field(init=False)
    is_confirmed: bool = field(default=False, init=False)
    heard_at: float = field(default=-math.inf, init=False)
    refresh_at: float = field(default=0.0, init=False)
    reachable: Mapping[str, bool | None] = field(init=False)
    report_streams: dict[tuple[object, ...], str] = field(default_factory=dict, init=False)
    template: Sighting = field(init=False)

    def __post_init__(self) -> None:
        described, text = self.described, self.described.text
        self.parts, self.reachability, self.reachable = {}, _NOTHING, _NOTHING
        shown: list[Part] = []
        for announced_part in described.parts:
            part = announced_part.part.id
            if announced_part.part.service_type:
                shown.append(announced_part.part)
            self.parts[part] = AnnouncedPart(
                self, announced_part, text_address(self.key, part) if text is None else text.address
            )
        self.template = self._template(tuple(shown))  # so that an invalid one fails at once

    def publishes_the_same(self, other: StoredAnnouncement) -> bool:
        """Return whether the graph would see no difference."""
        return self.template.model_copy(update=_UNPUBLISHED) == other.template.model_copy(update=_UNPUBLISHED)

    def has_topics_of(self, other: StoredAnnouncement) -> bool:
        """Return whether it reads and writes the topics of *other*, and no more."""
        return self._topics() == other._topics()

    def _topics(self) -> frozenset[str]:
        described = self.described
        available = [
            two for two in (described.availability, *(part.availability for part in described.parts)) if two is not None
        ]
        parts = [topic for part in described.parts for topic in (*part.part.reads, *part.part.writes)]
        return frozenset((*parts, *(source.topic for two in available for source in two.sources)))

    def report_stream(self, *source: object) -> str:
        """Return the name of the report stream of *source*: an address, and the names of the reported values.

        A report replaces only reports of the same values. Beyond 1,000 sources, those of a device share a stream.
        """
        if source not in self.report_streams and len(self.report_streams) >= _MAX_STREAMS:
            source = ("*",)
        name = self.report_streams.get(source)
        if name is None:
            number = sum(stream[0] == source[0] for stream in self.report_streams)
            name = self.report_streams[source] = f"{self.key} {source[0]} {number}"
        return name

    def copy_state(self, before: StoredAnnouncement) -> None:
        """Copy the state of the device from the announcement *before* this one."""
        self.is_confirmed = before.is_confirmed
        self.heard_at, self.refresh_at = before.heard_at, before.refresh_at
        self.report_streams = before.report_streams
        known = {
            part: is_reachable
            for part, is_reachable in before.reachable.items()
            if part in self.reachability or part not in before.reachability  # known to the gateway itself
        }
        self.reachable = known or _NOTHING
        for part_id, announced_part in self.parts.items():
            if (old := before.parts.get(part_id)) is not None:
                announced_part.copy_texts(old)
                announced_part.unreadable, announced_part.sent = old.unreadable, old.sent

    def detach(self) -> None:
        """Drop its parts, which refer back to it, so that it is freed without the garbage collector."""
        self.parts, self.reachability = {}, _NOTHING

    def record_reachable(self, part: str, reachable: bool | None) -> None:  # noqa: FBT001 - the value itself
        """Record the published reachability of *part*."""
        if not isinstance(self.reachable, dict):
            self.reachable = {}
        self.reachable[part] = reachable

    def _template(self, parts: tuple[Part, ...]) -> Sighting:
        """Return the common fields of its sightings; the addresses are those of the main part's texts.

        A device that publishes text by itself has the addresses and the service type of that text.

        Raises:
            WireError: A name or an address is not a string.
            pydantic.ValidationError: A fact is invalid.
        """
        described = self.described
        endpoint = text = described.text
        if endpoint is None and (main := main_part(parts)) is not None:
            address = self.parts[main.id].address
            endpoint = TextEndpoint(main.service_type, address, address if accepts_text(main) else "")
        endpoint = endpoint or _NO_ENDPOINT
        announced_on = described.topic if text is None else ""
        texts = (self.key, described.name, described.area, *endpoint, announced_on)
        if not _ONLY_TEXTS.issuperset(map(type, (*texts, *described.identifiers, *described.owns))):
            raise WireError(f"{self.key!r} has names or topics that are no texts: {texts!r}")
        return _sighting_of(
            gateway=self.gateway,
            key=self.key,
            **_UNPUBLISHED,
            name=described.name,
            service_type=endpoint.service_type,
            address=endpoint.address,
            command_address=endpoint.command_address,
            metadata=tuple(starmap(_fact, described.facts.items())),
            convention=described.convention if text is None else "",
            native=described.native or text is not None,
            whole_device=described.whole_device,
            identifiers=described.identifiers,
            authenticated=False,
            area=described.area,
            parts=parts,
            owns=described.owns,
            announced_on=announced_on,
        )


@lru_cache(maxsize=10_000)  # devices share many facts
def _fact(key: str, value: str) -> KeyValue:
    return KeyValue(key=key, value=value).slimmed()
