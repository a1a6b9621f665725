"""Every announcement that stands, and who reads which topic. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from homebot.errors import WireError
from homebot.gateways.mqtt.claim import Claim, Voice, Witness
from homebot.gateways.mqtt.convention import Convention
from homebot.gateways.mqtt.description import Described
from homebot.gateways.mqtt.excess import MAX_EXCESS, MAX_EXCESS_EACH, Excess, excess_of
from homebot.gateways.mqtt.filter_tree import FilterTree, has_wildcard
from homebot.gateways.mqtt.memory_account import MAX_MEMORY, MemoryAccount
from homebot.gateways.mqtt.state_topics import StateTopics

__all__ = ["Bounds", "Change", "Claims", "Route"]

_MAX_ROUTES = 50_000

_Readers: TypeAlias = tuple[tuple[str, Voice | Witness], ...]


@dataclass(frozen=True, slots=True)
class Bounds:
    """How much may stand at once.

    Attributes:
        claims: Announcements.
        parts: Parts of all of them.
        parts_each: Parts of one.
        readers: Parts that read one topic: each of its messages is work for all of them.
        excess: Bytes by which announcements are longer than what they offer explains, of all.
        excess_each: The same of one.
        memory: Bytes that all take, about.
    """

    claims: int = 50_000
    parts: int = 200_000
    parts_each: int = 1000
    readers: int = 5000
    excess: int = MAX_EXCESS
    excess_each: int = MAX_EXCESS_EACH
    memory: int = MAX_MEMORY


_BOUNDS = Bounds()


@dataclass(frozen=True, slots=True)
class Route:
    """Everybody who reads one topic.

    Attributes:
        conventions: Those that devices announce themselves to there.
        witnesses: Devices whose availability is told there.
        voices: Parts that speak there, those of one device together.
        is_shared: Whether what the gateway subscribes to beside its conventions matches the topic too.
    """

    conventions: tuple[Convention, ...]
    witnesses: tuple[Witness, ...]
    voices: tuple[Voice, ...]
    is_shared: bool


@dataclass(frozen=True, slots=True)
class Change:
    """What a new description changed.

    Attributes:
        claim: What stands now.
        before: What it took the place of, or None.
        refused: State topics that cannot be read, with the reasons.
        readers: Who reads which topic now that is read by others already, and may have missed what was said there.
    """

    claim: Claim
    before: Claim | None
    refused: tuple[WireError, ...]
    readers: _Readers


class Claims:
    """The announcements of all conventions of one gateway.

    Args:
        gateway: Its name.
        conventions: The conventions.
        topics: Counts which state topics are needed.
        others: What the gateway subscribes to beside its conventions.
        bounds: How much may stand at once.
    """

    def __init__(
        self,
        gateway: str,
        conventions: tuple[Convention, ...],
        topics: StateTopics,
        others: FilterTree[str],
        bounds: Bounds = _BOUNDS,
    ) -> None:
        self._gateway = gateway
        self._topics = topics
        self._others = others
        self._bounds = bounds
        self._claims: dict[str, Claim] = {}
        self._parts = 0
        self._excess = Excess(bounds.excess, bounds.excess_each)
        self._memory = MemoryAccount(bounds.memory)
        self._announcements: FilterTree[Convention] = FilterTree()
        for convention in conventions:
            for topic_filter in convention.filters():
                self._announcements.add(topic_filter, convention)
        self._readers: FilterTree[Voice | Witness] = FilterTree()
        self._reader_counts: dict[str, int] = {}
        self._routes: dict[str, Route | None] = {}

    @property
    def excess(self) -> int:
        """Bytes by which all that stand are longer than what they offer explains."""
        return self._excess.total

    @property
    def memory(self) -> int:
        """Bytes that all that stand take, about."""
        return self._memory.total

    def get(self, key: str) -> Claim | None:
        """Return what stands under *key*."""
        return self._claims.get(key)

    def voice(self, key: str, part_id: str) -> Voice | None:
        """Return the part *part_id* of what stands under *key*."""
        claim = self._claims.get(key)
        return None if claim is None else claim.voices.get(part_id)

    def all(self) -> tuple[Claim, ...]:
        """Return all that stand, in the order of their coming."""
        return tuple(self._claims.values())

    def route(self, topic: str) -> Route | None:
        """Return who reads *topic*; None for nobody."""
        try:
            return self._routes[topic]
        except KeyError:
            return self._find(topic)

    def describe(self, described: Described, length: int = 0) -> Change:
        """Let *described* stand, in place of an earlier one of the same key.

        Args:
            described: The description.
            length: Of the message that it alone was made of; 0 where that is unknown.

        Raises:
            WireError: It has more than 1,000 parts, is one device or part too many, too long, or there is no more
                memory for it. What stood before stays.
        """
        key = f"{described.convention}:{described.key}"
        before = self._claims.get(key)
        self._check_room(described, before)
        excess = excess_of(described, length)
        self._excess.check(described.key, excess, 0 if before is None else before.excess)
        claim = Claim(self._gateway, key, described, excess)
        refused, readers = self._enlist(claim)
        if before is not None:
            claim.inherit(before)
            self._strike(before)
            readers = _who_missed_something(claim, before, readers)
        self._claims[key] = claim
        self._parts += len(described.parts)
        self._excess.total += excess
        self._memory.put(described)
        return Change(claim, before, refused, readers)

    def withdraw(self, key: str) -> Claim | None:
        """Let what stands under *key* stand no more, and return it."""
        claim = self._claims.pop(key, None)
        if claim is not None:
            self._strike(claim)
        return claim

    def __len__(self) -> int:
        return len(self._claims)

    def _check_room(self, described: Described, before: Claim | None) -> None:
        count = len(described.parts)
        if count > self._bounds.parts_each:
            raise WireError(f"{described.key!r} has {count} parts, more than {self._bounds.parts_each:,}")
        if before is None and len(self._claims) >= self._bounds.claims:
            raise WireError(f"{described.key!r} is one too many: {self._bounds.claims:,} announcements stand")
        if self._parts + count - (0 if before is None else len(before.described.parts)) > self._bounds.parts:
            raise WireError(f"{described.key!r} has parts too many: {self._bounds.parts:,} are described")
        self._memory.check(described, None if before is None else before.described)

    def _enlist(self, claim: Claim) -> tuple[tuple[WireError, ...], _Readers]:
        refused: list[WireError] = []
        readers: list[tuple[str, Voice | Witness]] = []
        for topic_filter, reader in tuple(_readings(claim)):  # first all, because a plug-in may fail on the way
            count = self._reader_counts.get(topic_filter, 0)
            if count >= self._bounds.readers and isinstance(reader, Voice):
                refused.append(WireError(f"topic {topic_filter!r} is read by {self._bounds.readers:,} parts already"))
                continue
            try:
                self._topics.use(topic_filter)
            except WireError as exc:
                refused.append(exc)
                continue
            self._reader_counts[topic_filter] = count + 1
            claim.enlisted.append((topic_filter, reader))
            self._readers.add(topic_filter, reader)
            self._forget_routes(topic_filter)
            if count and not has_wildcard(topic_filter):
                readers.append((topic_filter, reader))
        return tuple(refused), tuple(readers)

    def _strike(self, claim: Claim) -> None:
        self._parts -= len(claim.described.parts)
        self._excess.total -= claim.excess
        self._memory.drop(claim.described)
        for topic_filter, reader in claim.enlisted:
            self._topics.leave(topic_filter)
            self._readers.remove(topic_filter, reader)
            self._forget_routes(topic_filter)
            if self._reader_counts[topic_filter] == 1:
                del self._reader_counts[topic_filter]
            else:
                self._reader_counts[topic_filter] -= 1

    def _forget_routes(self, topic_filter: str) -> None:
        if has_wildcard(topic_filter):
            self._routes.clear()
        else:
            self._routes.pop(topic_filter, None)

    def _find(self, topic: str) -> Route | None:
        conventions = self._announcements.match(topic)
        readers = self._readers.match(topic)
        if not conventions and not readers:
            route = None
        else:
            is_shared = bool(self._others.match(topic))
            if not readers:  # announcements are many, and few of them come again
                return Route(conventions, (), (), is_shared)
            route = Route(
                conventions,
                tuple(one for one in readers if isinstance(one, Witness)),
                tuple(one for one in readers if isinstance(one, Voice)),
                is_shared,
            )
        if len(self._routes) >= _MAX_ROUTES:
            self._routes.clear()
        self._routes[topic] = route
        return route


def _who_missed_something(claim: Claim, before: Claim, readers: _Readers) -> _Readers:
    if claim.has_same_face(before):
        return tuple(
            (topic, reader) for topic, reader in readers if isinstance(reader, Voice) and reader.described.remembers
        )
    return tuple((topic, reader) for topic, reader in readers if isinstance(reader, Voice) or _is_new(reader, before))


def _is_new(witness: Witness, before: Claim) -> bool:
    return witness.claim.reachability[witness.part] is not before.reachability.get(witness.part)


def _readings(claim: Claim) -> Iterator[tuple[str, Voice | Witness]]:
    """Each filter that something of *claim* is read on, with what is."""
    for voice in claim.voices.values():
        for topic_filter in dict.fromkeys(voice.described.codec.topics()):
            yield topic_filter, voice
    for part, reachability in claim.reachability.items():
        for index, source in enumerate(reachability.availability.sources):
            yield source.topic, Witness(claim, part, index)
