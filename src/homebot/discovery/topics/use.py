"""The topics that an announcement uses, and the names in the place where it was made. Pure.

The broker grants the right to publish, so the place of an announcement is the one thing that its sender cannot choose
freely: ``…/kitchen_lamp/config`` has a better claim to ``kitchen_lamp/set`` than ``…/intruder/config``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import chain
from operator import attrgetter
from typing import NamedTuple

from homebot.devices import Sighting
from homebot.devices.always_ask import ALWAYS_ASK, asks_by_itself
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.identity import aliasing_bridge
from homebot.devices.words import ALL_THAT_ASK, matching_words
from homebot.discovery.merging.identity import is_generic
from homebot.discovery.source_record import SourceKey, SourceRecord

_SHORTEST = 4
_HARDWARE_TAIL = 6
_ADDRESS = 12
_MORE_WORDS = """
config command commands status state states stat tele cmnd gateway bridge event events button switch binary sensor
number select text cover fan climate lock valve siren vacuum update scene camera image automation tracker alarm panel
heater humidifier light lights bulb plug plugs socket outlet dimmer thing things home room set get
in out on off to all main
"""
_COMMON = frozenset(_MORE_WORDS.split()) | {word for name in DEVICE_TYPES for word in name.split("_")}
_WORD = re.compile(r"[^\x00-/:-`{-\x7f]+")  # lower case, digits and non-ASCII; this form compiles 30 times faster
_HEX = re.compile(r"(?:0x)?([0-9a-f]{12,16})")


class Place(NamedTuple):
    """The place of an announcement, as a hint at its sender.

    Attributes:
        levels: Whole levels of the topic that name a device.
        words: All words in it that name a device.
        leads: The first word of each level, by which devices name their announcements.
        numbers: The words that are numbers of the device, such as a hardware address.
    """

    levels: frozenset[str] = frozenset()
    words: frozenset[str] = frozenset()
    leads: frozenset[str] = frozenset()
    numbers: frozenset[str] = frozenset()


_NOWHERE = Place()


@lru_cache(maxsize=4096)
def place_of(topic: str) -> Place:
    """Return the names in the place *topic*; no names if it names no device."""
    if not topic:
        return _NOWHERE
    levels: set[str] = set()
    words: set[str] = set()
    leads: set[str] = set()
    for level in topic.casefold().split("/"):
        if _is_name(level):
            levels.add(level)
        in_level = [word for word in _WORD.findall(level) if _is_specific_word(word)]
        for word in in_level:
            words |= _spellings(word)
        if in_level:
            leads |= _spellings(in_level[0])
    numbers = {word for word in words if len(word) >= _HARDWARE_TAIL and not word.isalpha()}
    return Place(frozenset(levels), frozenset(words), frozenset(leads), frozenset(numbers))


def is_called(topic: str, aliases: frozenset[str]) -> bool:
    """Return whether the place *topic* contains one of the names of a device from :func:`aliases_of`."""
    is_level = any(level in aliases and _is_name(level) for level in topic.casefold().split("/"))
    return is_level or not aliases.isdisjoint(place_of(topic).numbers)


@lru_cache(maxsize=4096)
def aliases_of(owns: tuple[str, ...], identifiers: tuple[str, ...]) -> frozenset[str]:
    """Return the names of a device with the topics *owns*: their last levels, and its hardware addresses."""
    names = {prefix.rpartition("/")[2].casefold() for prefix in owns}
    for identifier in identifiers:
        kind, _, address = identifier.partition(":")
        if kind != "id":
            names |= _spellings(address.casefold())
    return frozenset(name for name in names if _is_specific_word(name))


@lru_cache(maxsize=4096)
def _words_of(topic: str) -> tuple[frozenset[str], frozenset[str]]:
    """Return the words and whole levels of a topic that name a device."""
    folded = topic.casefold()
    spellings: set[str] = set()
    for word in _WORD.findall(folded):
        if _is_specific_word(word):
            spellings |= _spellings(word)
    return frozenset(spellings), frozenset(level for level in folded.split("/") if _is_name(level))


def _is_name(level: str) -> bool:
    """Return whether a whole level names a device: ``ems-esp`` does, ``light_1`` does not."""
    return any(not word.isdigit() and word not in _COMMON and not is_generic(word) for word in _WORD.findall(level))


def _spellings(word: str) -> set[str]:
    """Return the spellings of *word*: a hardware address also without its 0x, and its last six digits."""
    match = _HEX.fullmatch(word)
    if match is None:
        return {word}
    digits = match[1]
    tail = {digits[-_HARDWARE_TAIL:]} if len(digits) == _ADDRESS else set()
    return {digits, *tail}


def _is_specific_word(word: str) -> bool:
    return len(word) >= _SHORTEST and word not in _COMMON and not is_generic(word)


_WRITES, _READS, _TYPE = attrgetter("writes"), attrgetter("reads"), attrgetter("service_type")


class TopicUse(NamedTuple):
    """The topics that one announcement uses.

    Attributes:
        owns: Topics that belong to the device, with everything below.
        identifiers: The identifiers of the device, if it owns topics.
        is_anonymous: Whether it does not identify the device.
        is_native: Whether its convention is one of devices themselves.
        commands: The type and payloads of its only part; empty for several parts, or if the topics imply them.
        base: The base topic of its bridge, if a part always asks: the bridge takes commands to it on further topics.
        asks: Whether a part is of a type that always asks, so that other types may not share its topics.
        is_heard: Whether the device has reported a value by it; it counts where its topics are disputed only.
    """

    key: SourceKey
    device: str
    announced_on: str = ""
    writes: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    owns: tuple[str, ...] = ()
    identifiers: tuple[str, ...] = ()
    bridge: str = ""
    is_anonymous: bool = False
    is_native: bool = False
    commands: tuple[str, ...] = ()
    asks: bool = False
    base: str = ""
    is_heard: bool = False

    def has(self, topic: str) -> bool:
        """Return whether *topic* belongs to the device."""
        return any(topic == prefix or topic.startswith(f"{prefix}/") for prefix in self.owns)

    def counts_below(self, topic: str) -> bool:
        """Return whether commands on *topic* matter to the uses of topics below it."""
        return self.asks or self.rank(topic) > 0

    def rank(self, topic: str) -> int:
        """Return how many words and levels of *topic* occur in its place: the more, the better its claim."""
        place = place_of(self.announced_on)
        if not place.words and not place.levels:
            return 0
        words, levels = _words_of(topic)
        return len(place.words & words) + len(place.levels & levels)

    def repeats(self, other: TopicUse) -> bool:
        """Return whether it repeats the announcement of *other*: the same commands on the same topics."""
        return (
            bool(self.commands)
            and self.commands == other.commands
            and (self.writes, self.reads) == (other.writes, other.reads)
        )

    def names(self) -> frozenset[str]:
        """Return the names under which other places may announce the same device."""
        place = place_of(self.announced_on)
        return place.levels | place.leads


def topic_use(source: SourceRecord, device: str) -> TopicUse:
    """Return the topics that the announcement *source* of *device* uses."""
    sighting = source.sighting
    parts = sighting.parts
    if len(parts) == 1:
        writes, reads = parts[0].writes, parts[0].reads  # the same objects, to save memory
    else:
        writes = tuple(chain.from_iterable(map(_WRITES, parts)))
        reads = tuple(chain.from_iterable(map(_READS, parts)))
    if sighting.command_address and sighting.is_plain_text:
        writes = (*writes, sighting.command_address)
    if len(writes) > 1:
        writes = tuple(dict.fromkeys(writes))
    if len(reads) > 1:
        reads = tuple(dict.fromkeys(reads))
    commands = (parts[0].service_type, parts[0].payloads) if len(parts) == 1 and parts[0].payloads and writes else ()
    bridge, owns = bridge_of(sighting), sighting.owns
    base, aliasing = "", aliasing_bridge(bridge, sighting.identifiers)
    if aliasing:
        base, owns = _topics_of_bridge(sighting, owns, writes)
    return TopicUse(
        source.key,
        device,
        sighting.announced_on,
        writes,
        reads,
        owns,
        sighting.identifiers if owns else (),
        aliasing or bridge,
        not sighting.identifiers,
        sighting.native,
        commands,
        not ALWAYS_ASK.isdisjoint(map(_TYPE, parts)),
        base,
        bool(source.values),
    )


def _topics_of_bridge(
    sighting: Sighting, owns: tuple[str, ...], writes: tuple[str, ...]
) -> tuple[str, tuple[str, ...]]:
    """Return the base topic of the bridge of *sighting*, empty if no part asks, and the topics that it owns then."""
    if not matching_words(sighting.name, ALL_THAT_ASK) and not any(map(asks_by_itself, sighting.parts)):
        return "", owns
    base = _base_of(sighting, owns or writes)
    if base and not owns:  # a bridge that is known only by its announcements to Home Assistant
        owns = tuple([f"{base}/{address}" for address in (sighting.name, *_addresses_of(sighting.identifiers))])
    return base, owns


def _base_of(sighting: Sighting, topics: Sequence[str]) -> str:
    """Return the topic above the name of a device of Zigbee2MQTT, which may have several levels."""
    for topic in topics:
        base, name, _ = f"{topic}/".partition(f"/{sighting.name}/")
        if name:
            return base
    return topics[0].removesuffix("/set").rpartition("/")[0] if topics else ""


def _addresses_of(identifiers: Iterable[str]) -> Iterator[str]:
    """Yield the radio addresses as Zigbee2MQTT writes them in topics."""
    for identifier in identifiers:
        kind, _, address = identifier.partition(":")
        if kind == "eui64":
            yield f"0x{address}"


def bridge_of(sighting: Sighting) -> str:
    """Return the declared identifier of the device behind which another is; empty for none."""
    for fact in sighting.metadata:
        if fact.key == "via_device":
            return fact.value
    return ""
