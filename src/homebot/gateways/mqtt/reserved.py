"""Topics that no announcement may use for commands: those of brokers, bridges and homebot. Pure.

Apps may still publish there themselves. From some of them nobody may read, as codes are there.
"""

from collections.abc import Iterable, Mapping
from functools import lru_cache
from operator import attrgetter
from typing import NamedTuple

from homebot.conventions.convention import (
    ConfidentialConvention,
    Convention,
    ReservingConvention,
    TextConvention,
)
from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.errors import WireError
from homebot.mqtt.filter_tree import FilterIndex

_BRIDGE_REQUEST = "/bridge/request/"
_MAX_CACHED = 5000
"""State topics: all announcements of a device have one, but do not come one after the other."""


class _Reservation(NamedTuple):
    """The reason why topics are reserved, and the convention that may use them."""

    why: str
    free_for: str = ""


class ReservedTopics:
    """Reserved topics of one gateway.

    Args:
        conventions: Conventions with reserved topics of announcements and texts.
        own_commands: The filters of commands to homebot's own devices.

    Attributes:
        is_secret: Returns whether nobody may read a topic, as there may be codes.
    """

    def __init__(self, conventions: Iterable[Convention], own_commands: Iterable[str] = ()) -> None:
        self._rules: FilterIndex[_Reservation | TextConvention] = FilterIndex()
        self._secrets: FilterIndex[str] = FilterIndex()
        self.is_secret = lru_cache(_MAX_CACHED)(self._is_secret)
        self._rules.add("homebot/#", _Reservation("it belongs to homebot"))
        for topic_filter in own_commands:
            self._rules.add(topic_filter, _Reservation("it belongs to homebot"))
            self._secrets.add(topic_filter, topic_filter)
        for convention in conventions:
            if isinstance(convention, TextConvention):
                for topic_filter in convention.filters():
                    self._rules.add(topic_filter, convention)
                continue
            narrow = _Reservation(f"it is reserved for announcements to {convention.name}")
            wide = narrow._replace(free_for=convention.name)
            for topic_filter in convention.filters():
                self._rules.add(topic_filter, wide if "#" in topic_filter else narrow)
                if isinstance(convention, ConfidentialConvention):
                    self._secrets.add(topic_filter, topic_filter)
            if isinstance(convention, ReservingConvention):
                for topic_filter in convention.reserved():
                    self._rules.add(topic_filter, _Reservation(f"it belongs to {convention.name}"))

    def why(self, topic: str, convention: str = "") -> str:
        """Return why no device of *convention* may have a command topic *topic*; empty if it may."""
        if topic.startswith("$"):
            return "it belongs to the broker"
        why = ""
        for rule in self._rules.match(topic):
            if not isinstance(rule, _Reservation):
                why = "another device publishes there" if _is_state_topic(rule, topic) else why
            elif not convention or rule.free_for != convention:
                return rule.why
        return why

    def _is_secret(self, topic: str) -> bool:
        return _BRIDGE_REQUEST in topic or self._secrets.has_match(topic)

    def without(self, described: DeviceAnnounced) -> tuple[DeviceAnnounced, tuple[str, ...]]:
        """Return *described* without its reserved command topics, and these topics with the reasons.

        The parts concerned stay readable.
        """
        reserved: dict[str, str] = {}
        for part in described.parts:
            for topic in (*part.part.writes, *map(attrgetter("topic"), part.state_requests)):
                if why := self.why(topic, described.convention):
                    reserved[topic] = why
        if not reserved:
            return described, ()
        parts = tuple([_without(reserved, part) for part in described.parts])
        refused = dict.fromkeys(topic for part in described.parts for topic in part.part.writes if topic in reserved)
        return described._replace(parts=parts), tuple(f"{topic}: {reserved[topic]}" for topic in refused)


def _without(reserved: Mapping[str, str], described: DescribedPart) -> DescribedPart:
    asks = tuple([request for request in described.state_requests if request.topic not in reserved])
    part = described.part
    if not reserved.keys().isdisjoint(part.writes):
        capabilities = tuple(
            capability.model_copy(update={"settable": False}) for capability in part.capabilities if capability.readable
        )
        part = part.model_copy(update={"capabilities": capabilities, "writes": ()})
    return described._replace(part=part, state_requests=asks)


def _is_state_topic(convention: TextConvention, topic: str) -> bool:
    try:
        return convention.announced(topic) is not None
    except WireError:
        return False
