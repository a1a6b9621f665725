"""Busy topics that nothing here reads: programs that publish there do not announce themselves."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Final

_BUSY, _MAX_SHOWN = 3, 5
_OWN: Final = "homebot"


def unread_notes(
    counts: Mapping[str, int],
    is_read: Callable[[str], object],
    used: Iterable[str],
    announced: Iterable[str],
    hints: Iterable[Callable[[str], str]] = (),
) -> Iterator[str]:
    """Yield a note on the busiest topics of *counts* that nothing reads, by their first levels, after the hints.

    Args:
        is_read: Returns whether a topic is read.
        used: All topics and filters that are read or commanded.
        announced: The filters of announcements.
        hints: Each returns the setting that would read a topic; empty if it does not know.
    """
    programs = {_OWN, *(topic_filter.partition("/")[0] for topic_filter in announced)}
    levels = {level for topic in used for level in _levels(topic)}
    groups: Counter[str] = Counter()
    unread = {topic: count for topic, count in counts.items() if not is_read(topic)}
    hinted = {topic: text for hint in hints for topic in unread if (text := hint(topic))}
    yield from islice(dict.fromkeys(hinted.values()), _MAX_SHOWN)
    for topic, count in unread.items():
        first, second = _levels(topic)
        if first not in programs and second not in levels and topic not in hinted:
            groups[second if first in levels else first] += count  # of two levels if others are used below the first
    busy = [(group, count) for group, count in groups.most_common() if count >= _BUSY]
    if busy:
        shown = ", ".join(f"{group[:100]} ({count})" for group, count in busy[:_MAX_SHOWN])
        more = f" and {len(busy) - _MAX_SHOWN} more" if len(busy) > _MAX_SHOWN else ""
        yield (
            f"nothing here reads the topics that begin with {shown}{more}, counted for a minute: programs publish "
            "there that announce no devices, or under a prefix that is not configured (docs/conventions.md)"
        )


def _levels(topic: str) -> tuple[str, str]:
    """Return the first level of *topic*, and the first two."""
    levels = topic.split("/", 2)
    return levels[0], "/".join(levels[:2])
