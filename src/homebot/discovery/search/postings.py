"""Postings: the set of matching devices for each possible term. Pure."""

from __future__ import annotations

from bisect import bisect_left, insort
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import reduce
from itertools import repeat
from operator import and_
from typing import Any, ClassVar, TypeAlias, final

from homebot.devices.query.facets import Facets
from homebot.devices.query.matching import compares, matches_kind
from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    IsNear,
    IsUnapproved,
    NameIs,
    Not,
    Or,
    PartIs,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
)
from homebot.devices.value import PlainValue
from homebot.discovery.search.columns import Column, StoredValue
from homebot.support.folding import fold, is_typo, may_be_typo, words_of

Found: TypeAlias = frozenset[str] | set[str]
PostedValue: TypeAlias = tuple[str, str, str, StoredValue]
"""The part, its type, the capability, and the stored value, which later reports update."""

_Key: TypeAlias = tuple[object, ...]
_NONE: frozenset[str] = frozenset()
_DISPUTED = ("disputed", True)
_UNAPPROVED = ("unapproved", True)
_MAX_CHECKED_DEVICES = 200
"""Number of devices below which it is faster to check each than to go through all values of a capability."""


@dataclass(slots=True)
class _Posted:
    facets: Facets
    values: dict[tuple[str, str], tuple[str, StoredValue]] = field(default_factory=dict)


