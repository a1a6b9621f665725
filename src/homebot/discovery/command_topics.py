"""Ownership of command topics: a topic that belongs to one device is not another one's to use. Pure.

Anybody may announce anything, also a lamp whose command topic is a lock's. So it never counts who came first:

- What is below a topic that is a device's own, as the bridge that speaks for it says, is that device's alone. Another
  announcement may name such a topic where it is about the same device and was made at a place that names it.
- Any other topic belongs to who was announced at the place that names it best; see :mod:`homebot.discovery.places`. The
  same goes for topics that a device speaks on, and for what is below its command topics.
- Where that is a tie, the topic is nobody's, unless it is evidently there for several: they are behind one bridge, or
  do not say who they are, and they are three or more, or their places have a name in common.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import NamedTuple, TypeAlias, final

from homebot.devices.part import Part
from homebot.discovery.places import aliases_of, is_called, names, place_of, score
from homebot.discovery.source_record import NATIVE_CONVENTIONS, SourceKey, SourceRecord

__all__ = ["MAX_BELOW", "MAX_LEVELS", "MAX_TOPICS", "MAX_USERS", "NOBODY", "TopicOwnership", "TopicUse", "topic_use"]

MAX_TOPICS = 1000
"""Topics that one announcement is watched on; a further one that it names is not its to use."""

MAX_USERS = 256
"""Announcements that may name one topic; a further one may not use it."""

MAX_BELOW = 1000
"""Topics below a command topic that are looked at anew when that comes or goes."""

MAX_LEVELS = 20
"""Levels of a topic that are told apart; the rest is one."""

_COMMON = 3

NOBODY = "*"
"""Stands for the owner of a topic that too many want; no device is called so."""


class TopicUse(NamedTuple):
    """The topics that one announcement uses.

    Attributes:
        key: The announcement.
        device: Whose it is.
        announced_on: Where it was made.
        writes: Topics that it wants to be told things on.
        reads: Topics that the device speaks on.
        owns: Topics that the device has for itself, with all that is below them.
        identifiers: Who the device is, where it has such topics.
        bridge: The bridge that the device is behind.
        is_anonymous: Whether it does not say who the device is.
        is_native: Whether it is in a convention of devices themselves.
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

    def has(self, topic: str) -> bool:
        """Return whether *topic* is the device's own."""
        return any(topic == prefix or topic.startswith(f"{prefix}/") for prefix in self.owns)

    def rank(self, topic: str) -> int:
        """Return how well the place of the announcement names *topic*."""
        return score(place_of(self.announced_on), topic)

    def names(self) -> frozenset[str]:
        """By which names announcements at other places may be the same device's."""
        return names(place_of(self.announced_on))


def topic_use(claim: SourceRecord, device: str) -> TopicUse:
    """Return what the announcement *claim* of *device* does with topics."""
    sighting = claim.sighting
    writes = _each_once([part.writes for part in sighting.parts])
    if sighting.command_address and sighting.speaks_plainly:
        writes = _each_once([writes, (sighting.command_address,)])
    return TopicUse(
        claim.key,
        device,
        sighting.announced_on,
        writes,
        _each_once([part.reads for part in sighting.parts]),
        sighting.owns,
        sighting.identifiers if sighting.owns else (),
        next((one.value for one in sighting.metadata if one.key == "via_device"), ""),
        not sighting.identifiers,
        sighting.convention in NATIVE_CONVENTIONS,
    )


def _each_once(topics: list[tuple[str, ...]]) -> tuple[str, ...]:
    if len(topics) == 1 and len(topics[0]) <= 1:
        return topics[0]  # the usual case; the same object takes no memory
    return tuple(dict.fromkeys(chain.from_iterable(topics)))


def _is_filter(topic: str) -> bool:
    return "+" in topic or "#" in topic


_Uses: TypeAlias = TopicUse | dict[SourceKey, TopicUse]
"""What several announcements do with a topic; of most topics it is one, which takes no dict."""


@dataclass(slots=True, eq=False)
class _TopicNode:
    """One topic: what is below, who wants to be told things there, who speaks there, and whose own it is.

    Attributes:
        verdicts: Of those who may not use it: who has it.
    """

    parent: _TopicNode | None = None
    level: str = ""
    children: dict[str, _TopicNode] | None = None
    users: _Uses | None = None
    speakers: _Uses | None = None
    owners: _Uses | None = None
    verdicts: dict[SourceKey, str] | None = None

    @property
    def topic(self) -> str:
        levels: list[str] = []
        node: _TopicNode = self
        while node.parent is not None:
            levels.append(node.level)
            node = node.parent
        return "/".join(reversed(levels))

    @property
    def is_unused(self) -> bool:
        return not (self.children or self.users or self.speakers or self.owners)


