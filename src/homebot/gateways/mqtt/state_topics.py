"""The topics of one gateway: those in use for states, with their subscriptions, and the reserved ones. Pure.

Reserved are the topics of brokers, bridges and homebot, which no announcement may use for commands; apps may still
publish there themselves.
"""

from collections.abc import Callable, Iterable, Mapping
from itertools import islice
from operator import attrgetter
from typing import NamedTuple

from homebot.conventions.convention import Convention, ReservingConvention, TextConvention
from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.filter_tree import FilterIndex, has_wildcard
from homebot.mqtt.topics import validate_filter

__all__ = ["ReservedTopics", "StateTopics", "pop_filters", "prefix_of"]

MAX_TOPICS = 100_000
LONGEST = 1000
LITERAL_LEVELS = 2
"""Fewest literal levels of a filter that begins with a wildcard; Theengs Gateway: ``+/+/BTtoMQTT/A4C138000011``."""

OWN = "homebot"
_BRIDGE_REQUEST = "/bridge/request/"


class StateTopics:
    """The number of users of each filter, for up to 100,000 filters.

    Args:
        announcements: Filters that are always subscribed to, at QoS 0.
        others: Filters that are always subscribed to, at a higher QoS.
        max_topics: Most filters in use.

    Attributes:
        users: The number of users of each filter.
        wanted: Filters to subscribe to, oldest first; removing one marks it as subscribed to. A filter of announcements
            may be among them, to receive its retained message again.
        unwanted: Filters to unsubscribe from; never one of announcements.
    """

    def __init__(self, announcements: Iterable[str], others: Iterable[str] = (), max_topics: int = MAX_TOPICS) -> None:
        self._announcements = frozenset(announcements)
        self._others = frozenset(others)
        self._covering: FilterIndex[str] = FilterIndex()
        for one in (*self._announcements, *self._others):
            self._covering.add(one, one)
        self._max_topics = max_topics
        self.users: dict[str, int] = {}
        self.wanted: dict[str, None] = {}
        self.unwanted: dict[str, None] = {}

    def use(self, topic_filter: str) -> None:
        """Add a user of *topic_filter*.

        Raises:
            WireError: It is invalid, longer than 1,000 characters, not specific to the device, or exceeds the limit.
        """
        users = self.users.get(topic_filter)
        if users is None:
            self._check(topic_filter)
            if topic_filter in self.unwanted:
                del self.unwanted[topic_filter]
            elif topic_filter not in self._others:
                self.wanted[topic_filter] = None
        self.users[topic_filter] = (users or 0) + 1

    def leave(self, topic_filter: str) -> None:
        """Remove a user of *topic_filter*, if it has one."""
        users = self.users.get(topic_filter)
        if users is None:
            return
        if users > 1:
            self.users[topic_filter] = users - 1
            return
        del self.users[topic_filter]
        if topic_filter in self.wanted:
            del self.wanted[topic_filter]
        elif topic_filter not in self._announcements and topic_filter not in self._others:
            self.unwanted[topic_filter] = None

    def is_covered(self, topic_filter: str) -> bool:
        """Return whether another filter covers it, so that subscribing only brings the retained message."""
        is_other = topic_filter not in self._announcements and self._covering.has_match(topic_filter)
        return is_other and not has_wildcard(topic_filter)

    def _check(self, topic_filter: str) -> None:
        if len(topic_filter) > LONGEST:
            raise WireError(f"a state topic of {len(topic_filter)} characters is over the limit of {LONGEST}")
        try:
            validate_filter(topic_filter)
        except InvalidNameError as exc:
            raise WireError(str(exc)) from None
        if topic_filter[0] in "+#$" and _asks_too_much(topic_filter):
            raise WireError(f"the state topic {topic_filter!r} does not belong to this device alone")
        if len(self.users) >= self._max_topics:
            raise WireError(f"state topic {topic_filter!r} exceeds the limit of {self._max_topics:,} state topics")


