"""Tree of the topics that announcements name, and the rules by which a topic belongs to one of them. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter

from homebot.discovery.source_record import SourceKey
from homebot.discovery.topics.use import TopicUse, aliases_of, is_called

__all__ = ["TopicNode", "has_use", "is_undisputed", "used_below", "verdicts_of", "without_use"]

_COMMON = 3
_IS_NATIVE, _ASKS = attrgetter("is_native"), attrgetter("asks")


@dataclass(slots=True, eq=False)
class TopicNode:
    """One topic: the topics below, the announcements with commands or states there, and the device that owns it.

    Attributes:
        verdicts: The owner, for each announcement that may not use it.
    """

    parent: TopicNode | None = None
    level: str = ""
    children: dict[str, TopicNode] | None = None
    users: tuple[TopicUse, ...] = ()
    speakers: tuple[TopicUse, ...] = ()
    owners: tuple[TopicUse, ...] = ()
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
        """True when nothing is known of the topic and those below it."""
        return not (self.children or self.users or self.speakers or self.owners)


def has_use(uses: Iterable[TopicUse], key: SourceKey) -> bool:
    """Return whether one of *uses* is that of the announcement *key*."""
    return any(one.key == key for one in uses)


def without_use(uses: Iterable[TopicUse], key: SourceKey) -> tuple[TopicUse, ...]:
    """Return *uses* without the one of the announcement *key*."""
    return tuple(one for one in uses if one.key != key)


def used_below(node: TopicNode, most: int | None = None) -> Iterator[TopicNode]:
    """Yield the topic and all below it that are command topics, at most *most* topics being looked at."""
    waiting = [node]
    count = 0
    while waiting and (most is None or count < most):
        one = waiting.pop()
        count += 1
        if one.users:
            yield one
        if one.children:
            waiting.extend(one.children.values())


def is_undisputed(node: TopicNode) -> bool:
    """Return whether one device alone names the topic or one above it; most topics are such."""
    users, speakers = node.users, node.speakers
    if not users:
        return True
    if len(users) > 1 or node.owners or len(speakers) > 1 or (speakers and speakers[0].device != users[0].device):
        return False
    above = node.parent
    while above is not None:
        if above.users or above.owners:
            return False
        above = above.parent
    return True


def verdicts_of(node: TopicNode) -> dict[SourceKey, str]:
    """Return which announcements may not use a topic, each with the device that has it."""
    users = node.users
    if not users:
        return {}
    if owners := _owners(node):
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
        stronger = [one for one, held in holders if held > rank]
        if owner := _other_device(use, stronger):
            found[use.key] = owner
        elif rank == top and use.key not in winners:
            found[use.key] = _other_device(use, best) or use.device
        elif rank < top and not _goes_with_own(use, best):
            found[use.key] = best[0].device
    return found


def _other_device(use: TopicUse, others: Iterable[TopicUse]) -> str:
    """Return the device of the first of *others* that is not of the same device; empty if there is none."""
    return next((one.device for one in others if one.device != use.device), "")


def _goes_with_own(use: TopicUse, best: list[TopicUse]) -> bool:
    """Return whether *use* goes with one of the *best* that is of its device: by its place, or as a repetition."""
    own = [one for one in best if one.device == use.device]
    return _has_a_name_of(use, own) or any(map(use.repeats, own))


def _owners(node: TopicNode | None) -> tuple[TopicUse, ...]:
    """Return the owners of the topic; of those that are above each other the nearest."""
    while node is not None:
        if node.owners:
            return node.owners
        node = node.parent
    return ()


def _holders(node: TopicNode) -> list[tuple[TopicUse, str]]:
    """Return those that publish on the topic, and those that take commands on one above it, with that topic."""
    found = [(one, node.topic) for one in node.speakers]
    above = node.parent
    while above is not None:
        if above.users:
            found += [(one, above.topic) for one in above.users]
        above = above.parent
    return found


def _not_of(owners: tuple[TopicUse, ...], users: Iterable[TopicUse]) -> dict[SourceKey, str]:
    """Return those of *users* that are not the owners' device, or were announced at a place that does not name it."""
    found: dict[SourceKey, str] = {}
    for use in users:
        own = [one for one in owners if one.device == use.device]
        if not any(is_called(use.announced_on, aliases_of(one.owns, one.identifiers)) for one in own):
            found[use.key] = (own or owners)[0].device
    return found


def _winners(best: list[TopicUse]) -> list[TopicUse]:
    """Return which of those named equally well may use the topic: all, or none, or the device's own.

    Beside a device that always asks none that does not: a lamp on the topic of a lock may unlock it.
    """
    if len(best) == 1:
        return best
    devices = {one.device for one in best}
    is_one_sender = bool(frozenset.intersection(*(one.names() for one in best)))
    if len(devices) == 1:
        is_one_use = is_one_sender or all(map(best[0].repeats, best))
        return best if is_one_use else list(filter(_IS_NATIVE, best))
    if not (is_one_sender or len(devices) >= _COMMON) or not _is_shared(best):
        return []
    return list(filter(_ASKS, best)) or best


def _is_shared(best: list[TopicUse]) -> bool:
    """Return whether a topic is for several devices: they are behind one bridge, or do not identify themselves."""
    bridges = {one.bridge for one in best}
    return (len(bridges) == 1 and "" not in bridges) or all(one.is_anonymous for one in best)


def _has_a_name_of(use: TopicUse, others: Iterable[TopicUse]) -> bool:
    own = use.names()
    return any(not own.isdisjoint(one.names()) for one in others)