@final
class TopicOwnership:
    """Keeps who may be told things where.

    What it answers follows from the announcements that are known, whatever the order in which they came.
    """

    def __init__(self) -> None:
        self._roots: dict[str, _TopicNode] = {}
        self._uses: dict[SourceKey, TopicUse] = {}

    def put(self, use: TopicUse) -> frozenset[str]:
        """Note what an announcement does with topics, in place of what it did; return whom that concerns."""
        before = self._uses.get(use.key)
        if before == use:
            return frozenset()
        touched: dict[_TopicNode, None] = {}
        if before is not None:
            self._leave(before, touched)
        if use.writes or use.reads or use.owns:
            self._uses[use.key] = use
            self._enter(use, touched)
        return self._judge(touched) - {use.device}

    def discard(self, key: SourceKey) -> frozenset[str]:
        """Forget an announcement; return whom that concerns."""
        use = self._uses.get(key)
        if use is None:
            return frozenset()
        touched: dict[_TopicNode, None] = {}
        self._leave(use, touched)
        return self._judge(touched) - {use.device}

    def owner(self, key: SourceKey, topic: str) -> str:
        """Return who has *topic*, where that is not for the announcement *key* to use; else empty.

        It is the announcement's own device where another announcement of it has the topic, and :data:`NOBODY` where
        too many want it.
        """
        use = self._uses.get(key)
        if use is None:
            return NOBODY
        node = self._find(key[0], topic)
        if node is not None and _has(node.users, key):
            return node.verdicts.get(key, "") if node.verdicts else ""
        return "" if use.has(topic) else NOBODY

    def conflict(self, source: SourceRecord, part: Part) -> str:
        """Return in words which other announcement has what *part* of *source* would use; empty for none."""
        for topic in part.writes:
            owner = self.owner(source.key, topic)
            if owner:
                return self._conflict_text(source, topic, owner)
        return ""

    def _conflict_text(self, source: SourceRecord, topic: str, owner: str) -> str:
        wants = f"{source.label} wants to be told things on {topic}, where"
        if owner == NOBODY:
            return f"{wants} too many others do"
        if owner == self._uses[source.key].device:
            return f"{wants} another announcement of the device is told something else"
        return f"{wants} {owner} listens"

    def _enter(self, use: TopicUse, touched: dict[_TopicNode, None]) -> None:
        for prefix in use.owns:
            node = self._at(use, prefix)
            node.owners = _with(node.owners, use)
            touched.update(dict.fromkeys(_below(node)))
        for topic in use.writes[:MAX_TOPICS]:
            if use.owns and use.has(topic):
                continue
            node = self._at(use, topic)
            if isinstance(node.users, dict) and len(node.users) >= MAX_USERS:
                continue
            node.users = _with(node.users, use)
            touched[node] = None
            if node.children and use.rank(topic):
                touched.update(dict.fromkeys(_below(node, MAX_BELOW)))
        for topic in use.reads[:MAX_TOPICS]:
            if (use.owns and use.has(topic)) or _is_filter(topic):
                continue
            node = self._at(use, topic)
            node.speakers = _with(node.speakers, use)
            if node.users:
                touched[node] = None

    def _leave(self, use: TopicUse, touched: dict[_TopicNode, None]) -> None:
        del self._uses[use.key]
        for topic in dict.fromkeys((*use.owns, *use.writes, *use.reads)):
            node = self._find(use.key[0], topic)
            if node is None:
                continue
            is_owner = _has(node.owners, use.key)
            is_user = _has(node.users, use.key)
            node.owners = _without(node.owners, use.key)
            node.users = _without(node.users, use.key)
            node.speakers = _without(node.speakers, use.key)
            touched[node] = None
            if node.children and (is_owner or (is_user and use.rank(topic))):
                touched.update(dict.fromkeys(_below(node, None if is_owner else MAX_BELOW)))

    def _judge(self, touched: Iterable[_TopicNode]) -> frozenset[str]:
        """Decide anew on the topics *touched*; return the devices for which that makes a difference."""
        concerned: set[str] = set()
        for node in touched:
            before, node.verdicts = node.verdicts, _verdicts(node) or None
            if before or node.verdicts:
                known, now = before or {}, node.verdicts or {}
                concerned.update(use.device for use in _all(node.users) if known.get(use.key) != now.get(use.key))
            if node.is_unused:
                self._tidy(node)
        return frozenset(concerned)

    def _at(self, use: TopicUse, topic: str) -> _TopicNode:
        node = self._roots.get(use.key[0])
        if node is None:
            node = self._roots[use.key[0]] = _TopicNode()
        for level in topic.split("/", MAX_LEVELS):
            if node.children is None:
                node.children = {}
            child = node.children.get(level)
            if child is None:
                child = node.children[level] = _TopicNode(node, level)
            node = child
        return node

    def _find(self, gateway: str, topic: str) -> _TopicNode | None:
        node = self._roots.get(gateway)
        for level in topic.split("/", MAX_LEVELS):
            if node is None or node.children is None:
                return None
            node = node.children.get(level)
        return node

    def _tidy(self, node: _TopicNode) -> None:
        while node.parent is not None and node.is_unused:
            parent = node.parent
            if parent.children is not None:
                parent.children.pop(node.level, None)
            node = parent