def prefix_of(filters: Iterable[str]) -> Callable[[str], str]:
    """Return a function from a topic to its group: the first level, if one of the *filters* begins with it."""
    levels = {level: f"{level}/#" for one in filters if (level := one.partition("/")[0]) not in {"+", "#"}}
    return lambda topic: levels.get(topic.partition("/")[0], "#")


def _asks_too_much(topic_filter: str) -> bool:
    if topic_filter.startswith("$share/"):
        return True
    if topic_filter[0] not in "+#":
        return False
    levels = topic_filter.split("/")
    return levels[-1] == "#" or len(levels) - levels.count("+") < LITERAL_LEVELS


def pop_filters(filters: dict[str, None], at_most: int) -> tuple[str, ...]:
    """Remove and return the oldest of *filters*."""
    taken = tuple(islice(filters, at_most))
    for one in taken:
        del filters[one]
    return taken


class _Reservation(NamedTuple):
    """The reason why topics are reserved, and the convention that may use them nevertheless."""

    why: str
    free_for: str = ""


class ReservedTopics:
    """Reserved topics of one gateway.

    Args:
        conventions: Conventions whose topics of announcements and texts are reserved.
    """

    def __init__(self, conventions: Iterable[Convention]) -> None:
        self._rules: FilterIndex[_Reservation | TextConvention] = FilterIndex()
        for one in conventions:
            if isinstance(one, TextConvention):
                for topic_filter in one.filters():
                    self._rules.add(topic_filter, one)
                continue
            narrow = _Reservation(f"it is reserved for announcements to {one.name}")
            wide = narrow._replace(free_for=one.name)
            for topic_filter in one.filters():
                self._rules.add(topic_filter, wide if "#" in topic_filter else narrow)
            if isinstance(one, ReservingConvention):
                for topic_filter in one.reserved():
                    self._rules.add(topic_filter, _Reservation(f"it belongs to {one.name}"))

    def why(self, topic: str, convention: str = "") -> str:
        """Return why no device of *convention* may have a command topic *topic*; empty if it may."""
        if topic.startswith("$"):
            return "it belongs to the broker"
        if topic == OWN or topic.startswith(f"{OWN}/"):
            return "it belongs to homebot"
        if _BRIDGE_REQUEST in topic:
            return "it is reserved for requests to a bridge"
        why = ""
        for rule in self._rules.match(topic):
            if not isinstance(rule, _Reservation):
                why = "another device publishes there" if _is_state_topic(rule, topic) else why
            elif not convention or rule.free_for != convention:
                return rule.why
        return why

    def without(self, described: DeviceAnnounced) -> tuple[DeviceAnnounced, tuple[str, ...]]:
        """Return *described* without its reserved command topics, and these topics with the reasons.

        The parts concerned stay readable.
        """
        reserved: dict[str, str] = {}
        for part in described.parts:
            for topic in (*part.part.writes, *map(_TOPIC, part.state_requests)):
                if why := self.why(topic, described.convention):
                    reserved[topic] = why
        if not reserved:
            return described, ()
        parts = tuple([_without(reserved, part) for part in described.parts])
        refused = dict.fromkeys(topic for part in described.parts for topic in part.part.writes if topic in reserved)
        return described._replace(parts=parts), tuple(f"{topic}: {reserved[topic]}" for topic in refused)


_TOPIC = attrgetter("topic")


def _without(reserved: Mapping[str, str], described: DescribedPart) -> DescribedPart:
    asks = tuple([one for one in described.state_requests if one.topic not in reserved])
    part = described.part
    if not reserved.keys().isdisjoint(part.writes):
        capabilities = tuple(one.model_copy(update={"settable": False}) for one in part.capabilities if one.readable)
        part = part.model_copy(update={"capabilities": capabilities, "writes": ()})
    return described._replace(part=part, state_requests=asks)


def _is_state_topic(convention: TextConvention, topic: str) -> bool:
    try:
        return convention.announced(topic) is not None
    except WireError:
        return False
