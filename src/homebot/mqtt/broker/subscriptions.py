"""Who wants which topic: a tree of filters, and a cache of what it answered."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, final

from homebot.mqtt.broker.session import Session
from homebot.mqtt.broker.subscription import Subscription

__all__ = ["Route", "ShareGroup", "SubscriptionTree", "Target"]

_MAX_CACHED_TOPICS = 4096  # enough for the busy topics of a house; beyond it the cache starts anew


class Target(NamedTuple):
    """One session that gets a topic: one copy, whatever the number of its subscriptions that match.

    Attributes:
        session: Who.
        qos: The highest QoS of the subscriptions.
        retain_as_published: Whether one of them wants the retain flag kept.
        identifiers: The identifiers of all that have one.
        matched: The subscriptions themselves where one of them has *no local*; empty otherwise.
    """

    session: Session
    qos: int
    retain_as_published: bool
    identifiers: tuple[int, ...]
    matched: tuple[Subscription, ...]

    @classmethod
    def of(cls, session: Session, matched: list[Subscription]) -> Target:
        """Join the subscriptions of one session."""
        return cls(
            session,
            max(each.qos for each in matched),
            any(each.retain_as_published for each in matched),
            tuple(each.identifier for each in matched if each.identifier),
            tuple(matched) if any(each.no_local for each in matched) else (),
        )

    def without_local(self) -> Target | None:
        """What is left of it for a message that the session's own client published."""
        rest = [each for each in self.matched if not each.no_local]
        return Target.of(self.session, rest) if rest else None


@final
class ShareGroup:
    """The members of one ``$share/GROUP/FILTER``; each message goes to one of them.

    Attributes:
        key: Group name and filter.
        members: Sessions in the order of joining, with their subscriptions.
    """

    __slots__ = ("_turn", "key", "members")

    def __init__(self, key: tuple[str, str]) -> None:
        self.key = key
        self.members: dict[Session, Subscription] = {}
        self._turn = 0

    def choose(self) -> tuple[Session, Subscription] | None:
        """The next in turn among those who can take it now, else among those who are slow, else among the absent."""
        members = list(self.members.items())
        if not members:
            return None
        self._turn += 1
        start = self._turn % len(members)
        return min(members[start:] + members[:start], key=lambda member: member[0].reluctance)


class Route(NamedTuple):
    """Everybody who gets one topic."""

    targets: tuple[Target, ...]
    groups: tuple[ShareGroup, ...]


@dataclass(slots=True)
class _Node:
    children: dict[str, _Node] = field(default_factory=dict)
    sessions: dict[Session, Subscription] = field(default_factory=dict)
    groups: dict[str, ShareGroup] = field(default_factory=dict)

    @property
    def empty(self) -> bool:
        return not (self.children or self.sessions or self.groups)


@final
class SubscriptionTree:
    """All subscriptions of all sessions, by the levels of their filters."""

    def __init__(self) -> None:
        self._root = _Node()
        self._cache: dict[str, Route] = {}
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, session: Session, subscription: Subscription) -> None:
        """Add a subscription, or put it in place of the one with the same filter."""
        self._cache.clear()
        node = self._root
        for level in subscription.levels:
            node = node.children.setdefault(level, _Node())
        members = node.sessions
        if subscription.share is not None:
            group = node.groups.setdefault(subscription.share[0], ShareGroup(subscription.share))
            members = group.members
        self._count += session not in members
        members[session] = subscription

    def remove(self, session: Session, subscription: Subscription) -> None:
        """Remove a subscription that was added."""
        self._cache.clear()
        path = [self._root]
        for level in subscription.levels:
            path.append(path[-1].children[level])
        node = path[-1]
        if subscription.share is None:
            del node.sessions[session]
        else:
            group = node.groups[subscription.share[0]]
            del group.members[session]
            if not group.members:
                del node.groups[subscription.share[0]]
        self._count -= 1
        for level, parent in zip(reversed(subscription.levels), reversed(path[:-1]), strict=True):
            if not parent.children[level].empty:
                break
            del parent.children[level]

    def route(self, topic: str) -> Route:
        """Everybody who gets *topic*."""
        route = self._cache.get(topic)
        if route is None:
            if len(self._cache) >= _MAX_CACHED_TOPICS:
                self._cache.clear()
            route = self._cache[topic] = self._find(topic)
        return route

    def group(self, share: tuple[str, str]) -> ShareGroup | None:
        """The group of that name and filter, if it still has members."""
        node: _Node | None = self._root
        for level in share[1].split("/"):
            node = None if node is None else node.children.get(level)
        return None if node is None else node.groups.get(share[0])

    def _find(self, topic: str) -> Route:
        matched: dict[Session, list[Subscription]] = {}
        groups: list[ShareGroup] = []
        for node in self._matching(topic.split("/")):
            for session, subscription in node.sessions.items():
                matched.setdefault(session, []).append(subscription)
            groups.extend(node.groups.values())
        return Route(tuple(Target.of(session, found) for session, found in matched.items()), tuple(groups))

    def _matching(self, levels: list[str]) -> Iterator[_Node]:
        depth = len(levels)
        nodes = [(self._root, 0)]
        while nodes:
            node, index = nodes.pop()
            wild = index or not levels[0].startswith("$")
            if wild and "#" in node.children:
                yield node.children["#"]
            if index == depth:
                yield node
                continue
            if levels[index] in node.children:
                nodes.append((node.children[levels[index]], index + 1))
            if wild and "+" in node.children:
                nodes.append((node.children["+"], index + 1))
