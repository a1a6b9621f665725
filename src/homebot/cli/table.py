"""Tables for people."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from homebot.support.printable import printable

__all__ = ["to_lines", "to_table", "without_empty"]

_WIDEST = 48
_WIDEST_ALONE = 200


def to_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return *rows* below *head* in columns, two spaces apart.

    Control characters are shown as escapes; a cell of more than 48 characters is cut.
    """
    shown = [[printable(cell, _WIDEST) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[column]) for row in shown) for column in range(len(head))]
    return "\n".join(_line(row, widths) for row in shown)


def without_empty(
    columns: Collection[str], head: Sequence[str], rows: Sequence[Sequence[str]]
) -> tuple[list[str], list[list[str]]]:
    """Return *head* and *rows* without those of the *columns* in which no row has anything."""
    kept = [place for place, name in enumerate(head) if name not in columns or any(row[place] for row in rows)]
    return [head[place] for place in kept], [[row[place] for place in kept] for row in rows]


def to_lines(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return *rows*, which may be of different lengths, in columns, two spaces apart.

    The last cell of a row makes no column wider. Control characters are shown as escapes; a cell of more than 200
    characters is cut.
    """
    shown = [[printable(cell, _WIDEST_ALONE) for cell in row] for row in rows]
    longest = max((len(row) for row in shown), default=0)
    widths = [max((len(row[column]) for row in shown if column < len(row) - 1), default=0) for column in range(longest)]
    return [_line(row, widths[: len(row)]) for row in shown]


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    return "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