@final
class Postings:
    """Finds the devices that match a query by sets, without checking each.

    Attributes:
        needs_approval: Whether devices that can hurt wait for the owner's approval; otherwise none is unapproved.
    """

    def __init__(self) -> None:
        self.needs_approval = True
        self._posted: dict[str, _Posted] = {}
        self._mixed_ids: set[str] = set()  # words with upper case, which are rare
        self._sets: dict[_Key, str | set[str]] = {}  # most keys, such as names, have a single device
        self._values_of: dict[str, set[_Key]] = {}
        self._columns: dict[tuple[str, str], Column] = {}
        self._types_with: dict[str, set[str]] = {}
        self._words = _Words()

    def __len__(self) -> int:
        return len(self._posted)

    def put(self, facets: Facets, values: Iterable[PostedValue]) -> None:
        """Add a device, to be found by its facets and by *values*."""
        device_id = facets.id
        before = self._posted.get(device_id)
        if before is None:
            sets = self._sets
            for key in _keys(facets):
                ids = sets.get(key)
                if ids is None:
                    self._begin(key, device_id)
                elif type(ids) is set:
                    ids.add(device_id)
                else:
                    self._join(key, device_id)
        else:
            keys, known = frozenset(_keys(facets)), frozenset(_keys(before.facets))
            for key in known - keys:
                self._leave(key, device_id)
            for key in keys - known:
                self._join(key, device_id)
            self._discard_values(device_id, before)
        self._posted[device_id] = _Posted(facets)
        if device_id.casefold() != device_id:
            self._mixed_ids.add(device_id)
        for part, service_type, capability, stored in values:
            self.put_value(device_id, part, service_type, capability, stored)

    def put_value(self, device_id: str, part: str, service_type: str, capability: str, stored: StoredValue) -> None:
        """Add the first value of a part, for a device already added."""
        posted = self._posted.get(device_id)
        if posted is None:
            return
        known = posted.values.get((part, capability))
        if known is not None and known[1] is stored and known[0] == service_type:
            return
        if known is not None:
            self._columns[known[0], capability].discard(device_id, known[1])
        posted.values[part, capability] = (service_type, stored)
        column = self._columns.get((service_type, capability))
        if column is None:
            column = self._columns[service_type, capability] = Column()
            self._types_with.setdefault(capability, set()).add(service_type)
        column.add(device_id, stored)

    def discard(self, device_id: str) -> None:
        """Remove a device."""
        posted = self._posted.pop(device_id, None)
        self._mixed_ids.discard(device_id)
        if posted is not None:
            for key in frozenset(_keys(posted.facets)):
                self._leave(key, device_id)
            self._discard_values(device_id, posted)

    def facets(self, device_id: str) -> Facets:
        """Return the search facets of the device; values in them may be outdated."""
        return self._posted[device_id].facets

    def value(self, device_id: str, term: StateIs) -> PlainValue:
        """Return the value by which the device matches *term*; None if it does not."""
        posted = self._posted[device_id]
        parts = posted.facets.named_parts.get(term.part, _NONE)
        for (part, capability), (service_type, stored) in posted.values.items():
            is_meant = capability == term.capability and (not term.types or service_type in term.types)
            if is_meant and (not term.part or part in parts) and compares(term, stored.value):
                return stored.value
        return None

    def values_of(self, name: str) -> frozenset[str]:
        """Return all values of ``area``, ``tag``, ``gateway``, ``convention``, or of the type (``advertised``)."""
        return frozenset(str(value[0]) for value in self._values_of.get(name, ()))

    def find(self, query: Query) -> Found:
        """Return the devices that match *query*, as a set not to be modified."""
        return self._FINDERS[type(query)](self, query)

    def _of_area(self, query: AreaIs) -> Found:
        if query.text:
            return self._devices(("area", query.text))
        return {device_id for device_id, posted in self._posted.items() if not posted.facets.areas}

    def _named(self, query: NameIs) -> Found:
        with_words = [self._devices(("word", word)) for word in words_of(query.text)]
        likely = min(with_words, key=len, default=self._posted.keys())  # an id is among the words of its device
        return self._devices(("fact name", query.text)) | {
            device_id for device_id in likely if fold(device_id) == query.text
        }

    def _by_fact(self, query: FactIs) -> Found:
        name, value = query.name, query.value
        if name == "id":
            ids = {device_id for device_id in self._mixed_ids if device_id.casefold() == value}
            return ids | {value} if value in self._posted else ids
        if name in {"convention", "category", "tag"}:
            return self._devices((name, value))
        if name == "group":
            return self._devices(("fact group", value))
        return self._begins(f"fact {name}", value)

    def _all(self, query: And) -> Found:
        """Return the matches of all terms: cheap ones first, comparisons of values last, when few devices remain."""
        terms = query.terms
        cheap = [self.find(term) for term in terms if not isinstance(term, (Not, StateIs))]
        matches = reduce(and_, sorted(cheap, key=len)) if cheap else None
        for term in terms:
            if isinstance(term, StateIs):
                matches = self._by_value(term) if matches is None else self._of_value(matches, term)
        for term in terms:
            if isinstance(term, Not):
                matches = (self._posted.keys() if matches is None else matches) - self.find(term.term)
        return frozenset(self._posted) if matches is None else matches

    def _of_value(self, devices: Found, term: StateIs) -> Found:
        if len(devices) > _MAX_CHECKED_DEVICES or term.part:
            return devices & self._by_value(term)
        return {device for device in devices if self.value(device, term) is not None}

    def _by_value(self, term: StateIs) -> Found:
        if term.part:
            return {device for device in self._devices(("part", term.part)) if self.value(device, term) is not None}
        matches: list[set[str]] = []
        for service_type in term.types or self._types_with.get(term.capability, _NONE):
            column = self._columns.get((service_type, term.capability))
            if column is not None:
                matches.append(column.fitting(term))
        return matches[0] if len(matches) == 1 else _NONE.union(*matches)

    def _type_keys(self, query: TypeIs) -> Iterator[_Key]:
        for service_type in query.types:
            for value in self._values_of.get(f"kind {service_type}", set()):
                tag = str(value[0])
                if matches_kind(query, (service_type, tag)):
                    yield (f"kind {service_type}", tag)
        if query.by_word:
            yield ("advertised", query.word)
        if query.types:
            yield ("sense", query.types)

    def _begins(self, field_name: str, wanted: str) -> Found:
        values = self._values_of.get(field_name, set())
        prefix = f"{wanted} "
        fitting = [value for value in values if (text := str(value[0])) == wanted or text.startswith(prefix)]
        return self._union((field_name, *value) for value in fitting)

    def _union(self, keys: Iterable[_Key]) -> Found:
        sets = [self._devices(key) for key in keys]
        return sets[0] if len(sets) == 1 else _NONE.union(*sets)

    def _devices(self, key: _Key) -> Found:
        ids = self._sets.get(key, _NONE)
        return {ids} if isinstance(ids, str) else ids

    def _join(self, key: _Key, device_id: str) -> None:
        ids = self._sets.get(key)
        if ids is None:
            self._begin(key, device_id)
        elif isinstance(ids, set):
            ids.add(device_id)
        elif ids != device_id:
            self._sets[key] = {ids, device_id}

    def _begin(self, key: _Key, device_id: str) -> None:
        self._sets[key] = device_id
        if key[0] == "word":
            self._words.add(str(key[1]))
        else:
            self._values_of.setdefault(str(key[0]), set()).add(key[1:])

    def _leave(self, key: _Key, device_id: str) -> None:
        ids = self._sets[key]
        if isinstance(ids, set):
            ids.discard(device_id)
            if ids:
                return
        del self._sets[key]
        if key[0] == "word":
            self._words.discard(str(key[1]))
        else:
            self._values_of[str(key[0])].discard(key[1:])

    def _discard_values(self, device_id: str, posted: _Posted) -> None:
        for (_, capability), (service_type, stored) in posted.values.items():
            self._columns[service_type, capability].discard(device_id, stored)

    _FINDERS: ClassVar[Mapping[type[Query], Callable[[Postings, Any], Found]]] = {
        And: _all,
        Or: lambda self, query: _NONE.union(*map(self.find, query.terms)),
        Not: lambda self, query: self._posted.keys() - self.find(query.term),
        StateIs: _by_value,
        HasText: lambda self, query: self._union(("word", word) for word in self._words.like(query.text)),
        TypeIs: lambda self, query: self._union(self._type_keys(query)),
        IsNear: lambda self, _: frozenset(self._posted),
        IsUnapproved: lambda self, _: self._devices(_UNAPPROVED) if self.needs_approval else _NONE,
        IsDisputed: lambda self, _: self._devices(_DISPUTED),
        AreaIs: _of_area,
        InArea: lambda self, query: self._begins("area", query.text),
        NameIs: _named,
        PartIs: lambda self, query: self._devices(("part", query.text)),
        FactIs: _by_fact,
        CanDo: lambda self, query: self._devices(("set" if query.settable else "can", query.name)),
        FreshnessIs: lambda self, query: self._devices(("freshness", query.text)),
        GatewayIs: lambda self, query: self._devices(("gateway", query.text)),
        ReachableIs: lambda self, query: self._devices(("reachable", query.text)),
    }
    """The function that finds the devices for each kind of term."""


