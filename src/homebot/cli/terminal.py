"""Output of the commands: fitted to a terminal by rich, or stable plain text elsewhere.

rich is only loaded for a terminal: a piped command does not pay for it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final, TextIO

from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.cli.rich_terminal import RichTerminal

_INDENT: Final = "  "
_NARROW: Final = 10
_WIDEST: Final = 48
_WIDEST_ALONE: Final = 200


def is_terminal(stream: TextIO | None = None) -> bool:
    """Return whether *stream*, by default standard output, is a terminal."""
    return (stream or sys.stdout).isatty()


def print_table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    if_any: Sequence[str] = (),
    if_room: Sequence[str] = (),
    if_wide: Sequence[str] = (),
    in_colour: str = "",
    if_long: Sequence[str] = (),
    width: int = 0,
) -> None:
    """Print *rows* below *head*, in columns.

    On a terminal a long cell is wrapped, and no line is wider than the terminal.

    Args:
        if_any: Columns to leave out if they are empty in all rows.
        if_room: Columns to leave out, in this order, if the terminal is too narrow for all.
        if_wide: Columns to leave out next, if it is too narrow for columns of ten characters.
        in_colour: The column with the freshness and reachability of devices.
        if_long: Columns whose cells are cut without a terminal to fit the *width*, and at least ten characters.
        width: The most columns of characters without a terminal; 0 for any.
    """
    head, rows = without_empty(if_any, head, rows)
    if is_terminal():
        rich_terminal(sys.stdout).print_table(head, rows, if_room, if_wide, in_colour)
    else:
        print(to_table(head, rows, if_long, width))


def print_rows(rows: Sequence[Sequence[str]], title: str = "") -> None:
    """Print *rows*, which may be of different lengths, in columns below the *title*; nothing if there are none."""
    if not rows:
        return
    if is_terminal():
        rich_terminal(sys.stdout).print_rows(rows, title)
        return
    if title:
        print(*to_lines([(title,)]))
    print("\n".join(f"{_INDENT}{line}" for line in to_lines(rows)))


def print_line(text: str, style: str = "") -> None:
    """Print *text* unchanged, on a terminal in a rich *style*."""
    if style and is_terminal():
        rich_terminal(sys.stdout).print_line(text, style)
    else:
        print(text)


@contextmanager
def progress(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show the progress of a long command on standard error, if it is a terminal; yield the function that updates it.

    It disappears at the end, and with a *total* of 0 nothing is shown.
    """
    if total and is_terminal(sys.stderr):
        with rich_terminal(sys.stderr).progress(what, total) as update:
            yield update
    else:
        yield lambda done: None  # noqa: ARG005 - no terminal


def to_table(head: Sequence[str], rows: Sequence[Sequence[str]], if_long: Sequence[str] = (), width: int = 0) -> str:
    """Return *rows* below *head* in columns, two spaces apart; see :func:`print_table`.

    Control characters are shown as escapes; a cell of more than 48 characters is cut.
    """
    shown = [[printable(cell, _WIDEST) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[column]) for row in shown) for column in range(len(head))]
    excess = sum(widths) + 2 * (len(widths) - 1) - width
    for _ in range(excess if if_long else 0):
        longest = max((place for place, name in enumerate(head) if name in if_long), key=widths.__getitem__)
        widths[longest] = max(_NARROW, widths[longest] - 1)
    shown = [[printable(cell, most) for cell, most in zip(row, widths, strict=True)] for row in (head, *rows)]
    return "\n".join(_line(row, widths) for row in shown)


def without_empty(
    columns: Collection[str], head: Sequence[str], rows: Sequence[Sequence[str]]
) -> tuple[list[str], list[list[str]]]:
    """Return *head* and *rows* without those of the *columns* that are empty in all rows."""
    kept = [place for place, name in enumerate(head) if name not in columns or any(row[place] for row in rows)]
    return [head[place] for place in kept], [[row[place] for place in kept] for row in rows]


def to_lines(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return *rows*, which may be of different lengths, in columns, two spaces apart.

    The last cell of a row does not widen its column. Control characters are shown as escapes; a cell of more than 200
    characters is cut.
    """
    shown = [[printable(cell, _WIDEST_ALONE) for cell in row] for row in rows]
    longest = max((len(row) for row in shown), default=0)
    widths = [max((len(row[column]) for row in shown if column < len(row) - 1), default=0) for column in range(longest)]
    return [_line(row, widths[: len(row)]) for row in shown]


def rich_terminal(stream: TextIO) -> RichTerminal:
    """Return the rich terminal for *stream*."""
    from homebot.cli.rich_terminal import RichTerminal  # noqa: PLC0415 - for a terminal alone

    return RichTerminal(stream)


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    return "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
