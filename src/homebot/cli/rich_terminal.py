"""Output fitted to a terminal by rich. External text is never interpreted as markup."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import groupby
from typing import TYPE_CHECKING, Final, TextIO, final

from rich.console import Console, Group
from rich.live import Live
from rich.padding import Padding
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from homebot.support.output import CleanText

if TYPE_CHECKING:
    from homebot.cli.house_picture import Line
from homebot.support.printable import printable

_GAP: Final = 2
_NARROW: Final = 10
_OTHER_LINES: Final = 4
_STYLES: Final = (
    ("unreachable", "red"),
    ("stale", "yellow"),
    ("expired", "yellow"),
    ("unconfirmed", "dim"),
    ("fresh", "green"),
)
"""The style of a device's availability, by the first of these words in it."""


@final
class RichTerminal:
    """A terminal; see :mod:`homebot.cli.terminal` for its methods."""

    def __init__(self, stream: TextIO) -> None:
        while isinstance(stream, CleanText):  # the filter would show rich's escapes as text
            stream = stream.raw
        self._console = Console(file=stream, highlight=False, markup=False, emoji=False)

    def print_table(
        self,
        head: Sequence[str],
        rows: Sequence[Sequence[str]],
        if_room: Sequence[str],
        if_wide: Sequence[str],
        in_colour: str,
    ) -> None:
        """Print *rows* below *head*, leaving out columns *if_room* until the rest fits.

        If even narrow columns do not fit, columns *if_wide* are left out too.
        """
        shown = [
            [_text(cell, _style(cell) if name == in_colour else "") for name, cell in zip(head, row, strict=True)]
            for row in rows
        ]
        kept = self._fit_columns(head, _widths(head, shown), if_room, if_wide)
        table = Table(box=None, pad_edge=False, padding=(0, _GAP, 0, 0), header_style="bold")
        for place in kept:
            table.add_column(head[place], overflow="fold")
        for row in shown:
            table.add_row(*(row[place] for place in kept))
        self._console.print(table)
        left_out = [name for place, name in enumerate(head) if place not in kept]
        if left_out:
            hidden = f"columns hidden, as the terminal is too narrow: {', '.join(left_out)}"
            self._console.print(_text(hidden, "dim"))

    def _fit_columns(
        self, head: Sequence[str], widths: Mapping[int, int], if_room: Sequence[str], if_wide: Sequence[str]
    ) -> list[int]:
        """Return the places of the columns that are shown."""
        kept = _fitting(head, widths, if_room, self._console.width)
        if not set(if_room).isdisjoint(head[place] for place in kept):
            return kept
        narrow = {place: min(widths[place], _NARROW) for place in kept}
        return _fitting(head, narrow, if_wide, self._console.width)

    def print_rows(self, rows: Sequence[Sequence[str]], title: str) -> None:
        """Print *rows*, which may be of different lengths, in columns below the *title*."""
        if title:
            self._console.print(_text(title, "bold"))
        shown = [[_text(cell) for cell in row] for row in rows]
        first = max((row[0].cell_len for row in shown if len(row) > 1), default=0)
        for length, some in groupby(shown, len):
            grid = Table.grid(padding=(0, _GAP, 0, 0))
            for _ in range(length):
                grid.add_column(overflow="fold")
            for row in some:
                row[0].pad_right(max(0, first - row[0].cell_len))  # aligns rows of different lengths
                grid.add_row(*row)
            self._console.print(Padding(grid, (0, 0, 0, _GAP), expand=False))

    def print_line(self, text: str, style: str) -> None:
        """Print *text* in a rich *style*."""
        self._console.print(_text(text, style), soft_wrap=True)

    def show_live(
        self, head: Sequence[str], frames: Iterable[tuple[str, Sequence[Sequence[str]]]], if_wide: Sequence[str]
    ) -> None:
        """Show each of *frames*, with as many rows as fit, without a rich thread.

        If the terminal is too narrow, the first and last columns are cut; then columns *if_wide* are left out.
        """
        with Live(console=self._console, auto_refresh=False, screen=True, vertical_overflow="crop") as live:
            for title, rows in frames:
                table = Table(box=None, pad_edge=False, expand=True, title_justify="left", title=_text(title))
                shown = [[*map(_text, row)] for row in rows[: max(1, self._console.height - _OTHER_LINES)]]
                widths = _widths(head, shown) | {0: _NARROW, len(head) - 1: _NARROW}
                kept = _fitting(head, widths, if_wide, self._console.width)
                spare = max(0, self._console.width - sum(widths[place] + _GAP for place in kept) + _GAP)
                last = min(_NARROW, spare // 3)
                widths |= {0: widths[0] + spare - last, len(head) - 1: _NARROW + last}
                for place in kept:
                    table.add_column(head[place], no_wrap=True, overflow="ellipsis", width=widths[place])
                for row in shown:
                    table.add_row(*(row[place] for place in kept))
                live.update(table, refresh=True)

    @contextmanager
    def screen(self) -> Iterator[Callable[[Callable[[int, int], Sequence[Line]]], None]]:
        """Show a full screen during the block; yield a function that draws the lines for its width and height."""
        with Live(console=self._console, auto_refresh=False, screen=True, vertical_overflow="crop") as live:

            def draw(lines_for: Callable[[int, int], Sequence[Line]]) -> None:
                lines = [
                    Text.assemble(*line, no_wrap=True, overflow="ellipsis") for line in lines_for(*self._console.size)
                ]
                live.update(Group(*lines), refresh=True)

            yield draw

    @contextmanager
    def progress(self, what: str, total: int) -> Iterator[Callable[[int], None]]:
        """Show the progress of a long command; yield the function that updates it."""
        with Progress(console=self._console, transient=True, auto_refresh=False) as bar:
            task = bar.add_task(printable(what), total=total)
            yield lambda done: bar.update(task, completed=done, refresh=True)


def _text(cell: str, style: str = "") -> Text:
    return Text(printable(cell), style)


def _style(cell: str) -> str:
    return next((style for text, style in _STYLES if text in cell), "")


def _widths(head: Sequence[str], rows: Sequence[Sequence[Text]]) -> dict[int, int]:
    return {place: max(len(name), *(row[place].cell_len for row in rows), 0) for place, name in enumerate(head)}


def _fitting(head: Sequence[str], widths: Mapping[int, int], if_room: Sequence[str], width: int) -> list[int]:
    """Return the indices in *widths* that are shown, leaving out columns *if_room* until the rest fits."""
    kept = [*widths]
    for name in if_room:
        if sum(widths[place] + _GAP for place in kept) - _GAP <= width:
            break
        kept = [place for place in kept if head[place] != name]
    return kept
