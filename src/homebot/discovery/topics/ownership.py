"""Ownership of command topics: a device may not use a topic that belongs to another. Pure.

Any client may announce anything, such as a lamp with the command topic of a lock. Being first does not count:

- Below the base topic of a Zigbee2MQTT with a device that always asks, no announcement of another program may use a
  topic: the bridge takes commands to a lock on many topics, also those of groups.
- A topic below one that a bridge gives to a device belongs to that device alone. Another announcement may use it if it
  describes the same device and was made at a place that names the device.
- Any other topic belongs to the device announced at the place that names it best; see
  :mod:`homebot.discovery.topics.use`. This includes topics on which a device publishes, and those below its command
  topics. In a tie, those directly below belong to a device that always asks, as Zigbee2MQTT takes codes there.
- In a tie of announcements of one device, the topic belongs to those by which the device has reported a value, unless
  another one always asks.
- In another tie, the topic belongs to none, unless it is evidently shared: the devices are behind one bridge or do not
  identify themselves, and there are at least three, or their places have a name in common. Then it belongs to those of
  them that always ask, if there are any.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import final

from homebot.devices.part import Part
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.discovery.topics.use import TopicUse, aliases_of, is_called

MAX_TOPICS = 1000
"""Most topics of one announcement; it may not use further ones."""

MAX_USERS = 256
"""Most announcements with one topic; further ones may not use it."""

MAX_BELOW = 1000
"""Most topics below a command topic that are judged again when that is added or removed."""

MAX_LEVELS = 20
"""Levels of a topic that are distinguished; the rest counts as one."""

NOBODY = "*"
"""The owner of a topic with too many users; not a valid device id."""


_NO_DEVICES: frozenset[str] = frozenset()


@final
class TopicOwnership:
    """Ownership of command topics.

    Its answers depend on the known announcements, not on their order of arrival.

    Attributes:
        denied: Announcements with topics that belong to others, and the number of such topics.
    """

    def __init__(self) -> None:
        self._roots: dict[str, TopicNode] = {}
        self._uses: dict[SourceKey, TopicUse] = {}
        self.denied: dict[SourceKey, int] = {}
        self._over_limit: set[SourceKey] = set()

    def put(self, use: TopicUse) -> frozenset[str]:
        """Update the topics of an announcement; return the devices whose ownership has changed."""
        before = self._uses.get(use.key)
        if before == use:
            return frozenset()
        touched: dict[TopicNode, None] = {}
        if before is not None:
            self._leave(before, touched)
        if use.writes or use.reads or use.owns or use.base:
            self._uses[use.key] = use
            self._enter(use, touched)
        return self._judge(touched, use.device)

    def discard(self, key: SourceKey) -> frozenset[str]:
        """Remove an announcement; return the devices concerned."""
        use = self._uses.get(key)
        if use is None:
            return frozenset()
        touched: dict[TopicNode, None] = {}
        self._leave(use, touched)
        return self._judge(touched, use.device)

    def owner(self, key: SourceKey, topic: str) -> str:
        """Return the owner of *topic* if the announcement *key* may not use it; otherwise empty.

        It is the announcement's own device if another of its announcements has the topic, and :data:`NOBODY` if
        too many want it.
        """
        use = self._uses.get(key)
        if use is None:
            return NOBODY
        if key not in self.denied and key not in self._over_limit:
            return ""
        node = self._find(key[0], topic)
        if node is not None and use in node.users:
            return node.verdicts.get(key, "") if node.verdicts else ""
        return "" if use.has(topic) else NOBODY

    def repetitions(self, key: SourceKey) -> tuple[SourceKey, ...]:
        """Return the other announcements of the same part; usually there are none."""
        use = self._uses.get(key)
        if use is None or not use.commands:
            return ()
        node = self._find(key[0], use.writes[0])
        if node is None or len(node.users) == 1:
            return ()
        return tuple([user.key for user in node.users if user.key != key and use.repeats(user)])

    def conflict(self, source: SourceRecord, part: Part) -> str:
        """Return in words which other announcement has a topic of *part* of *source*; empty for none."""
        key = source.key
        if key not in self.denied and key not in self._over_limit and key in self._uses:
            return ""
        for topic in part.writes:
            owner = self.owner(key, topic)
            if owner:
                wants = f"{source.label} takes commands on {topic},"
                if owner == NOBODY:
                    return f"{wants} which too many other devices use"
                if owner == self._uses[source.key].device:
                    return f"{wants} where another announcement of the device takes different ones"
                return f"{wants} which belongs to {owner}"
        return ""

    def _enter(self, use: TopicUse, touched: dict[TopicNode, None]) -> None:
        for prefix in dict.fromkeys(use.owns):
            node = self._at(use, prefix)
            node.owners = (*node.owners, use)
            touched.update(dict.fromkeys(_used_below(node)))
        if use.base:
            node = self._at(use, use.base)
            before, node.bases = node.bases, (*node.bases, use)
            if _rule_of(before) != _rule_of(node.bases):
                touched.update(dict.fromkeys(_used_below(node)))
        self._enter_commands(use, touched)
        for topic in use.reads[:MAX_TOPICS]:
            if "+" in topic or "#" in topic or (use.owns and use.has(topic)):
                continue
            node = self._at(use, topic)
            node.speakers = (*node.speakers, use)
            if node.users:
                touched[node] = None

    def _enter_commands(self, use: TopicUse, touched: dict[TopicNode, None]) -> None:
        if len(use.writes) > MAX_TOPICS:
            self._over_limit.add(use.key)
        for topic in use.writes[:MAX_TOPICS]:
            if use.owns and use.has(topic):
                continue
            node = self._at(use, topic)
            if len(node.users) >= MAX_USERS:
                self._over_limit.add(use.key)
                continue
            node.users = (*node.users, use)
            touched[node] = None
            if node.children and use.counts_below(topic):
                touched.update(dict.fromkeys(_used_below(node, MAX_BELOW)))

    def _leave(self, use: TopicUse, touched: dict[TopicNode, None]) -> None:
        del self._uses[use.key]
        self._over_limit.discard(use.key)
        for topic in dict.fromkeys((*use.owns, *use.writes, *use.reads, *([use.base] if use.base else ()))):
            node = self._find(use.key[0], topic)
            if node is None:
                continue
            is_owner, is_user, bases = use in node.owners, use in node.users, node.bases
            node.owners, node.users = _without(node.owners, use), _without(node.users, use)
            node.bases = _without(bases, use)
            is_owner = is_owner or _rule_of(bases) != _rule_of(node.bases)
            node.speakers = _without(node.speakers, use)
            touched[node] = None
            if node.children and (is_owner or (is_user and use.counts_below(topic))):
                touched.update(dict.fromkeys(_used_below(node, None if is_owner else MAX_BELOW)))

    def _judge(self, touched: Iterable[TopicNode], device: str) -> frozenset[str]:
        """Judge the topics *touched* again; return the devices, except *device*, for which that matters."""
        concerned: set[str] = set()
        for node in touched:
            before, node.verdicts = node.verdicts, None if _is_undisputed(node) else _verdicts_of(node) or None
            if before or node.verdicts:
                known, now = before or {}, node.verdicts or {}
                for key in known.keys() - now.keys():
                    left = self.denied.pop(key) - 1
                    if left:
                        self.denied[key] = left
                for key in now.keys() - known.keys():
                    self.denied[key] = self.denied.get(key, 0) + 1
                concerned.update(use.device for use in node.users if known.get(use.key) != now.get(use.key))
            if not node.users and node.is_unused:
                self._tidy(node)
        concerned.discard(device)
        return frozenset(concerned) if concerned else _NO_DEVICES

    def _at(self, use: TopicUse, topic: str) -> TopicNode:
        node = self._roots.get(use.key[0])
        if node is None:
            node = self._roots[use.key[0]] = TopicNode()
        for level in topic.split("/", MAX_LEVELS):
            if node.children is None:
                node.children = {}
            child = node.children.get(level)
            if child is None:
                child = node.children[level] = TopicNode(node, level)
            node = child
        return node

    def _find(self, gateway: str, topic: str) -> TopicNode | None:
        node = self._roots.get(gateway)
        for level in topic.split("/", MAX_LEVELS):
            if node is None or node.children is None:
                return None
            node = node.children.get(level)
        return node

    def _tidy(self, node: TopicNode) -> None:
        while node.parent is not None and node.is_unused:
            parent = node.parent
            if parent.children is not None:
                parent.children.pop(node.level, None)
            node = parent


_COMMON = 3
_IS_NATIVE, _ASKS, _BRIDGE = attrgetter("is_native"), attrgetter("asks"), attrgetter("bridge")
_IS_HEARD = attrgetter("is_heard")


@dataclass(slots=True, eq=False)
class TopicNode:
    """One topic: the topics below, the announcements with commands or states there, and its owner.

    Attributes:
        verdicts: The owner, by announcement that may not use the topic.
    """

    parent: TopicNode | None = None
    level: str = ""
    children: dict[str, TopicNode] | None = None
    users: tuple[TopicUse, ...] = ()
    speakers: tuple[TopicUse, ...] = ()
    owners: tuple[TopicUse, ...] = ()
    bases: tuple[TopicUse, ...] = ()
    verdicts: dict[SourceKey, str] | None = None

    @property
    def topic(self) -> str:
        """The topic."""
        levels: list[str] = []
        node: TopicNode = self
        while node.parent is not None:
            levels.append(node.level)
            node = node.parent
        return "/".join(reversed(levels))

    @property
    def is_unused(self) -> bool:
        """True if nothing is known of the topic and of those below it."""
        return not (self.children or self.users or self.speakers or self.owners or self.bases)


def _without(uses: tuple[TopicUse, ...], use: TopicUse) -> tuple[TopicUse, ...]:
    return tuple(other for other in uses if other.key != use.key)


def _rule_of(bases: tuple[TopicUse, ...]) -> tuple[str, frozenset[str]]:
    """Return what decides on the topics below a base: the second lock of a bridge leaves it as it is."""
    return (bases[0].device if bases else "", frozenset(map(_BRIDGE, bases)))


def _used_below(node: TopicNode, most: int | None = None) -> Iterator[TopicNode]:
    """Yield the command topics at and below *node*, after looking at no more than *most* topics."""
    waiting = [node]
    count = 0
    while waiting and (most is None or count < most):
        below = waiting.pop()
        count += 1
        if below.users:
            yield below
        if below.children:
            waiting.extend(below.children.values())


def _is_undisputed(node: TopicNode) -> bool:
    """Return whether a single device uses the topic or those above it, as is usual."""
    users, speakers = node.users, node.speakers
    if not users:
        return True
    if len(users) > 1 or node.owners or len(speakers) > 1 or (speakers and speakers[0].device != users[0].device):
        return False
    above = node.parent
    while above is not None:
        if above.users or above.owners or above.bases:
            return False
        above = above.parent
    return True


def _verdicts_of(node: TopicNode) -> dict[SourceKey, str]:
    """Return the announcements that may not use a topic, each with the owner."""
    strangers = _verdicts_on_strangers(node)
    users = tuple(user for user in node.users if user.key not in strangers) if strangers else node.users
    return {**strangers, **_verdicts_among(users, node)} if users else strangers


def _verdicts_on_strangers(node: TopicNode) -> dict[SourceKey, str]:
    """Return the announcements of other programs below the base topic of a bridge, each with a device that asks."""
    above = node.parent
    while above is not None and not above.bases:
        above = above.parent
    if above is None:
        return {}
    bridges = {base.bridge for base in above.bases}
    return {user.key: above.bases[0].device for user in node.users if user.bridge not in bridges}


def _verdicts_among(users: tuple[TopicUse, ...], node: TopicNode) -> dict[SourceKey, str]:
    if owners := _owners(node):
        return _not_of(owners, users)
    topic = node.topic
    # Those that publish on the topic, and those with commands on a topic above, with their ranks.
    holders = [(speaker, float(speaker.rank(topic))) for speaker in node.speakers]
    above = node.parent
    while above is not None:
        if above.users:
            topic, tie = above.topic, _TIE if above is node.parent else 0.0
            holders += [(user, user.rank(topic) + (tie if user.asks else 0.0)) for user in above.users]
        above = above.parent
    if len(users) == 1 and all(holder.device == users[0].device for holder, _ in holders):
        return {}
    return _by_place(node.topic, users, holders)


def _by_place(topic: str, users: tuple[TopicUse, ...], holders: list[tuple[TopicUse, float]]) -> dict[SourceKey, str]:
    holders.sort(key=lambda held: -held[1])
    ranks = [(user, user.rank(topic)) for user in users]
    top, best = _best(ranks)
    winners = {winner.key for winner in _winners(best)}
    owners: dict[SourceKey, str] = {}
    for use, rank in ranks:
        if owner := _stronger_device(use, rank, holders):
            owners[use.key] = owner
        elif rank == top and use.key not in winners:
            owners[use.key] = _other_device(use, best) or use.device
        elif rank < top and not _goes_with_own(use, best):
            owners[use.key] = best[0].device
    return owners


def _best(ranks: list[tuple[TopicUse, int]]) -> tuple[int, list[TopicUse]]:
    top = max(rank for _, rank in ranks)
    return top, [best_use for best_use, rank in ranks if rank == top]


def _stronger_device(use: TopicUse, rank: int, holders: list[tuple[TopicUse, float]]) -> str:
    """Return the other device that holds the topic with a higher rank than *use*; empty for none."""
    own = rank + _TIE if use.asks else rank
    return _other_device(use, [holder for holder, held in holders if held > own])


def _other_device(use: TopicUse, others: Iterable[TopicUse]) -> str:
    """Return the device of the first of *others* with another device; empty for none."""
    return next((other.device for other in others if other.device != use.device), "")


def _goes_with_own(use: TopicUse, best: list[TopicUse]) -> bool:
    """Return whether *use* belongs with one of *best* of the same device: by its place, or as a repetition."""
    own = [candidate for candidate in best if candidate.device == use.device]
    return _has_a_name_of(use, own) or any(map(use.repeats, own))


def _owners(node: TopicNode | None) -> tuple[TopicUse, ...]:
    """Return the owners of the topic; the nearest, if one is above another."""
    while node is not None:
        if node.owners:
            return node.owners
        node = node.parent
    return ()


_TIE = 0.5
"""What a claim counts more in a tie."""


def _not_of(owners: tuple[TopicUse, ...], users: Iterable[TopicUse]) -> dict[SourceKey, str]:
    """Return the *users* that are not the owners' device, or were announced at a place that does not name it."""
    by_key: dict[SourceKey, str] = {}
    for use in users:
        own = [owner for owner in owners if owner.device == use.device]
        if not any(is_called(use.announced_on, aliases_of(owner.owns, owner.identifiers)) for owner in own):
            by_key[use.key] = (own or owners)[0].device
    return by_key


