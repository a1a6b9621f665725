"""Subscriptions by topic: a tree of filters, and a cache of its answers. No I/O."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, final

from homebot.mqtt.broker.session_subscription import SessionSubscription
from homebot.mqtt.filter_tree import FilterTree

if TYPE_CHECKING:
    from homebot.mqtt.broker.session import BrokerSession

_MAX_CACHED_TOPICS = 4096  # enough for the busy topics of a house; beyond that the cache starts afresh
_MAX_CACHED_TARGETS = 50_000  # of all cached topics
_MAX_TOPIC_LENGTH = 512  # characters of a cached topic


class Target(NamedTuple):
    """A receiving session of a topic, which gets one copy for all matching subscriptions.

    Attributes:
        matched: The matching subscriptions if one of them has *no local*; otherwise empty.
    """

    session: BrokerSession
    qos: int
    retain_as_published: bool
    identifiers: tuple[int, ...]
    matched: tuple[SessionSubscription, ...]

    @classmethod
    def of(cls, session: BrokerSession, matched: list[SessionSubscription]) -> Target:
        """Combine the subscriptions of one session."""
        highest = 0
        keeps_retain = has_no_local = False
        identifiers: list[int] = []
        for _, _, qos, no_local, retain_as_published, identifier, _ in matched:
            if qos > highest:
                highest = qos
            keeps_retain = keeps_retain or retain_as_published
            has_no_local = has_no_local or no_local
            if identifier:
                identifiers.append(identifier)
        return cls(session, highest, keeps_retain, tuple(identifiers), tuple(matched) if has_no_local else ())

    def without_local(self) -> Target | None:
        """Return what remains for a message of the session's own client."""
        rest = [subscription for subscription in self.matched if not subscription.no_local]
        return Target.of(self.session, rest) if rest else None


@final
class ShareGroup:
    """The members of one ``$share/GROUP/FILTER``; each message goes to one of them.

    Attributes:
        members: Sessions in the order of joining, with their subscriptions.
    """

    __slots__ = ("_turn", "key", "members")

    def __init__(self, key: tuple[str, str]) -> None:
        self.key = key
        self.members: dict[BrokerSession, SessionSubscription] = {}
        self._turn = 0

    def choose(self) -> tuple[BrokerSession, SessionSubscription] | None:
        """Return the next member with room; if there is none, the next slow one, then the next absent one."""
        members = list(self.members.items())
        if not members:
            return None
        self._turn += 1
        start = self._turn % len(members)
        return min(members[start:] + members[:start], key=lambda member: member[0].delivery_priority)


class Recipients(NamedTuple):
    """The sessions and groups that get one topic."""

    targets: tuple[Target, ...]
    groups: tuple[ShareGroup, ...]


@final
class SubscriptionTree:
    """All subscriptions of all sessions, by the levels of their filters."""

    def __init__(self) -> None:
        self._members: FilterTree[BrokerSession, SessionSubscription] = FilterTree()
        self._groups: FilterTree[str, ShareGroup] = FilterTree()
        self._cache: dict[str, Recipients] = {}
        self._cached = 0
        self._count = 0
        self.shared = 0
        self.text = 0

    def __len__(self) -> int:
        return self._count

    @property
    def levels(self) -> int:
        """Levels of all filters; common first levels count once."""
        return self._members.nodes + self._groups.nodes

    def add(self, session: BrokerSession, subscription: SessionSubscription) -> None:
        """Add a subscription, replacing one with the same filter."""
        self.forget_routes()
        if subscription.share is None:
            is_new = self._members.add(subscription.levels, session, subscription)
        else:
            group = self.group(subscription.share)
            if group is None:
                group = ShareGroup(subscription.share)
                self._groups.add(subscription.levels, subscription.share[0], group)
            is_new = session not in group.members
            group.members[session] = subscription
            self.shared += is_new
        if is_new:
            self._count += 1
            self.text += len(subscription.name)

    def remove(self, session: BrokerSession, subscription: SessionSubscription) -> None:
        """Remove a subscription that was added."""
        self.forget_routes()
        if subscription.share is None:
            self._members.remove(subscription.levels, session)
        else:
            group = self.group(subscription.share)
            if group is not None:
                del group.members[session]
                if not group.members:
                    self._groups.remove(subscription.levels, subscription.share[0])
            self.shared -= 1
        self._count -= 1
        self.text -= len(subscription.name)

    def route(self, topic: str) -> Recipients:
        """Return the sessions and groups that get *topic*."""
        route = self._cache.get(topic)
        if route is None:
            levels = topic.split("/")
            matched: dict[BrokerSession, list[SessionSubscription]] = {}
            for members in self._members.matching(levels):
                for session, subscription in members.items():
                    if session.has_ended:
                        continue
                    if session in matched:
                        matched[session].append(subscription)
                    else:
                        matched[session] = [subscription]
            groups = [group for shares in self._groups.matching(levels) for group in shares.values()]
            route = Recipients(
                tuple(Target.of(session, subscriptions) for session, subscriptions in matched.items()), tuple(groups)
            )
            if len(topic) <= _MAX_TOPIC_LENGTH:
                if self._cached >= _MAX_CACHED_TARGETS or len(self._cache) >= _MAX_CACHED_TOPICS:
                    self.forget_routes()
                self._cache[topic] = route
                self._cached += len(route.targets) + len(route.groups)
        return route

    def group(self, share: tuple[str, str]) -> ShareGroup | None:
        """Return the group with that name and filter, if it still has members."""
        return self._groups.get(share[1].split("/"), share[0])

    def forget_routes(self) -> None:
        """Clear the cache of sessions by topic."""
        if self._cache:
            self._cache = {}
            self._cached = 0