def _with(uses: _Uses | None, use: TopicUse) -> _Uses:
    if isinstance(uses, dict):
        uses[use.key] = use
        return uses
    return use if uses is None or uses.key == use.key else {uses.key: uses, use.key: use}


def _all(uses: _Uses | None) -> Collection[TopicUse]:
    if uses is None:
        return ()
    return uses.values() if isinstance(uses, dict) else (uses,)


def _has(uses: _Uses | None, key: SourceKey) -> bool:
    if uses is None:
        return False
    return key in uses if isinstance(uses, dict) else uses.key == key


def _without(uses: _Uses | None, key: SourceKey) -> _Uses | None:
    if isinstance(uses, dict):
        uses.pop(key, None)
        return uses or None
    return None if _has(uses, key) else uses


def _below(node: _TopicNode, most: int | None = None) -> Iterator[_TopicNode]:
    """The topic and all below it that somebody wants to be told things on."""
    waiting = [node]
    count = 0
    while waiting and (most is None or count < most):
        one = waiting.pop()
        count += 1
        if one.users:
            yield one
        if one.children:
            waiting.extend(one.children.values())


def _verdicts(node: _TopicNode) -> dict[SourceKey, str]:
    """List the announcements that may not use a topic, each with the one that owns it."""
    users = tuple(_all(node.users))
    if not users:
        return {}
    owners = _owners(node)
    if owners:
        return _not_of(owners, users)
    holders = _holders(node)
    if len(users) == 1 and all(one.device == users[0].device for one, _ in holders):
        return {}
    return _by_place(node.topic, users, [(one, one.rank(where)) for one, where in holders])


def _by_place(topic: str, users: tuple[TopicUse, ...], holders: list[tuple[TopicUse, int]]) -> dict[SourceKey, str]:
    holders.sort(key=lambda held: -held[1])
    ranks = [(one, one.rank(topic)) for one in users]
    top = max(rank for _, rank in ranks)
    best = [one for one, rank in ranks if rank == top]
    winners = {one.key for one in _winners(best)}
    found: dict[SourceKey, str] = {}
    for use, rank in ranks:
        stronger = next((one.device for one, held in holders if held > rank and one.device != use.device), "")
        if stronger:
            found[use.key] = stronger
        elif rank < top:
            if not _has_a_name_of(use, (one for one in best if one.device == use.device)):
                found[use.key] = best[0].device
        elif use.key not in winners:
            found[use.key] = next((one.device for one in best if one.device != use.device), use.device)
    return found


def _owners(node: _TopicNode | None) -> tuple[TopicUse, ...]:
    """Return the owners of the topic; of those that are above each other the nearest."""
    while node is not None:
        if node.owners:
            return tuple(_all(node.owners))
        node = node.parent
    return ()


def _holders(node: _TopicNode) -> list[tuple[TopicUse, str]]:
    """Return those that publish on the topic, and those that take commands on one above it, with that topic."""
    found = [(one, node.topic) for one in _all(node.speakers)]
    above = node.parent
    while above is not None:
        if above.users:
            found += [(one, above.topic) for one in _all(above.users)]
        above = above.parent
    return found


def _not_of(owners: tuple[TopicUse, ...], users: Iterable[TopicUse]) -> dict[SourceKey, str]:
    """Those of *users* that are not the owners' device, or were announced at a place that does not name it."""
    found: dict[SourceKey, str] = {}
    for use in users:
        own = [one for one in owners if one.device == use.device]
        place = place_of(use.announced_on)
        if not any(is_called(place, aliases_of(one.owns, one.identifiers)) for one in own):
            found[use.key] = (own or owners)[0].device
    return found


def _winners(best: list[TopicUse]) -> list[TopicUse]:
    """Of those that are named equally well, the ones that may use the topic: all, or none, or the device's own."""
    if len(best) == 1:
        return best
    devices = {one.device for one in best}
    is_one_sender = bool(frozenset.intersection(*(one.names() for one in best)))
    if len(devices) == 1:
        return best if is_one_sender else [one for one in best if one.is_native]
    bridges = {one.bridge for one in best}
    has_one_bridge = len(bridges) == 1 and "" not in bridges
    is_shared = has_one_bridge or all(one.is_anonymous for one in best)
    return best if is_shared and (is_one_sender or len(devices) >= _COMMON) else []


def _has_a_name_of(use: TopicUse, others: Iterable[TopicUse]) -> bool:
    own = use.names()
    return any(not own.isdisjoint(one.names()) for one in others)