def _winners(best: list[TopicUse]) -> list[TopicUse]:
    """Return which of the equally well named uses may have the topic: all, none, or those of one device.

    Devices that always ask exclude others: a lamp on the topic of a lock could unlock it.
    """
    if len(best) == 1:
        return best
    devices = {use.device for use in best}
    is_one_sender = bool(frozenset.intersection(*(use.names() for use in best)))
    if len(devices) == 1:
        is_one_use = is_one_sender or all(map(best[0].repeats, best))
        return best if is_one_use else list(filter(_IS_NATIVE, best)) or _heard(best)
    if not (is_one_sender or len(devices) >= _COMMON) or not _is_shared(best):
        return []
    return list(filter(_ASKS, best)) or best


def _heard(best: list[TopicUse]) -> list[TopicUse]:
    """Return the one announcement by which the device has reported; none for several, or if it hides a danger."""
    heard = list(filter(_IS_HEARD, best))
    return heard if len(heard) == 1 and (heard[0].asks or not any(map(_ASKS, best))) else []


def _is_shared(best: list[TopicUse]) -> bool:
    """Return whether a topic is shared by several devices behind one bridge, or without identification."""
    bridges = {use.bridge for use in best}
    return (len(bridges) == 1 and "" not in bridges) or all(use.is_anonymous for use in best)


def _has_a_name_of(use: TopicUse, others: Iterable[TopicUse]) -> bool:
    own = use.names()
    return any(not own.isdisjoint(other.names()) for other in others)
