"""Topics without commands to devices, in any announcement: those of brokers, bridges and homebot. Pure.

An app may publish there by itself, if it has reason to; a command to a device never ends there.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from operator import is_
from typing import NamedTuple

from homebot.conventions.convention import Convention, ReservingConvention, TextConvention
from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.devices.part import Part
from homebot.errors import WireError
from homebot.mqtt.filter_tree import FilterIndex

__all__ = ["ReservedTopics"]

OWN = "homebot"
_BRIDGE_REQUEST = "/bridge/request/"


class _Rule(NamedTuple):
    """The reason why topics are reserved, and the convention that may use them all the same: all below its prefix."""

    why: str
    free_for: str = ""


class ReservedTopics:
    """Reserved topics of one gateway.

    Args:
        conventions: Its conventions: no device takes commands where devices announce themselves or publish text.
    """

    def __init__(self, conventions: Iterable[Convention]) -> None:
        self._rules: FilterIndex[_Rule | TextConvention] = FilterIndex()
        for one in conventions:
            if isinstance(one, TextConvention):
                for topic_filter in one.filters():
                    self._rules.add(topic_filter, one)
                continue
            narrow = _Rule(f"it is reserved for announcements to {one.name}")
            wide = narrow._replace(free_for=one.name)
            for topic_filter in one.filters():
                self._rules.add(topic_filter, wide if "#" in topic_filter else narrow)
            if isinstance(one, ReservingConvention):
                for topic_filter in one.reserved():
                    self._rules.add(topic_filter, _Rule(f"it belongs to {one.name}"))

    def why(self, topic: str, convention: str = "") -> str:
        """Return why no device of *convention* may take commands on *topic*; empty if that is not reserved."""
        if topic.startswith("$"):
            return "it belongs to the broker"
        if topic == OWN or topic.startswith(f"{OWN}/"):
            return "it belongs to homebot"
        if _BRIDGE_REQUEST in topic:
            return "it is reserved for requests to a bridge"
        why = ""
        for rule in self._rules.match(topic):
            if not isinstance(rule, _Rule):
                why = "another device publishes there" if _is_state_topic(rule, topic) else why
            elif not convention or rule.free_for != convention:
                return rule.why
        return why

    def without(self, described: DeviceAnnounced) -> tuple[DeviceAnnounced, tuple[str, ...]]:
        """Return *described* without commands on reserved topics, and these topics with the reasons.

        Such a part stays, and can be read; it cannot be told anything.
        """
        refused: dict[str, str] = {}
        parts = tuple([self._part(described.convention, part, refused) for part in described.parts])
        if all(map(is_, parts, described.parts)):
            return described, ()
        return replace(described, parts=parts), tuple(f"{topic}: {why}" for topic, why in refused.items())

    def _part(self, convention: str, described: DescribedPart, refused: dict[str, str]) -> DescribedPart:
        found = {one: why for one in described.part.writes if (why := self.why(one, convention))}
        asks = tuple([one for one in described.state_requests if not self.why(one.topic, convention)])
        if found:
            refused.update(found)
            return replace(described, part=_only_read(described.part), state_requests=asks)
        return described if len(asks) == len(described.state_requests) else replace(described, state_requests=asks)


def _only_read(part: Part) -> Part:
    capabilities = tuple(one.model_copy(update={"settable": False}) for one in part.capabilities if one.readable)
    return part.model_copy(update={"capabilities": capabilities, "writes": ()})


def _is_state_topic(convention: TextConvention, topic: str) -> bool:
    try:
        return convention.announced(topic) is not None
    except WireError:
        return False
