"""Matching of the parts that different sources announce for one device. Pure.

Two parts are one if they can do the same and one of these rules, the surest first, applies to no other pair:

1. their ids are equal, apart from a common beginning and end of all ids of a source;
2. they share a command topic that nothing else in both sources has (for sensors, a state topic);
3. they have the same name;
4. each is the only part of its type, and no setting. This does not apply to parts that one program gives different
   ids, sensors with one state topic, and loads with different command topics: each source may know only one of two.

A part that matches two others equally well matches none: a duplicate part is a nuisance, a crossed command is worse.
The order in which parts and sources arrive does not matter.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import chain
from typing import NamedTuple, TypeAlias

from homebot.devices.part import Capability, Part
from homebot.support.folding import fold

MAX_WORDS = 24
"""Words of an id that count, from the first."""

SETTING = "x_setting"
"""Device type of a setting that is adjusted rather than switched."""


class Candidate(NamedTuple):
    """A part in the context of its source.

    Attributes:
        words: The words of its id.
        prefix: The number of words with which all ids of its source begin.
        suffix: The number of words with which all ids of its source end.
        topics: Command topics unique to it in its source; if there are none, its own state topics.
        is_alone: Whether it is the only part of its type in its source, apart from settings.
    """

    part: Part
    abilities: Mapping[str, Capability]
    name: str
    words: tuple[str, ...]
    prefix: int
    suffix: int
    topics: frozenset[str]
    is_alone: bool


def candidates(parts: Sequence[Part], identifiers: Iterable[str]) -> tuple[Candidate, ...]:
    """Return the *parts* of one source as candidates.

    Args:
        identifiers: The source's identifiers of the device, from which ids of parts are often made.
    """
    ids = [_words(part.id)[:MAX_WORDS] for part in parts]
    known = frozenset(chain.from_iterable(_words(identifier.partition(":")[2]) for identifier in identifiers))
    prefix, suffix = _shared_ends(set(ids))
    writes = Counter(chain.from_iterable([part.writes for part in parts]))
    reads = Counter(chain.from_iterable([part.reads for part in parts]))
    types = Counter([part.service_type for part in parts if not part.category])
    described = []
    for part, words in zip(parts, ids, strict=True):
        used = writes if part.writes else reads
        kinds = frozenset(chain.from_iterable(_kinds(part.advertised, part.service_type)))
        described.append(
            Candidate(
                part=part,
                abilities={capability.name: capability for capability in part.capabilities},
                name=fold(part.name),
                words=words,
                prefix=max(prefix, _leading(words, known | kinds)),
                suffix=max(suffix, _leading(reversed(words), known)),
                topics=frozenset([topic for topic in part.writes or part.reads if used[topic] == 1]),
                is_alone=not part.category and types[part.service_type] == 1,
            )
        )
    return tuple(described)


def match(groups: Sequence[Sequence[Candidate]], others: Sequence[Candidate]) -> dict[int, int]:
    """Return the number of the matching group for *others*, by their numbers.

    Args:
        groups: Parts of the device, each as described by one or more earlier sources.
    """
    matches: dict[int, int] = {}
    for pairs_of in (_by_id, _by_topic, _by_name, _by_type):  # the surest first, weaker ones for the rest
        taken = set(matches.values())
        mine = [
            (number, candidate) for number, group in enumerate(groups) if number not in taken for candidate in group
        ]
        theirs = [(number, other) for number, other in enumerate(others) if number not in matches]
        if not mine or not theirs:
            break
        levels: defaultdict[int, set[_Pair]] = defaultdict(set)
        for letters, pair in pairs_of(mine, theirs):
            levels[letters].add(pair)
        for letters in sorted(levels, reverse=True):
            matches |= _unambiguous(levels[letters], matches)
    return matches


_Pair: TypeAlias = tuple[int, int]
"""The numbers of a group and of a part of the new source."""

_Pairs: TypeAlias = Iterator[tuple[int, _Pair]]
"""Pairs that may be one part, each with the number of matching letters; 0 if letters do not count."""

_Numbered: TypeAlias = Sequence[tuple[int, Candidate]]
"""Candidates, each with the number of its group, or its own."""


def _unambiguous(pairs: Iterable[_Pair], found: Mapping[int, int]) -> dict[int, int]:
    """Return the *pairs* without an earlier match in *found*, and without a competing pair."""
    taken = set(found.values())
    open_pairs = [pair for pair in pairs if pair[0] not in taken and pair[1] not in found]
    groups, others = Counter([group for group, _ in open_pairs]), Counter([other for _, other in open_pairs])
    return {other: group for group, other in open_pairs if groups[group] == others[other] == 1}


class _Members(NamedTuple):
    """Numbered candidates by the words of their ids, and the numbers of words in those."""

    by_words: Mapping[tuple[str, ...], list[tuple[int, Candidate]]]
    lengths: list[int]


def _by_id(mine: _Numbered, theirs: _Numbered) -> _Pairs:
    my_members, their_members = _by_words(mine), _by_words(theirs)
    for number, other in theirs:
        for group, candidate, start in _inside(my_members, other.words, at_most=len(other.words)):
            if letters := _letters_of_id(candidate, other, start):
                yield letters, (group, number)
    for group, candidate in mine:
        for number, other, start in _inside(their_members, candidate.words, at_most=len(candidate.words) - 1):
            if letters := _letters_of_id(other, candidate, start):
                yield letters, (group, number)


def _by_words(numbered: _Numbered) -> _Members:
    by_words: defaultdict[tuple[str, ...], list[tuple[int, Candidate]]] = defaultdict(list)
    for number, candidate in numbered:
        if candidate.words:
            by_words[candidate.words].append((number, candidate))
    return _Members(by_words, sorted(set(map(len, by_words))))


def _inside(members: _Members, words: tuple[str, ...], at_most: int) -> Iterator[tuple[int, Candidate, int]]:
    """Yield those with an id in *words*, and its position."""
    for length in members.lengths:
        if length > at_most:
            break
        for start in range(len(words) - length + 1):
            for number, candidate in members.by_words.get(words[start : start + length], ()):
                yield number, candidate, start


def _letters_of_id(short: Candidate, long: Candidate, start: int) -> int:
    """Return the number of matching letters if the id of *short* is that of *long*, which contains it; else 0."""
    if not _can_be_one(short, long):
        return 0
    before, behind = start, len(long.words) - start - len(short.words)
    is_whole = behind <= long.suffix and (before <= long.prefix or before - _named_by_type(long, start) <= long.prefix)
    return sum(map(len, short.words)) if is_whole else 0


def _named_by_type(long: Candidate, start: int) -> int:
    """Count the words before *start* that only name the kind of part, as in ``0x17_switch_child_lock``."""
    for words in _kinds(long.part.advertised, long.part.service_type):
        if words and long.words[max(0, start - len(words)) : start] == words:
            return len(words)
    return 0


@lru_cache(maxsize=512)  # shared by all lamps of a house
def _kinds(advertised: str, service_type: str) -> tuple[tuple[str, ...], ...]:
    return _words(advertised), _words(service_type)


_ADDRESS = re.compile(r"(?<![0-9a-z])[0-9a-f]{2}(?::[0-9a-f]{2}){5}(?:(?::[0-9a-f]{2}){2})?(?![0-9a-z])")
_SEPARATORS = str.maketrans(":/", "  ")


def _words(text: str) -> tuple[str, ...]:
    """Return the words of an id; a hardware address is one word."""
    plain = fold(text)
    if ":" in plain:
        plain = _ADDRESS.sub(lambda match: match[0].replace(":", ""), plain)
    return tuple(plain.translate(_SEPARATORS).split())


def _by_topic(mine: _Numbered, theirs: _Numbered) -> _Pairs:
    by_topic = defaultdict(list)
    for number, other in theirs:
        for topic in other.topics:
            by_topic[topic, bool(other.part.writes)].append((number, other))
    for group, candidate in mine:
        for topic in candidate.topics:
            for number, other in by_topic.get((topic, bool(candidate.part.writes)), ()):
                if candidate.abilities.keys() == other.abilities.keys() and _can_be_one(candidate, other):
                    yield 0, (group, number)


def _by_name(mine: _Numbered, theirs: _Numbered) -> _Pairs:
    named = defaultdict(list)
    for number, other in theirs:
        if other.name:
            named[other.name].append((number, other))
    for group, candidate in mine:
        for number, other in named.get(candidate.name, ()) if candidate.name else ():
            if _can_be_one(candidate, other):
                yield 0, (group, number)


def _by_type(mine: _Numbered, theirs: _Numbered) -> _Pairs:
    alone = {other.part.service_type: (number, other) for number, other in theirs if other.is_alone}
    for group, candidate in mine:
        number, other = alone.get(candidate.part.service_type, (0, None))
        if other is not None and candidate.is_alone and _is_one_of_its_type(candidate, other):
            yield 0, (group, number)


def _is_one_of_its_type(candidate: Candidate, other: Candidate) -> bool:
    """Return whether type is evidence: always for loads; for sensors, if neither has a name of its own."""
    if candidate.part.service_type.startswith("x_") or not _can_be_one(candidate, other):
        return False
    if _are_told_apart(candidate.part, other.part):
        return False
    if _is_load(candidate) or _is_load(other):
        return True
    return candidate.abilities.keys() == other.abilities.keys() and _may_have_one_name(candidate, other)


def _are_told_apart(one: Part, other: Part) -> bool:
    """Return whether one program announces both, as sensors or as loads with different command topics."""
    if one.writes and other.writes:
        return _is_of_one_program(one.reads, other.reads) and set(one.writes).isdisjoint(other.writes)
    return not (one.writes or other.writes) and _is_of_one_program(one.reads, other.reads)


def _is_of_one_program(topics: tuple[str, ...], others: tuple[str, ...]) -> bool:
    """Return whether the two share a topic, or one is below another."""
    return any(
        f"{topic}/".startswith(f"{other}/") or f"{other}/".startswith(f"{topic}/")
        for topic in topics
        for other in others
    )


def _is_load(candidate: Candidate) -> bool:
    """Return whether it can be commanded; a gateway without topics has no command topics."""
    return bool(candidate.part.writes) or any(capability.settable for capability in candidate.part.capabilities)


def _may_have_one_name(candidate: Candidate, other: Candidate) -> bool:
    return (
        candidate.name == other.name
        or (not candidate.name and _is_plain(other))
        or (not other.name and _is_plain(candidate))
    )


def _is_plain(candidate: Candidate) -> bool:
    return candidate.name in set(map(fold, candidate.abilities))


def _can_be_one(candidate: Candidate, other: Candidate) -> bool:
    """Return whether the capabilities and functions of the two are compatible."""
    mine, theirs = candidate.abilities, other.abilities
    shared = mine.keys() & theirs.keys()
    if (mine and theirs and not shared) or not all(_agree(mine[name], theirs[name]) for name in shared):
        return False
    return _can_be_one_by_type(candidate, other)


def _can_be_one_by_type(candidate: Candidate, other: Candidate) -> bool:
    mine, theirs = candidate.abilities, other.abilities
    part, its_part = candidate.part, other.part
    is_settable = _is_load(candidate) or _is_load(other)
    if part.service_type != its_part.service_type:
        is_setting = SETTING in (part.service_type, its_part.service_type)
        return bool(mine) and mine.keys() == theirs.keys() and (is_setting or not is_settable)
    if part.service_type.startswith("x_") or not is_settable:
        return mine.keys() <= theirs.keys() or theirs.keys() <= mine.keys()
    return (not part.category) == (not its_part.category)


def _agree(capability: Capability, other: Capability) -> bool:
    """Return whether both can have the same values: in the same unit, and with options in common if any."""
    if capability.unit and other.unit and capability.unit != other.unit:
        return False
    if not (capability.settable and other.settable and capability.options and other.options):
        return True
    if capability.name == "option":
        return set(capability.options) == set(other.options)
    return not set(capability.options).isdisjoint(other.options)


def _shared_ends(ids: set[tuple[str, ...]]) -> tuple[int, int]:
    """Return the numbers of words with which all *ids* begin and end; 0 for a single id."""
    return (_common(ids), _common({words[::-1] for words in ids})) if len(ids) > 1 else (0, 0)


def _common(ids: set[tuple[str, ...]]) -> int:
    """Return the number of words with which all *ids* begin, excluding the last word of the shortest."""
    count = 0
    shortest = min(map(len, ids)) - 1
    for word, other in zip(min(ids), max(ids), strict=False):  # what the first and last in order share, all share
        if word != other or count >= shortest:
            break
        count += 1
    return count


def _leading(words: Iterable[str], known: frozenset[str]) -> int:
    count = 0
    for word in words:
        if word not in known:
            break
        count += 1
    return count
