"""State topics that are needed, and the subscriptions that follow. Pure."""

from collections.abc import Callable, Iterable
from itertools import islice

from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.filter_tree import FilterIndex, has_wildcard
from homebot.mqtt.topics import validate_filter

__all__ = ["StateTopics", "pop_filters", "prefix_of"]

MAX_TOPICS = 100_000
LONGEST = 1000
LITERAL_LEVELS = 2
"""Levels without a wildcard in a filter that begins with one, as of Theengs Gateway: ``+/+/BTtoMQTT/A4C138000011``."""


class StateTopics:
    """Counts the users of each filter; 100,000 filters at most.

    Args:
        announcements: Filters that are subscribed to in any case, at QoS 0.
        others: Filters that are, at a higher one.
        max_topics: How many filters may be in use.

    Attributes:
        users: How often each filter is needed.
        wanted: Filters to subscribe to, in the order of their coming; one that is taken out counts as subscribed to.
            One of an announcement may be among them, for the kept message.
        unwanted: Filters to unsubscribe from; never one of an announcement.
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
        """Need *topic_filter* once more.

        Raises:
            WireError: It is no filter, longer than 1,000 characters, about other devices too, or one too many.
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
        """Drop one need of *topic_filter*; an unused one is passed over."""
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
        """Return whether all it matches comes by another filter; subscribing then brings the retained message alone."""
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
    """Return a function that names the group of a topic: its first level, where one of the *filters* begins with it."""
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
    """Remove the oldest of *filters*, and return them."""
    taken = tuple(islice(filters, at_most))
    for one in taken:
        del filters[one]
    return taken
