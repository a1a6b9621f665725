"""The state topics in use, and the subscriptions that they require. Pure."""

from collections.abc import Callable, Iterable
from itertools import islice

from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.filter_tree import FilterIndex, has_wildcard
from homebot.mqtt.topics import validate_filter

MAX_TOPICS = 100_000
MAX_CHARACTERS = 1000
LITERAL_LEVELS = 2
"""Fewest literal levels of a filter that begins with a wildcard; Theengs Gateway: ``+/+/BTtoMQTT/A4C138000011``."""


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
        for announcement in (*self._announcements, *self._others):
            self._covering.add(announcement, announcement)
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
            if len(topic_filter) > MAX_CHARACTERS:
                raise WireError(
                    f"a state topic of {len(topic_filter)} characters is over the limit of {MAX_CHARACTERS}"
                )
            try:
                validate_filter(topic_filter)
            except InvalidNameError as exc:
                raise WireError(str(exc)) from None
            if topic_filter[0] in "+#$" and _asks_too_much(topic_filter):
                raise WireError(f"the state topic {topic_filter!r} does not belong to this device alone")
            if len(self.users) >= self._max_topics:
                raise WireError(f"state topic {topic_filter!r} exceeds the limit of {self._max_topics:,} state topics")
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


def prefix_of(filters: Iterable[str]) -> Callable[[str], str]:
    """Return a function from a topic to its group: the first level, if one of the *filters* begins with it."""
    levels = {
        level: f"{level}/#" for topic_filter in filters if (level := topic_filter.partition("/")[0]) not in {"+", "#"}
    }
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
    for topic_filter in taken:
        del filters[topic_filter]
    return taken
