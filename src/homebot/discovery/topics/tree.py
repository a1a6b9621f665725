"""The tree of the topics that announcements name, and who names them. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from homebot.discovery.source_record import SourceKey
from homebot.discovery.topics.use import TopicUse

__all__ = ["TopicNode", "Uses", "all_uses", "has_use", "used_below", "with_use", "without_use"]

Uses: TypeAlias = TopicUse | dict[SourceKey, TopicUse]
"""Uses of a topic by announcements; most topics have one, which takes no dict."""


@dataclass(slots=True, eq=False)
class TopicNode:
    """One topic: what is below, which announcements take commands or publish states there, and whose own it is.

    Attributes:
        verdicts: Of those who may not use it: who has it.
    """

    parent: TopicNode | None = None
    level: str = ""
    children: dict[str, TopicNode] | None = None
    users: Uses | None = None
    speakers: Uses | None = None
    owners: Uses | None = None
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


def with_use(uses: Uses | None, use: TopicUse) -> Uses:
    """Return *uses* with *use*, in place of the one of the same announcement."""
    if isinstance(uses, dict):
        uses[use.key] = use
        return uses
    return use if uses is None or uses.key == use.key else {uses.key: uses, use.key: use}


def all_uses(uses: Uses | None) -> Collection[TopicUse]:
    """Return each of *uses*."""
    if uses is None:
        return ()
    return uses.values() if isinstance(uses, dict) else (uses,)


def has_use(uses: Uses | None, key: SourceKey) -> bool:
    """Return whether one of *uses* is that of the announcement *key*."""
    if uses is None:
        return False
    return key in uses if isinstance(uses, dict) else uses.key == key


def without_use(uses: Uses | None, key: SourceKey) -> Uses | None:
    """Return *uses* without the one of the announcement *key*."""
    if isinstance(uses, dict):
        uses.pop(key, None)
        return uses or None
    return None if has_use(uses, key) else uses


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
