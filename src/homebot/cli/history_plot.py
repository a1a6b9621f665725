"""A plot of numbers over time in plain text. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime
from typing import Final

__all__ = ["plot_lines"]

_BLOCKS: Final = " ▁▂▃▄▅▆▇█"
_ROWS: Final = 8
_LABEL: Final = 9
_DAY: Final = 86_400


def plot_lines(
    times: Sequence[float], values: Sequence[float], since: float, until: float, width: int, height: int = _ROWS
) -> list[str]:
    """Return a plot of the mean *values* from *since* to *until*, in seconds since 1970; a pause is left blank.

    Args:
        width: Characters of a line.
        height: Lines of the plot, without the axis.
    """
    columns = max(width - _LABEL - 2, 10)
    sums: dict[int, list[float]] = {}
    for at, value in zip(times, values, strict=True):
        column = min(int((at - since) / (until - since) * columns), columns - 1)
        sums.setdefault(max(column, 0), []).append(value)
    means = {column: sum(found) / len(found) for column, found in sums.items()}
    low, high = min(means.values(), default=0.0), max(means.values(), default=0.0)
    return [*_rows(means, low, high, columns, height), _axis(since, until, columns)]


def _rows(means: dict[int, float], low: float, high: float, columns: int, height: int) -> Iterator[str]:
    steps = len(_BLOCKS) - 1
    reach = (high - low) or 1.0
    filled = {column: 1 + round((mean - low) / reach * (height * steps - 1)) for column, mean in means.items()}
    for row in range(height - 1, -1, -1):
        label = f"{high:.5g}" if row == height - 1 else f"{low:.5g}" if row == 0 else ""
        signs = (_BLOCKS[min(max(filled.get(column, 0) - row * steps, 0), steps)] for column in range(columns))
        yield f"{label:>{_LABEL}} │{''.join(signs)}".rstrip()


def _axis(since: float, until: float, columns: int) -> str:
    form = "%H:%M" if until - since < _DAY else "%d %b %H:%M" if until - since <= 30 * _DAY else "%d %b %Y"
    first, last = (datetime.fromtimestamp(one).astimezone().strftime(form) for one in (since, until))
    return f"{'':{_LABEL}} └{first}{'─' * max(columns - len(first) - len(last), 1)}{last}"
