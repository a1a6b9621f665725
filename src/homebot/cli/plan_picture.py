"""The plan of a house as lines for a terminal: rooms, doors, light, and the beings in each room. Pure."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from itertools import groupby
from typing import Final, NamedTuple, TypeAlias

from homebot.support.printable import printable

__all__ = ["LEAST_LINES", "Line", "PlanPicture"]

_Segment: TypeAlias = tuple[str, str]
"""Text, and its style of rich's."""

Line: TypeAlias = Sequence[_Segment]
"""One line, in its parts."""

LEAST_LINES: Final = 5
_MOST_LINES: Final = 9
_ASPECT: Final = 2.0
"""The height of a character, in its widths."""

_LEFT, _RIGHT, _UP, _DOWN = 1, 2, 4, 8
_WALLS: Final = " ╴╶─╵┘└┴╷┐┌┬│┤├┼"
"""The character for each sum of the directions in which a wall goes on."""

_LIT, _DARK = "yellow", "dim"
_EMPTY: Final = (" ", "")


class _Box(NamedTuple):
    """The walls of a room, in columns and lines from the upper left."""

    left: int
    top: int
    right: int
    bottom: int

    def has_space_for(self, name: str) -> bool:
        """Return whether *name* fits inside."""
        return self.bottom - self.top >= 2 and self.right - self.left - 3 >= len(name)

    def label(self, text: str, style: str) -> dict[tuple[int, int], _Segment]:
        """Return *text*, cut to fit, in the cells of the middle line."""
        line = (self.top + self.bottom) // 2
        shown = printable(text, self.right - self.left - 2)
        return {(self.left + 2 + place, line): (sign, style) for place, sign in enumerate(shown)}


class _Scale(NamedTuple):
    """The way from metres to characters.

    Attributes:
        across: Columns of a metre.
        down: Lines of a metre.
        lines: Lines of the whole plan.
    """

    west: float
    north: float
    across: float
    down: float
    lines: int

    def at(self, x: float, y: float) -> tuple[int, int]:
        """Return the column and the line of a place."""
        return round((x - self.west) * self.across), round((self.north - y) * self.down)

    def box(self, west: float, south: float, east: float, north: float) -> _Box:
        """Return the walls of a room."""
        return _Box(*self.at(west, north), *self.at(east, south))


class PlanPicture(NamedTuple):
    """The shape of a house, in metres.

    Attributes:
        rooms: The west, south, east and north walls of each room whose extent is known.
    """

    rooms: Mapping[str, tuple[float, float, float, float]]
    doors: Sequence[tuple[float, float]]
    door_width: float

    def lines(self, signs: Mapping[str, str], lit: Collection[str], width: int, height: int) -> list[Line]:
        """Return the lines of the plan; none if a room of it would have no space for its name.

        Args:
            signs: A character for each being, by room.
            width: The columns that it fills.
            height: The most lines.
        """
        if not self.rooms or height < LEAST_LINES:
            return []
        scale = self._scale(width, height)
        boxes = {name: scale.box(*walls) for name, walls in self.rooms.items()}
        if not all(box.has_space_for(name) for name, box in boxes.items()):
            return []
        cells = {place: (_WALLS[ways], _DARK) for place, ways in _walls(boxes.values()).items()}
        for door in self.doors:
            column, line = scale.at(*door)
            half = round(self.door_width * scale.across / 2) if cells.get((column, line), ("",))[0] == "─" else 0
            cells |= {(one, line): _EMPTY for one in range(column - half, column + half + 1)}
        for name, box in boxes.items():
            cells |= box.label(f"{name} {signs.get(name, '')}", _LIT if name in lit else _DARK)
        rows = ([cells.get((column, line), _EMPTY) for column in range(width)] for line in range(scale.lines))
        return [_joined(row) for row in rows]

    def _scale(self, width: int, height: int) -> _Scale:
        wests, souths, easts, norths = zip(*self.rooms.values(), strict=True)
        west, north = min(wests), max(norths)
        metres_across, metres_down = max(easts) - west, north - min(souths)
        wanted = round(metres_down / metres_across * width / _ASPECT)
        lines = min(height, _MOST_LINES, max(LEAST_LINES, wanted))
        return _Scale(west, north, (width - 1) / metres_across, (lines - 1) / metres_down, lines)


def _walls(boxes: Collection[_Box]) -> dict[tuple[int, int], int]:
    """Return, for each place with a wall, the sum of the directions in which it goes on."""
    walls: dict[tuple[int, int], int] = {}
    for left, top, right, bottom in boxes:
        for column in range(left, right + 1):
            ways = (column > left) * _LEFT | (column < right) * _RIGHT
            for line in (top, bottom):
                walls[column, line] = walls.get((column, line), 0) | ways
        for line in range(top, bottom + 1):
            ways = (line > top) * _UP | (line < bottom) * _DOWN
            for column in (left, right):
                walls[column, line] = walls.get((column, line), 0) | ways
    return walls


def _joined(row: Sequence[_Segment]) -> Line:
    """Return *row* with neighbours of one style in one part."""
    return [("".join(sign for sign, _ in some), style) for style, some in groupby(row, lambda cell: cell[1])]
