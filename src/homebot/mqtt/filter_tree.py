"""Values by topic filters: a tree of their levels. No I/O."""

from collections.abc import Sequence
from typing import Generic, TypeVar, final

Key = TypeVar("Key")
Value = TypeVar("Value")


class _FilterNode(Generic[Key, Value]):
    __slots__ = ("children", "values")

    def __init__(self) -> None:
        self.children: dict[str, _FilterNode[Key, Value]] | None = None
        self.values: dict[Key, Value] | None = None


@final
class FilterTree(Generic[Key, Value]):
    """Any number of keyed values for each filter.

    Attributes:
        nodes: Levels of all filters; common first levels count once.
    """

    def __init__(self) -> None:
        self._root: _FilterNode[Key, Value] = _FilterNode()
        self.nodes = 0

    def add(self, levels: Sequence[str], key: Key, value: Value) -> bool:
        """Replace the value of the filter under *key* by *value*; return whether it is new."""
        node = self._root
        for level in levels:
            if node.children is None:
                node.children = {}
            child = node.children.get(level)
            if child is None:
                child = node.children[level] = _FilterNode()
                self.nodes += 1
            node = child
        if node.values is None:
            node.values = {}
        is_new = key not in node.values
        node.values[key] = value
        return is_new

    def get(self, levels: Sequence[str], key: Key) -> Value | None:
        """Return the value of the filter under *key*."""
        node = self._root
        for level in levels:
            child = None if node.children is None else node.children.get(level)
            if child is None:
                return None
            node = child
        return None if node.values is None else node.values.get(key)

    def remove(self, levels: Sequence[str], key: Key) -> None:
        """Remove a value if it was added."""
        path = [self._root]
        for level in levels:
            child = (path[-1].children or {}).get(level)
            if child is None:
                return
            path.append(child)
        values = path[-1].values
        if values is None or key not in values:
            return
        del values[key]
        if not values:
            path[-1].values = None
        # empty nodes at the end of the path go
        for place in range(len(levels) - 1, -1, -1):
            child, parent = path[place + 1], path[place]
            if child.children or child.values or parent.children is None:
                break
            del parent.children[levels[place]]
            self.nodes -= 1
            if not parent.children:
                parent.children = None

    def matching(self, topic: Sequence[str]) -> list[dict[Key, Value]]:
        """Return the values of all filters that match the topic."""
        matches: list[dict[Key, Value]] = []
        nodes = [self._root]
        wild = not topic[0].startswith("$")
        for level in topic:
            following: list[_FilterNode[Key, Value]] = []
            for node in nodes:
                children = node.children
                if children is None:
                    continue
                if level in children:
                    following.append(children[level])
                if wild:
                    if "+" in children:
                        following.append(children["+"])
                    if "#" in children and (values := children["#"].values) is not None:
                        matches.append(values)
            nodes = following
            if not nodes:
                return matches
            wild = True
        for node in nodes:
            if node.values is not None:
                matches.append(node.values)
            if node.children is not None and "#" in node.children and (values := node.children["#"].values) is not None:
                matches.append(values)
        return matches


def has_wildcard(topic_filter: str) -> bool:
    """Return whether a valid filter may match more than one topic."""
    return "+" in topic_filter or "#" in topic_filter


@final
class FilterIndex(Generic[Key]):
    """Items by valid topic filters; a topic finds each of its items once, those of exact filters first.

    Source: MQTT Version 5.0, section 4.7.
    """

    def __init__(self) -> None:
        self._exact: dict[str, Key] = {}  # most topics have a single item
        self._shared: dict[str, dict[Key, None]] = {}  # topics with more items
        self._wild: FilterTree[Key, None] = FilterTree()

    def add(self, topic_filter: str, item: Key) -> None:
        """Add *item* for every topic that *topic_filter* matches. Idempotent."""
        if "+" in topic_filter or "#" in topic_filter:
            self._wild.add(topic_filter.split("/"), item, None)
        elif topic_filter in self._shared:
            self._shared[topic_filter][item] = None
        elif (known := self._exact.setdefault(topic_filter, item)) != item:
            self._shared[topic_filter] = {known: None, item: None}
            del self._exact[topic_filter]

    def remove(self, topic_filter: str, item: Key) -> None:
        """Remove an item, if it was added."""
        if has_wildcard(topic_filter):
            self._wild.remove(topic_filter.split("/"), item)
        elif items := self._shared.get(topic_filter):
            items.pop(item, None)
            if len(items) == 1:
                (self._exact[topic_filter],) = self._shared.pop(topic_filter)
        elif topic_filter in self._exact and self._exact[topic_filter] == item:
            del self._exact[topic_filter]

    def has_match(self, topic: str) -> bool:
        """Return whether *topic* finds any item."""
        if topic in self._exact or topic in self._shared:
            return True
        return self._wild.nodes > 0 and bool(self._wild.matching(topic.split("/")))

    def match(self, topic: str) -> tuple[Key, ...]:
        """Return the items of every filter that matches *topic*, each once."""
        exact = (self._exact[topic],) if topic in self._exact else self._shared.get(topic, ())
        wild = self._wild.matching(topic.split("/")) if self._wild.nodes else ()
        if not wild:
            return tuple(exact)
        if not exact and len(wild) == 1:
            return tuple(wild[0])
        keys = dict.fromkeys(exact)
        for items in wild:
            keys.update(items)
        return tuple(keys)
