"""Topic names and topic filters: validation and matching. Pure.

Pure functions. Source for all rules: MQTT 5.0 section 4.7 (names, filters, ``$`` topics) and section 4.8.2
(shared subscriptions); MQTT 3.1.1 section 4.7 says the same.
"""

import re
from functools import lru_cache
from typing import NamedTuple

from homebot.errors import InvalidNameError

MAX_TOPIC_BYTES = 65_535
"""Length limit of a topic name or filter in UTF-8, in bytes (MQTT 5.0, section 1.5.4)."""

_SHORT = MAX_TOPIC_BYTES // 4
_SHARE_PREFIX = "$share/"
_PLAIN_TEXT = re.compile(r"[ -\"%-*,-~]{1,1024}").fullmatch  # as nearly every topic is: no rule applies
_PLAIN_FILTER = re.compile(r"(?:(?:\+|[^/+#]*)/)*(?:\+|#|[^/+#]*)").fullmatch  # level by level takes far longer
_TOPIC = "topic"
_FILTER = "topic filter"

_KNOWN = 64
"""Size of the cache of valid topics, as each layer checks topics from outside. It is small, because each may have
65,535 bytes."""


class SharedFilter(NamedTuple):
    """The two parts of ``$share/GROUP/FILTER``.

    Attributes:
        group: Name of the group that shares the messages; without ``/``, ``+`` and ``#``.
    """

    group: str
    filter: str


@lru_cache(maxsize=_KNOWN)
def validate_topic(topic: str) -> None:
    """Check that *topic* is a valid topic name.

    Raises:
        InvalidNameError: The name is empty, longer than 65,535 bytes in UTF-8, or contains a wildcard, U+0000 or
            a surrogate.
    """
    if _PLAIN_TEXT(topic) is not None:
        return
    _check_text(_TOPIC, topic)
    if "+" in topic or "#" in topic:
        position = next(place for place, character in enumerate(topic) if character in "+#")
        raise InvalidNameError(_TOPIC, topic, "has a wildcard, which only filters may have", position)


@lru_cache(maxsize=_KNOWN)
def validate_filter(filter: str) -> None:  # noqa: A002 - the protocol's own word
    """Check that *filter* is a valid topic filter, ``$share/GROUP/FILTER`` included.

    Raises:
        InvalidNameError: The filter is empty, longer than 65,535 bytes in UTF-8, contains U+0000 or a surrogate,
            has a wildcard that is not a whole level, has ``#`` before the last level, or starts with
            ``$share/`` without a usable group and filter behind it.
    """
    if _PLAIN_TEXT(filter) is not None:
        return
    _check_text(_FILTER, filter)
    if filter.startswith(_SHARE_PREFIX):
        _check_levels(filter, parse_shared_filter(filter))
    else:
        _check_levels(filter, None)


def topic_matches(filter: str, topic: str) -> bool:  # noqa: A002 - the protocol's own word
    """Return whether a valid *filter* matches a valid *topic* name.

    A filter that starts with a wildcard does not match a topic that starts with ``$``. For a shared filter
    only the part after the group counts.
    """
    if filter.startswith(_SHARE_PREFIX):
        filter = filter.split("/", 2)[2]  # noqa: A001 - as above
    if topic.startswith("$") and filter[0] in "+#":
        return False
    wanted = filter.split("/")
    levels = topic.split("/")
    if wanted[-1] == "#":
        del wanted[-1]
        del levels[len(wanted) :]
    return len(wanted) == len(levels) and all(want in ("+", level) for want, level in zip(wanted, levels, strict=True))


def parse_shared_filter(filter: str) -> SharedFilter | None:  # noqa: A002 - the protocol's own word
    """Split ``$share/GROUP/FILTER``; None for a filter that is not shared.

    Raises:
        InvalidNameError: The group or the filter behind it is empty, or the group has a wildcard.
    """
    if not filter.startswith(_SHARE_PREFIX):
        return None
    _, group, *rest = filter.split("/", 2)
    if not group or not rest or not rest[0]:
        raise InvalidNameError(_FILTER, filter, "needs the form $share/GROUP/FILTER")
    if "+" in group or "#" in group:
        raise InvalidNameError(_FILTER, filter, "has a wildcard in its group", len(_SHARE_PREFIX))
    return SharedFilter(group, rest[0])


def _check_text(kind: str, name: str) -> None:
    if not name:
        raise InvalidNameError(kind, name, "is empty")
    if len(name) <= _SHORT and name.isascii() and "\0" not in name:
        return
    if "\0" in name:
        raise InvalidNameError(kind, name, "has a NUL", name.index("\0"))
    try:
        size = len(name.encode())
    except UnicodeEncodeError as error:
        raise InvalidNameError(kind, name, "cannot be encoded as UTF-8", error.start) from None
    if size > MAX_TOPIC_BYTES:
        raise InvalidNameError(kind, f"{name[:40]}…", f"is {size} bytes long; the limit is {MAX_TOPIC_BYTES}")


def _check_levels(whole: str, shared: SharedFilter | None) -> None:
    if _PLAIN_FILTER(whole if shared is None else shared.filter) is not None:
        return
    position = 0 if shared is None else len(whole) - len(shared.filter)
    levels = (whole if shared is None else shared.filter).split("/")
    for level in levels[:-1]:
        if "#" in level:
            raise InvalidNameError(_FILTER, whole, "has # before its end", position + level.index("#"))
        _check_plus(whole, level, position)
        position += len(level) + 1
    last = levels[-1]
    if "#" in last and last != "#":
        raise InvalidNameError(_FILTER, whole, "has # as part of a level", position + last.index("#"))
    _check_plus(whole, last, position)


def _check_plus(whole: str, level: str, position: int) -> None:
    if "+" in level and level != "+":
        raise InvalidNameError(_FILTER, whole, "has + as part of a level", position + level.index("+"))
