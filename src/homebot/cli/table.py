"""Tables for people."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["to_table"]

_WIDEST = 48


def to_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return *rows* below *head* in columns, two spaces apart.

    Control characters are shown as escapes; a cell of more than 48 characters is cut.
    """
    shown = [[_printable(cell) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[column]) for row in shown) for column in range(len(head))]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in shown)
    return "\n".join(lines)


def _printable(text: str) -> str:
    signs = text[: _WIDEST + 1]
    shown = "".join(sign if sign.isprintable() else sign.encode("unicode_escape").decode() for sign in signs)
    return shown if len(shown) <= _WIDEST else f"{shown[: _WIDEST - 1]}…"
