"""Output of the commands: fitted to the terminal by rich if there is one, plain text elsewhere, always the same.

rich is loaded for a terminal alone: it costs a command that is piped nothing. No text from outside is read as markup.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import groupby
from typing import TYPE_CHECKING, Final, TextIO

from homebot.cli.table import printable, to_lines, to_table, without_empty
from homebot.support.output import CleanText

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

__all__ = ["is_terminal", "print_line", "print_rows", "print_table", "progress"]

_GAP: Final = 2
_STYLES: Final = (
    ("unreachable", "red"),
    ("stale", "yellow"),
    ("expired", "yellow"),
    ("unconfirmed", "dim"),
    ("fresh", "green"),
)
"""How a device's availability is shown, by the first of these words that is in it."""


def is_terminal(stream: TextIO | None = None) -> bool:
    """Return whether *stream*, by default standard output, is a terminal."""
    return (stream or sys.stdout).isatty()


def print_table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    if_any: Sequence[str] = (),
    if_room: Sequence[str] = (),
    in_colour: str = "",
) -> None:
    """Print *rows* below *head*, in columns.

    On a terminal a long cell goes on in the line below, and no line is wider than the terminal.

    Args:
        head: The titles of the columns.
        rows: As many cells each.
        if_any: Columns to leave out where no row has anything in them.
        if_room: Columns that a terminal goes without where it is too narrow for all; the first goes first.
        in_colour: The column that says how fresh devices are and whether they can be reached.
    """
    head, rows = without_empty(if_any, head, rows)
    if not is_terminal():
        print(to_table(head, rows))
        return
    from rich.table import Table  # noqa: PLC0415 - for a terminal alone

    console = _console(sys.stdout)
    shown = [
        [_text(cell, _style(cell) if name == in_colour else "") for name, cell in zip(head, row, strict=True)]
        for row in rows
    ]
    kept = _fitting(head, shown, if_room, console.width)
    table = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0), header_style="bold")
    for place in kept:
        table.add_column(head[place], overflow="fold")
    for row in shown:
        table.add_row(*(row[place] for place in kept))
    console.print(table)
    left_out = [name for place, name in enumerate(head) if place not in kept]
    if left_out:
        console.print(_text(f"columns hidden, as the terminal is too narrow: {', '.join(left_out)}", "dim"))


def print_rows(rows: Sequence[Sequence[str]], title: str = "") -> None:
    """Print *rows*, which may be of different lengths, in columns below the *title*; nothing if there are none."""
    if not rows:
        return
    if not is_terminal():
        if title:
            print(*to_lines([(title,)]))
        print("\n".join(f"{' ' * _GAP}{line}" for line in to_lines(rows)))
        return
    from rich.padding import Padding  # noqa: PLC0415 - as above
    from rich.table import Table  # noqa: PLC0415 - as above

    console = _console(sys.stdout)
    if title:
        console.print(_text(title, "bold"))
    shown = [[_text(cell) for cell in row] for row in rows]
    first = max((row[0].cell_len for row in shown if len(row) > 1), default=0)
    for length, some in groupby(shown, len):
        grid = Table.grid(padding=(0, _GAP, 0, 0))
        for _ in range(length):
            grid.add_column(overflow="fold")
        for row in some:
            row[0].pad_right(max(0, first - row[0].cell_len))  # so that columns go on below rows of another length
            grid.add_row(*row)
        console.print(Padding(grid, (0, 0, 0, _GAP), expand=False))


def print_line(text: str, style: str = "") -> None:
    """Print *text* as it is, on a terminal in a *style* of rich's."""
    if not style or not is_terminal():
        print(text)
        return
    _console(sys.stdout).print(_text(text, style), soft_wrap=True)


@contextmanager
def progress(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show on standard error how far a long command is, if that is a terminal; give the function that updates it.

    Nothing of it is left at the end, and with a *total* of 0 there is nothing to show.
    """
    if not total or not is_terminal(sys.stderr):
        yield lambda done: None  # noqa: ARG005 - no terminal
        return
    from rich.progress import Progress  # noqa: PLC0415 - as above

    with Progress(console=_console(sys.stderr), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(printable(what), total=total)
        yield lambda done: bar.update(task, completed=done, refresh=True)


def _console(stream: TextIO) -> Console:
    """Return rich's way to *stream*, behind the filter that would show its own escapes as text."""
    from rich.console import Console  # noqa: PLC0415 - as above

    while isinstance(stream, CleanText):
        stream = stream.raw
    return Console(file=stream, highlight=False, markup=False, emoji=False)


def _text(cell: str, style: str = "") -> Text:
    from rich.text import Text  # noqa: PLC0415 - as above

    return Text(printable(cell), style)


def _style(cell: str) -> str:
    return next((style for text, style in _STYLES if text in cell), "")


def _fitting(head: Sequence[str], rows: Sequence[Sequence[Text]], if_room: Sequence[str], width: int) -> list[int]:
    """Return the places of the columns that are shown: all but as many of *if_room* as make the rest fit."""
    kept = list(range(len(head)))
    widths = [max(len(head[place]), *(row[place].cell_len for row in rows), 0) for place in kept]
    for name in if_room:
        if sum(widths[place] + _GAP for place in kept) - _GAP <= width:
            break
        kept = [place for place in kept if head[place] != name]
    return kept
