"""The grouping of announcements into devices: those that share a sufficiently specific identifier. Pure.

- A radio address (``eui64:``) always is specific.
- A hardware address (``mac:``) is, unless it belongs to a host that represents several devices: announcements that are
  each of a whole device, or whose other identifiers have nothing in common.
- Any other identifier is, unless it is a word that many devices share, or comes with different hardware addresses.
- A topic is, if the device has it to itself, or if all its topics are below one that ends with its identifier: Home
  Assistant calls it ``BigSlowDog``, Homie ``valetudo/BigSlowDog``.
- None is that two devices claim whose gateway knows them apart, nor one that a third has in common with several such.
- A host on a local network (``id:host nas.local``) is, among the services that one gateway found there, unless several
  of them offer parts, as a computer may run the programs of many devices. So is a hardware address in its services.

The owner's decisions outrank all of this: they can declare an identifier to be no evidence, or add one.

Order of arrival matters as little as possible: the same announcements in any order make the same devices.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from itertools import chain, combinations
from operator import attrgetter
from typing import Final, NamedTuple, TypeAlias, final

from homebot.devices import Sighting
from homebot.devices.identity import HOST
from homebot.discovery.merging.decisions import OWNER, MergeDecisions
from homebot.discovery.source_record import SourceKey

REPEATED = "repeated:"
"""Prefix of identifiers for announcements of one part, whatever they call its device."""

MAX_IDENTIFIERS = 16
"""Identifiers of one announcement that count: the first ones, hardware addresses before others."""

MAX_HOLDERS = 64
"""Most identities that may share an identifier; beyond that, it identifies nothing."""

_SHORTEST = 4
_WORDS = """
none null unknown undefined default test device devices mydevice my_device sensor sensors switch light lamp relay bridge
gateway hub home house node root main mqtt mqtt-io mqttio mqtt_io mqttdevice mqtt_device esp esp32 esp8266 esphome
espressif arduino tasmota shelly zigbee zigbee2mqtt zwave homie homeassistant home-assistant hass raspberrypi raspberry
rpi wled openmqttgateway rtl_433 rtl433 system server controller thermostat unique_id identifier identifiers serial
"""
_GENERIC = frozenset(_WORDS.split())


def is_generic(word: str) -> bool:
    """Return whether many devices are called *word*, so that it identifies none of them."""
    return word in _GENERIC


class Identity(NamedTuple):
    """An identity; announcements with the same identity describe one device.

    Attributes:
        key: The announcement, if it is a device of its own.
        offers_parts: Whether it is a service of a host and offers parts; None if it names no host.
    """

    gateway: str
    convention: str
    identifiers: tuple[str, ...]
    key: str
    offers_parts: bool | None

    @property
    def is_told_apart(self) -> bool:
        """True if it is a device for sure, as its gateway has a key for each."""
        return bool(self.key) and not self.convention

    @property
    def hardware(self) -> frozenset[str]:
        """Its identifiers that are hardware addresses."""
        return frozenset(identifier for identifier in self.identifiers if identifier.startswith(_HARDWARE))

    @property
    def others(self) -> frozenset[str]:
        """Its other identifiers."""
        return frozenset(identifier for identifier in self.identifiers if identifier.startswith("id:"))


@final
class IdentityGraph:
    """The graph of shared identifiers.

    Attributes:
        cut: Announcements of which some identifiers were left out.
        told_apart: The number of identities that are a device for sure.
    """

    def __init__(self, decisions: MergeDecisions) -> None:
        self.cut = 0
        self._decisions = decisions
        self._identities: dict[SourceKey, Identity] = {}
        self._sources: dict[Identity, dict[SourceKey, None]] = {}
        self._holders: dict[str, dict[Identity, None]] = {}
        self._links: dict[str, bool] = {}
        self._repeated: dict[SourceKey, str] = {}
        self.told_apart = 0

    def put(self, key: SourceKey, sighting: Sighting) -> frozenset[SourceKey]:
        """Record the identity that the announcement *key* gives its device.

        Returns:
            At least one announcement of each device whose connections may have changed; if the identity is new, all
            announcements that it may connect. Empty if nothing changed.
        """
        identity = self._identity_of(key, sighting)
        before = self._identities.get(key)
        if before == identity:
            return frozenset()
        affected = self.discard(key) if before is not None else frozenset()
        self._identities[key] = identity
        sources = self._sources.get(identity)
        if sources is not None:
            self._identities[key] = self._identities[next(iter(sources))]  # one object for all of them
            sources[key] = None
            return affected | {key}
        self._sources[identity] = {key: None}
        self.told_apart += identity.is_told_apart
        changed: set[str] = set()
        for identifier in identity.identifiers:
            holders = self._holders.setdefault(identifier, {})
            holders[identity] = None
            if len(holders) > 1:
                changed.add(identifier)
        if changed:
            touched = self._touched(changed)
            return affected | self._affected(
                {identity}, {identifier: self._links.pop(identifier, True) for identifier in touched}
            )
        return affected | {key} if affected else frozenset((key,))

    def same_identity(self, key: SourceKey) -> SourceKey | None:
        """Return an older announcement with the same identity, or None."""
        first = next(iter(self._sources[self._identities[key]]))
        return None if first == key else first

    def discard(self, key: SourceKey) -> frozenset[SourceKey]:
        """Forget *key*; return the announcements whose connections may have changed."""
        identity = self._identities.pop(key, None)
        if identity is None:
            return frozenset()
        sources = self._sources[identity]
        del sources[key]
        if sources:
            return frozenset(sources)
        del self._sources[identity]
        were_links = {
            identifier: self._links.pop(identifier, True) for identifier in self._touched(identity.identifiers)
        }
        self.told_apart -= identity.is_told_apart
        for identifier in identity.identifiers:
            holders = self._holders[identifier]
            del holders[identity]
            if not holders:
                del self._holders[identifier]
        return self._affected(set(), were_links)

    def bind(self, keys: Iterable[SourceKey]) -> bool:
        """Connect announcements of one part by an identifier of their own; return whether that is new for any.

        Connected announcements need another :meth:`put`. The owner may still split them.
        """
        keys = sorted(keys)
        known = [self._repeated[key] for key in keys if key in self._repeated]
        name = known[0] if known else f"{REPEATED}{'/'.join(keys[0])}"
        is_new = any(self._repeated.get(key) != name for key in keys)
        self._repeated.update(dict.fromkeys(keys, name))
        return is_new

    def unbind(self, key: SourceKey) -> bool:
        """Undo :meth:`bind` for *key*; return whether it was bound, and so needs another :meth:`put`."""
        return bool(self._repeated) and self._repeated.pop(key, None) is not None

    def forget_links(self, identifiers: Iterable[str]) -> None:
        """Forget whether *identifiers* connect the announcements that share them: the owner has decided."""
        for identifier in identifiers:
            self._links.pop(identifier, None)

    def groups(self, keys: Iterable[SourceKey]) -> tuple[frozenset[SourceKey], ...]:
        """Return the devices that the announcements *keys* describe, each as the set of its announcements."""
        groups: list[frozenset[SourceKey]] = []
        done: set[Identity] = set()
        for key in keys:
            identity = self._identities.get(key)
            if identity is None or identity in done:
                continue
            identities = self._find_connected((identity,))
            done |= identities
            groups.append(frozenset(source for member in identities for source in self._sources[member]))
        return tuple(groups)

    def shared(self, keys: Iterable[SourceKey]) -> Iterator[tuple[str, tuple[SourceKey, ...]]]:
        """Yield each identifier that connects identities among *keys*, with one announcement of each identity."""
        connected = dict.fromkeys(self._identities[key] for key in keys if key in self._identities)
        identities = {identity: number for number, identity in enumerate(connected)}
        if len(identities) < _PAIR:
            return
        for identifier in dict.fromkeys(identifier for identity in identities for identifier in identity.identifiers):
            sharing = sorted(self._holders[identifier].keys() & identities.keys(), key=identities.__getitem__)
            if len(sharing) >= _PAIR and self._is_link(identifier):
                yield identifier, tuple(next(iter(self._sources[identity])) for identity in sharing)

    def claimed_twice(self, keys: Iterable[SourceKey]) -> Iterator[tuple[str, SourceKey, SourceKey]]:
        """Yield each identifier that an announcement of *keys* shares with one that its gateway tells apart."""
        for key in keys if self.told_apart > 1 else ():
            identity = self._identities[key]
            for identifier in identity.identifiers if identity.is_told_apart else ():
                for other in self._holders[identifier]:
                    if other is not identity and other.is_told_apart and other.gateway == identity.gateway:
                        yield identifier, key, next(iter(self._sources[other]))

    def _identity_of(self, key: SourceKey, sighting: Sighting) -> Identity:
        identifiers = sighting.identifiers
        if len(identifiers) > MAX_IDENTIFIERS:
            self.cut += 1
            identifiers = identifiers[:MAX_IDENTIFIERS]
        names_host, names_device = _names_in(identifiers)
        offers_parts = bool(sighting.parts) if names_host else None
        is_own = sighting.whole_device or not (names_device or (names_host and not offers_parts))
        if place := _own_topic(sighting):
            identifiers = tuple(dict.fromkeys((*identifiers, f"id:{place}")))
        if given := self._decisions.merged.get(key):
            identifiers = (*identifiers, given)
        if self._repeated and (name := self._repeated.get(key)):
            identifiers = (*identifiers, name)
        return Identity(key[0], sighting.convention, identifiers, key[1] if is_own else "", offers_parts)

    def _affected(self, reached: set[Identity], were_links: Mapping[str, bool]) -> frozenset[SourceKey]:
        """Return the announcements of *reached*, and of all that these identifiers connect now or did before."""
        for identifier, was_link in were_links.items():
            if identifier in self._holders and (was_link or self._is_link(identifier)):
                reached |= self._find_connected(self._holders[identifier])
        return frozenset(source for identity in reached for source in self._sources[identity])

    def _find_connected(self, identities: Iterable[Identity]) -> set[Identity]:
        """Return everything connected to one of *identities*, directly or through others."""
        reached = set(identities)
        waiting = list(reached)
        while waiting:
            for identifier in waiting.pop().identifiers:
                holders = self._holders[identifier]
                if len(holders) > 1 and self._is_link(identifier):
                    new = holders.keys() - reached
                    reached |= new
                    waiting.extend(new)
        return reached

    def _is_link(self, identifier: str) -> bool:
        known = self._links.get(identifier)
        if known is None:
            known = (
                identifier not in self._decisions.ignored
                and _is_specific(identifier, self._holders[identifier])
                and not (self.told_apart and self._joins_two(identifier))
            )
            self._links[identifier] = known
        return known

    def _touched(self, identifiers: Iterable[str]) -> Iterable[str]:
        """Return *identifiers* and those beside them, on which it depends whether two become one by a third."""
        if not self.told_apart:
            return identifiers
        near = dict.fromkeys(identifiers)
        for holders in [self._holders[name] for name in near]:
            for identity in holders if len(holders) <= MAX_HOLDERS else ():
                near |= dict.fromkeys(identity.identifiers)
        return near

    def _joins_two(self, identifier: str) -> bool:
        """Return whether *identifier* would make devices one that a gateway tells apart, by itself or by a third."""
        if identifier.startswith((OWNER, REPEATED)):
            return False
        holders = self._holders[identifier]
        apart = {holder.gateway: holder for holder in holders if holder.is_told_apart}
        if sum(holder.is_told_apart for holder in holders) > len(apart):
            return True
        others = dict.fromkeys(
            name for holder in holders if apart and holder not in apart.values() for name in holder.identifiers
        )
        for name in others:
            known = self._holders[name]
            if _is_specific(name, known):
                beside = [identity for identity in known if identity.is_told_apart]
                sole = {identity.gateway: identity for identity in beside}
                if len(sole) == len(beside) and any(
                    apart.get(identity.gateway, identity) is not identity for identity in beside
                ):
                    return True
        return False


_PAIR = 2
_TOPICS: Final = attrgetter("reads", "writes")
_HARDWARE = ("mac:", "eui64:")


_Holders: TypeAlias = dict[Identity, None]
"""The identities that share an identifier."""


def _is_specific(identifier: str, holders: _Holders) -> bool:
    """Return whether *identifier* connects its *holders*, by the first rule for its prefix."""
    for prefix, most, connects in _RULES:
        if identifier.startswith(prefix):
            return len(holders) <= most and connects(identifier, holders)
    return False


def _always(_identifier: str, _holders: _Holders) -> bool:
    return True


def _is_of_one_host(_identifier: str, holders: _Holders) -> bool:
    is_one_network = len({holder.gateway for holder in holders}) == 1
    return is_one_network and sum(bool(holder.offers_parts) for holder in holders) < _PAIR


def _is_of_no_host(_identifier: str, holders: _Holders) -> bool:
    return not any(_share_a_host(identity, other) for identity, other in combinations(holders, 2))


def _is_of_one_hardware(identifier: str, holders: _Holders) -> bool:
    if not _is_specific_word(identifier) or len(identifier) < len("id:") + _SHORTEST:
        return False
    known = [hardware for identity in holders if (hardware := identity.hardware)]
    if any(hardware.isdisjoint(other) for hardware, other in combinations(known, 2)):
        return False
    hosts: dict[str, str] = {}  # of each gateway: names in two networks say nothing
    named = [
        (holder.gateway, name)
        for holder in holders
        if holder.offers_parts
        for name in holder.others
        if name.startswith(HOST)
    ]
    return all(hosts.setdefault(gateway, name) == name for gateway, name in named)


_RULES: Final[tuple[tuple[str, float, Callable[[str, _Holders], bool]], ...]] = (
    (OWNER, math.inf, _always),
    (REPEATED, math.inf, _always),
    ("eui64:", MAX_HOLDERS, _always),
    (HOST, MAX_HOLDERS, _is_of_one_host),
    ("mac:", MAX_HOLDERS, _is_of_no_host),
    ("", MAX_HOLDERS, _is_of_one_hardware),
)
"""Prefix of an identifier, the most identities that it connects, and the test whether they are one device."""


def _share_a_host(identity: Identity, other: Identity) -> bool:
    """Return whether a shared hardware address is that of their host, which describes both in the same way."""
    if (identity.gateway, identity.convention) != (other.gateway, other.convention):
        return False
    if None not in (both := {identity.offers_parts, other.offers_parts}) and False in both:
        return False
    if identity.key or other.key:
        return True
    mine, others = identity.others, other.others
    return bool(mine) and bool(others) and mine.isdisjoint(others)


@lru_cache(maxsize=4096)  # a device may be announced in dozens of messages
def _names_in(identifiers: tuple[str, ...]) -> tuple[bool, bool]:
    """Return whether *identifiers* include a host, and whether they include anything else that is specific."""
    host = device = False
    for identifier in identifiers:
        if identifier.startswith(HOST):
            host = True
        elif not identifier.startswith("id:") or identifier[3:].casefold() not in _GENERIC:
            device = True
    return host, device


def _own_topic(sighting: Sighting) -> str:
    """Return the topic below which everything belongs to the device; empty if unknown."""
    if sighting.whole_device:
        return sighting.owns[0] if sighting.owns else ""
    topics: tuple[str, ...] = ()
    for identifier in sighting.identifiers:
        if not identifier.startswith("id:") or identifier[len("id:") :].casefold() in _GENERIC:
            continue
        topics = topics or tuple(chain.from_iterable(chain.from_iterable(map(_TOPICS, sighting.parts))))
        if prefix := _common_prefix(topics, identifier[len("id:") :]):
            return prefix
    return ""


def _common_prefix(topics: tuple[str, ...], name: str) -> str:
    """Return the topic that ends with *name* and is above all *topics*; empty for none."""
    before, level, _ = topics[0].partition(f"/{name}/") if topics else ("", "", "")
    is_above_all = bool(level) and all(topic.startswith(f"{before}{level}") for topic in topics)
    return f"{before}/{name}" if is_above_all else ""


def _is_specific_word(identifier: str) -> bool:
    return not identifier.startswith("id:") or identifier[3:].casefold() not in _GENERIC