def _keys(facets: Facets) -> list[_Key]:
    keys: list[_Key] = [("freshness", facets.freshness), ("reachable", facets.reachable)]
    if facets.name not in facets.facts.get("name", ()):
        keys.append(("fact name", facets.name))
    keys += zip(repeat("area"), facets.areas)
    if facets.tags:
        keys += zip(repeat("tag"), facets.tags)
    if facets.possible_types:
        keys.append(("sense", facets.possible_types))
    for service_type, tag in facets.kinds:
        keys.append((f"kind {service_type}", tag))
    keys += zip(repeat("advertised"), facets.advertised)
    keys += zip(repeat("can"), facets.capabilities)
    keys += zip(repeat("set"), facets.settable)
    keys += zip(repeat("gateway"), facets.gateways)
    keys += zip(repeat("convention"), facets.conventions)
    keys += zip(repeat("category"), facets.categories)
    keys += zip(repeat("part"), facets.named_parts)
    if facets.is_disputed:
        keys.append(_DISPUTED)
    if facets.is_unapproved:
        keys.append(_UNAPPROVED)
    keys += zip(repeat("word"), facets.words)
    for fact, values in facets.facts.items():
        keys += zip(repeat(f"fact {fact}"), values)
    return keys


@final
class _Words:
    """The words of all devices, to be found by prefix or with a typo."""

    def __init__(self) -> None:
        self._sorted: list[str] = []
        self._shortened: dict[str, tuple[str, ...]] = {}  # most have one word, and a set takes four times the memory

    def add(self, word: str) -> None:
        insort(self._sorted, word)
        for short in _shortened(word):
            self._shortened[short] = (*self._shortened.get(short, ()), word)

    def discard(self, word: str) -> None:
        del self._sorted[bisect_left(self._sorted, word)]
        for short in _shortened(word):
            self._shortened[short] = tuple([known for known in self._shortened[short] if known != word])
            if not self._shortened[short]:
                del self._shortened[short]

    def like(self, wanted: str) -> Iterator[str]:
        """Yield the words that begin with *wanted* or differ by a typo, each once."""
        place = bisect_left(self._sorted, wanted)
        while place < len(self._sorted) and self._sorted[place].startswith(wanted):
            yield self._sorted[place]
            place += 1
        near: set[str] = set()
        for short in _shortened(wanted):
            near.update(self._shortened.get(short, ()))
        yield from sorted(word for word in near if is_typo(wanted, word) and not word.startswith(wanted))


def _shortened(word: str) -> set[str]:
    """Return the word, and each variant with one letter less: words that differ by a typo share one of them."""
    if not may_be_typo(word):
        return set()
    return {word, *(word[:place] + word[place + 1 :] for place in range(len(word)))}
