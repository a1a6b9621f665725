"""The plan of a house as lines for a terminal: rooms, doors, light, and the beings in each room. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
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


class _Box(NamedTuple):
    """The walls of a room, in columns and lines from the upper left."""

    left: int
    top: int
    right: int
    bottom: int


class PlanPicture(NamedTuple):
    """The shape of a house, in metres.

    Attributes:
        rooms: The west, south, east and north walls of each room whose extent is known.
        doors: The middle of each door.
        door_width: The width of all of them.
    """

    rooms: Mapping[str, tuple[float, float, float, float]]
    doors: Sequence[tuple[float, float]]
    door_width: float

    def lines(self, signs: Mapping[str, str], lit: Collection[str], width: int, height: int) -> list[Line]:
        """Return the lines of the plan; none if a room of it would have no space for its name.

        Args:
            signs: A character for each being, by room.
            lit: The rooms with light.
            width: The columns that it fills.
            height: The most lines.
        """
        if not self.rooms or height < LEAST_LINES:
            return []
        west, east = min(one[0] for one in self.rooms.values()), max(one[2] for one in self.rooms.values())
        south, north = min(one[1] for one in self.rooms.values()), max(one[3] for one in self.rooms.values())
        across, down = (width - 1) / (east - west), (north - south) / (east - west) * width / _ASPECT
        count = min(height, _MOST_LINES, max(LEAST_LINES, round(down)))
        down = (count - 1) / (north - south)

        def at(x: float, y: float) -> tuple[int, int]:
            return round((x - west) * across), round((north - y) * down)

        boxes = {name: _Box(*at(one[0], one[3]), *at(one[2], one[1])) for name, one in self.rooms.items()}
        if any(one.bottom - one.top < 2 or one.right - one.left - 3 < len(name) for name, one in boxes.items()):
            return []
        cells = {place: (_WALLS[ways], _DARK) for place, ways in _walls(boxes.values()).items()}
        for column, line in (at(*door) for door in self.doors):
            half = round(self.door_width * across / 2) if cells.get((column, line), ("",))[0] == "─" else 0
            cells |= {(one, line): (" ", "") for one in range(column - half, column + half + 1)}
        for name, box in boxes.items():
            text = printable(f"{name} {signs.get(name, '')}", box.right - box.left - 2)
            style, line = _LIT if name in lit else _DARK, (box.top + box.bottom) // 2
            cells |= {(box.left + 2 + place, line): (sign, style) for place, sign in enumerate(text)}
        rows = ([cells.get((column, line), (" ", "")) for column in range(width)] for line in range(count))
        return [[("".join(sign for sign, _ in some), style) for style, some in _by_style(row)] for row in rows]


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


def _by_style(row: Sequence[_Segment]) -> Iterator[tuple[str, Iterator[_Segment]]]:
    return groupby(row, lambda cell: cell[1])
