"""Ownership of command topics: a topic that belongs to one device is not another one's to use. Pure.

Any client may announce anything, also a lamp with the command topic of a lock. So the first one never counts more:

- A topic below one that is a device's own, by its bridge, is that device's alone. Another
  announcement may name such a topic if it is about the same device and was made at a place that names it.
- Any other topic belongs to the device that was announced at the place that names it best; see
  :mod:`homebot.discovery.topics.use`. The same goes for topics that a device publishes on, and for those below its
  command topics.
- In a tie, the topic belongs to none, unless it is evidently there for several: they are behind one bridge, or
  do not identify themselves, and they are three or more, or their places have a name in common. Then it belongs to
  those of them that always ask, if there are any.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import final

from homebot.devices.part import Part
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.discovery.topics.tree import TopicNode, has_use, is_undisputed, used_below, verdicts_of, without_use
from homebot.discovery.topics.use import TopicUse

__all__ = ["MAX_BELOW", "MAX_LEVELS", "MAX_TOPICS", "MAX_USERS", "NOBODY", "TopicOwnership"]

MAX_TOPICS = 1000
"""Topics that one announcement is watched on; a further one that it names is not its to use."""

MAX_USERS = 256
"""Announcements that may name one topic; a further one may not use it."""

MAX_BELOW = 1000
"""Topics below a command topic that are looked at anew when that comes or goes."""

MAX_LEVELS = 20
"""Levels of a topic that are distinguished; the rest is one."""

NOBODY = "*"
"""Stands for the owner of a topic that too many want; no device is called so."""


_NO_DEVICES: frozenset[str] = frozenset()


@final
class TopicOwnership:
    """Ownership of command topics.

    Its answers follow from the announcements that are known, in any order of arrival.

    Attributes:
        denied: Announcements that name topics which others have, each with the number of those.
    """

    def __init__(self) -> None:
        self._roots: dict[str, TopicNode] = {}
        self._uses: dict[SourceKey, TopicUse] = {}
        self.denied: dict[SourceKey, int] = {}
        self._over_limit: set[SourceKey] = set()

    def put(self, use: TopicUse) -> frozenset[str]:
        """Update the topics of an announcement. Return the devices with changed ownership."""
        before = self._uses.get(use.key)
        if before == use:
            return frozenset()
        touched: dict[TopicNode, None] = {}
        if before is not None:
            self._leave(before, touched)
        if use.writes or use.reads or use.owns:
            self._uses[use.key] = use
            self._enter(use, touched)
        return self._judge(touched, use.device)

    def discard(self, key: SourceKey) -> frozenset[str]:
        """Forget an announcement; return the devices concerned."""
        use = self._uses.get(key)
        if use is None:
            return frozenset()
        touched: dict[TopicNode, None] = {}
        self._leave(use, touched)
        return self._judge(touched, use.device)

    def owner(self, key: SourceKey, topic: str) -> str:
        """Return the owner of *topic*, if that is not for the announcement *key* to use; else empty.

        It is the announcement's own device if another announcement of it has the topic, and :data:`NOBODY` if
        too many want it.
        """
        use = self._uses.get(key)
        if use is None:
            return NOBODY
        if key not in self.denied and key not in self._over_limit:
            return ""
        node = self._find(key[0], topic)
        if node is not None and has_use(node.users, key):
            return node.verdicts.get(key, "") if node.verdicts else ""
        return "" if use.has(topic) else NOBODY

    def repetitions(self, key: SourceKey) -> tuple[SourceKey, ...]:
        """Return the other announcements of the part that *key* announces; mostly there are none."""
        use = self._uses.get(key)
        if use is None or not use.commands:
            return ()
        node = self._find(key[0], use.writes[0])
        if node is None or len(node.users) == 1:
            return ()
        return tuple([one.key for one in node.users if one.key != key and use.repeats(one)])

    def conflict(self, source: SourceRecord, part: Part) -> str:
        """Return in words the other announcement that has a topic that *part* of *source* would use; empty for none."""
        key = source.key
        if key not in self.denied and key not in self._over_limit and key in self._uses:
            return ""
        for topic in part.writes:
            owner = self.owner(key, topic)
            if owner:
                return self._conflict_text(source, topic, owner)
        return ""

    def _conflict_text(self, source: SourceRecord, topic: str, owner: str) -> str:
        wants = f"{source.label} takes commands on {topic},"
        if owner == NOBODY:
            return f"{wants} which too many other devices use"
        if owner == self._uses[source.key].device:
            return f"{wants} where another announcement of the device takes different ones"
        return f"{wants} which belongs to {owner}"

    def _enter(self, use: TopicUse, touched: dict[TopicNode, None]) -> None:
        for prefix in dict.fromkeys(use.owns):
            node = self._at(use, prefix)
            node.owners = (*node.owners, use)
            touched.update(dict.fromkeys(used_below(node)))
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
            if node.children and use.rank(topic):
                touched.update(dict.fromkeys(used_below(node, MAX_BELOW)))

    def _leave(self, use: TopicUse, touched: dict[TopicNode, None]) -> None:
        del self._uses[use.key]
        self._over_limit.discard(use.key)
        for topic in dict.fromkeys((*use.owns, *use.writes, *use.reads)):
            node = self._find(use.key[0], topic)
            if node is None:
                continue
            is_owner = has_use(node.owners, use.key)
            is_user = has_use(node.users, use.key)
            node.owners = without_use(node.owners, use.key)
            node.users = without_use(node.users, use.key)
            node.speakers = without_use(node.speakers, use.key)
            touched[node] = None
            if node.children and (is_owner or (is_user and use.rank(topic))):
                touched.update(dict.fromkeys(used_below(node, None if is_owner else MAX_BELOW)))

    def _judge(self, touched: Iterable[TopicNode], device: str) -> frozenset[str]:
        """Decide again on the topics *touched*; return the devices but *device* for which that makes a difference."""
        concerned: set[str] = set()
        for node in touched:
            before, node.verdicts = node.verdicts, None if is_undisputed(node) else verdicts_of(node) or None
            if before or node.verdicts:
                known, now = before or {}, node.verdicts or {}
                self._count(known, now)
                concerned.update(use.device for use in node.users if known.get(use.key) != now.get(use.key))
            if not node.users and node.is_unused:
                self._tidy(node)
        concerned.discard(device)
        return frozenset(concerned) if concerned else _NO_DEVICES

    def _count(self, before: Mapping[SourceKey, str], now: Mapping[SourceKey, str]) -> None:
        for key in before.keys() - now.keys():
            left = self.denied.pop(key) - 1
            if left:
                self.denied[key] = left
        for key in now.keys() - before.keys():
            self.denied[key] = self.denied.get(key, 0) + 1

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
