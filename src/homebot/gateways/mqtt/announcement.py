"""One announcement that stands: what it says of its device, and how that device was last heard. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, TypeAlias

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.devices import KeyValue, RawMessage, Sighting
from homebot.devices.text.encode import accepts_text, main_part, text_address
from homebot.gateways.mqtt.channels import missed
from homebot.gateways.mqtt.reachability import ReachabilityReader
from homebot.messages import Time

__all__ = ["AnnouncedPart", "AvailabilityReader", "SightingKind", "StoredAnnouncement"]

SightingKind: TypeAlias = Literal["appeared", "updated", "removed"]

_MAX_STREAMS = 100
_KEPT = 10
_MOMENT = 5.0
"""Seconds for which an event is told to who comes to listen: the first makes its device known, and is heard late."""

_NEVER = Time(sec=0, nanosec=0)


@dataclass(slots=True, eq=False)
class AnnouncedPart:
    """One part of a described device, as it speaks.

    Attributes:
        claim: Whose part it is.
        described: The part.
        address: Its words address.
        kept: Its last 10 words and when each came, for a listener that comes later.
        events: Likewise of words that tell what happened; they are good for a moment only.
    """

    claim: StoredAnnouncement
    described: DescribedPart
    address: str
    kept: tuple[tuple[float, RawMessage], ...] = ()
    events: tuple[tuple[float, RawMessage], ...] = ()

    def keep(self, message: RawMessage, now: float, *, is_event: bool) -> None:
        """Remember a word that came at *now* on the monotonic clock."""
        if is_event:
            self.events = (*self.events[1 - _KEPT :], (now, message))
        else:
            self.kept = (*self.kept[1 - _KEPT :], (now, message))

    def missed_by(self, since: float, now: float) -> tuple[RawMessage, ...]:
        """Return the kept words that a listener wants that was there from *since* on, on the monotonic clock.

        What the broker had kept is among them where it is still the part's last word.
        """
        recent = missed(self.events, max(since, now - _MOMENT))
        if not recent:
            return missed(self.kept, since)
        wanted = {id(one) for one in (*recent, *missed(self.kept, since))}
        told = sorted((*self.kept, *self.events), key=lambda one: one[0])
        return tuple(one for _, one in told if id(one) in wanted)


@dataclass(frozen=True, slots=True, eq=False)
class AvailabilityReader:
    """One topic that tells whether a described device, or one of its parts, can be reached.

    Attributes:
        claim: Whose availability.
        part: Which part; empty for the whole.
        index: Which of its sources.
    """

    claim: StoredAnnouncement
    part: str
    index: int


@dataclass(slots=True, eq=False)
class StoredAnnouncement:
    """One announcement that stands.

    Attributes:
        gateway: The gateway that heard it.
        key: What that gateway calls it: the convention's name and key.
        described: What it says.
        parts: Its parts by id.
        reachability: What is known of whether the device (``""``) and its parts can be reached, as far as they tell.
        reachable: What of that the graph was told last, likewise.
        is_confirmed: Whether the last sighting was a sign of life of the device itself.
        refresh_at: Reading of the monotonic clock from which on another sign of life is worth a sighting.
        excess: Bytes by which it is longer than what it offers explains.
        report_streams: The streams of reports that late joiners get.
        subscriptions: The filters that it is read on, each with who reads.
    """

    gateway: str
    key: str
    described: DeviceAnnounced
    excess: int = 0
    parts: dict[str, AnnouncedPart] = field(init=False)
    reachability: dict[str, ReachabilityReader] = field(init=False)
    reachable: dict[str, bool | None] = field(default_factory=dict)
    is_confirmed: bool = False
    refresh_at: float = 0.0
    report_streams: set[str] = field(default_factory=set)
    subscriptions: list[tuple[str, AnnouncedPart | AvailabilityReader]] = field(default_factory=list)
    _sighting_template: Sighting = field(init=False)

    def __post_init__(self) -> None:
        self.parts = {
            one.part.id: AnnouncedPart(self, one, text_address(self.key, one.part.id)) for one in self.described.parts
        }
        told = [("", self.described.availability), *((one.part.id, one.availability) for one in self.described.parts)]
        self.reachability = {part: ReachabilityReader(one) for part, one in told if one is not None and one.sources}
        self._sighting_template = self._looks()

    def publishes_the_same(self, other: StoredAnnouncement) -> bool:
        """Whether the graph sees no difference between the two."""
        return self._sighting_template == other._sighting_template

    def take_over_state(self, before: StoredAnnouncement) -> None:
        """Take over what is known of the device from the announcement *before* this one."""
        self.is_confirmed = before.is_confirmed
        self.refresh_at = before.refresh_at
        self.report_streams = before.report_streams
        self.reachable = {part: told for part, told in before.reachable.items() if part in self.reachability}
        for part, reachability in self.reachability.items():
            old_one = before.reachability.get(part)
            if old_one is not None and old_one.availability == reachability.availability:
                self.reachability[part] = old_one
        for part_id, voice in self.parts.items():
            if (old := before.parts.get(part_id)) is not None:
                voice.kept = old.kept

    def let_go(self) -> None:
        """Forget its parts, which know it: what stands no more must not wait for the collector of circular garbage."""
        self.parts, self.reachability, self.subscriptions = {}, {}, []

    def report_stream(self, address: str) -> str:
        """Return the name of the stream of what is said on *address*; of a device with hundreds, they share one."""
        name = f"{self.key} {address}"
        if name not in self.report_streams:
            if len(self.report_streams) >= _MAX_STREAMS:
                name = f"{self.key} *"
            self.report_streams.add(name)
        return name

    def sighting(
        self, kind: SightingKind, why: str, *, at: Time, until: Time, heard_at: float, confirmed: bool
    ) -> Sighting:
        """Return what to tell the graph of it."""
        times = {"seen_at": at, "expires_at": until, "heard_at": heard_at}
        return Sighting.of_checked(
            **{**self._sighting_template.__dict__, "kind": kind, "why": why, "confirmed": confirmed, **times}
        )

    def _looks(self) -> Sighting:
        """What all sightings of it have in common; made here, so that what cannot be told is found at once."""
        described = self.described
        parts = tuple(one.part for one in described.parts)
        main = main_part(parts)
        address = "" if main is None else self.parts[main.id].address
        face = Sighting(
            gateway=self.gateway,
            key=self.key,
            kind="updated",
            why="",
            name=described.name,
            service_type="" if main is None else main.service_type,
            address=address,
            command_address=address if main is not None and accepts_text(main) else "",
            metadata=tuple(_fact(key, value) for key, value in described.facts.items()),
            convention=described.convention,
            identifiers=described.identifiers,
            area=described.area,
            parts=parts,
            owns=described.owns,
            announced_on=described.topic,
            seen_at=_NEVER,
            expires_at=_NEVER,
            confirmed=False,
        )
        return Sighting.of_checked(**face.__dict__)  # without a set of its fields of its own, which is 2 kB


@lru_cache(maxsize=10_000)
def _fact(key: str, value: str) -> KeyValue:
    return KeyValue(key=key, value=value)
