"""Which of many topic filters match a topic. Pure."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

__all__ = ["ReaderTree", "has_wildcard"]

T = TypeVar("T")


def has_wildcard(topic_filter: str) -> bool:
    """Whether a valid filter may match more than one topic."""
    return "+" in topic_filter or "#" in topic_filter


@dataclass(slots=True)
class _ReaderNode(Generic[T]):
    children: dict[str, _ReaderNode[T]] = field(default_factory=dict)
    items: dict[T, None] = field(default_factory=dict)


class ReaderTree(Generic[T]):
    """Items by valid topic filters; a topic finds them in the order of adding, those of exact filters first.

    Source: MQTT Version 5.0, section 4.7.
    """

    def __init__(self) -> None:
        self._exact: dict[str, dict[T, None]] = {}
        self._root: _ReaderNode[T] = _ReaderNode()

    def add(self, topic_filter: str, item: T) -> None:
        """Have *item* found by every topic that *topic_filter* matches; twice is once."""
        if not has_wildcard(topic_filter):
            self._exact.setdefault(topic_filter, {})[item] = None
            return
        node = self._root
        for level in topic_filter.split("/"):
            node = node.children.setdefault(level, _ReaderNode())
        node.items[item] = None

    def remove(self, topic_filter: str, item: T) -> None:
        """Take back what was added; what was not is passed over."""
        if not has_wildcard(topic_filter):
            items = self._exact.get(topic_filter, {})
            items.pop(item, None)
            if not items:
                self._exact.pop(topic_filter, None)
            return
        path = [self._root]
        levels = topic_filter.split("/")
        for level in levels:
            if level not in path[-1].children:
                return
            path.append(path[-1].children[level])
        path[-1].items.pop(item, None)
        for level, parent in zip(reversed(levels), reversed(path[:-1]), strict=True):
            child = parent.children[level]
            if child.items or child.children:
                break
            del parent.children[level]

    def match(self, topic: str) -> tuple[T, ...]:
        """Return the items of every filter that matches *topic*, each once."""
        found = dict(self._exact.get(topic, ()))
        levels = topic.split("/")
        if self._root.children.keys().isdisjoint(("#", "+", levels[0])):
            return tuple(found)
        nodes, is_wild = [self._root], not topic.startswith("$")
        for level in levels:
            below: list[_ReaderNode[T]] = []
            for node in nodes:
                children = node.children
                if is_wild:
                    if "#" in children:
                        found.update(children["#"].items)
                    if "+" in children:
                        below.append(children["+"])
                if level in children:
                    below.append(children[level])
            if not below:
                return tuple(found)
            nodes, is_wild = below, True
        for node in nodes:
            found.update(node.items)
            if "#" in node.children:
                found.update(node.children["#"].items)
        return tuple(found)
