"""Patterns of names on the graph, such as ``/rosie/**``: ``*`` is within a part, ``**`` any number of parts. Pure."""

import re
from collections.abc import Iterable
from functools import lru_cache


def fits_any(name: str, patterns: Iterable[str]) -> bool:
    """Return whether the full name *name*, or that of the action of which it is a part, fits one of *patterns*."""
    name = name.partition("/_action/")[0]
    return any(_compile(pattern).fullmatch(name) for pattern in patterns)


@lru_cache(maxsize=256)
def _compile(pattern: str) -> re.Pattern[str]:
    parts = (".*" if part == "**" else part.replace("*", "[^/]*") for part in pattern.split("/"))
    return re.compile("/".join(parts))
