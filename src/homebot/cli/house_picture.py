"""A house with its plan and story as lines for a terminal. Pure."""

from __future__ import annotations

import textwrap
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import groupby, zip_longest
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

from homebot.devices.wording.values import life, state_text
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.cli.story import StoryLine
    from homebot.devices import Device

_WIDE: Final = 70
"""Terminal width from which the rooms are in two columns."""

_MIN_STORY_LINES, _MAX_STORY_LINES = 4, 10
"""Lines of the story if there is room."""

_STORY_BESIDE_PLAN: Final = 6
"""Lines of the story next to a plan of the house."""

_STATE: Final = 9
_DIALECT: Final = 13
_TIGHT: Final = 28
"""Height below which no line is left empty."""

_GAP: Final = 2
_LOST: Final = "red"
_STYLES: Final = (("on", "yellow"), ("off", "dim"), ("clear", "dim"))
"""The style of a state by its beginning."""

_Segment: TypeAlias = tuple[str, str]
"""Text, and its rich style."""

Line: TypeAlias = Sequence[_Segment]
"""One line, as segments."""

MIN_LINES: Final = 5
_MAX_LINES: Final = 9
_ASPECT: Final = 2.0
"""The height of a character in character widths."""

_LEFT, _RIGHT, _UP, _DOWN = 1, 2, 4, 8
_WALLS: Final = " ╴╶─╵┘└┴╷┐┌┬│┤├┼"
"""The character for each sum of the directions in which a wall continues."""

_LIT, _DARK = "yellow", "dim"
_EMPTY: Final = (" ", "")


class HousePicture(NamedTuple):
    """The view of a house at one moment.

    Attributes:
        story: The events, oldest first.
    """

    title: str
    hint: str
    devices: Sequence[Device]
    beings: Mapping[str, Sequence[str]]
    story: Sequence[StoryLine]
    plan: PlanPicture


def lines_of(picture: HousePicture, width: int, height: int) -> list[Line]:
    """Return as many lines of *picture* as fit in *height*; each may have to be cut at *width*."""
    is_wide = width >= _WIDE
    column = (width - _GAP) // 2 if is_wide else width
    blocks = [_room(room, devices, picture.beings.get(room, ()), column) for room, devices in _by_room(picture.devices)]
    rooms = _beside(*_halves(blocks), column) if is_wide else [line for block in blocks for line in block]
    plan = _plan(picture, width, height - 3 - len(rooms) - _STORY_BESIDE_PLAN) if is_wide else []
    head: list[Line] = [[(picture.title, "bold")], *([[("", "")]] if height >= _TIGHT and not plan else [])]
    left = height - len(head) - len(plan) - 2
    story = max(_MIN_STORY_LINES, min(_MAX_STORY_LINES, left - len(rooms)))
    story_lines = _story(picture.story, width, story)
    return [
        *head,
        *plan,
        *rooms[: max(0, left - story)],
        [("─" * width, "dim")],
        *story_lines,
        *([[("", "")]] * (story - len(story_lines))),
        [(picture.hint, "dim")],
    ]


def _plan(picture: HousePicture, width: int, height: int) -> list[Line]:
    signs = {room: "".join(being[0] for being in beings) for room, beings in picture.beings.items()}
    lamps = (device for device in picture.devices if any(part.part.service_type == "light" for part in device.parts))
    lit = {lamp.area for lamp in lamps if state_text(lamp).startswith("on")}
    return picture.plan.lines(signs, lit, width, height)


def _by_room(devices: Iterable[Device]) -> list[tuple[str, list[Device]]]:
    rooms: dict[str, list[Device]] = {}
    for device in sorted(devices, key=lambda device: (not device.area, device.area, device.name)):
        rooms.setdefault(device.area, []).append(device)
    return list(rooms.items())


def _room(room: str, devices: Iterable[Device], beings: Sequence[str], width: int) -> list[Line]:
    with_beings: list[tuple[str, str]] = [(f"  {', '.join(beings)}", "cyan")] if beings else []
    return [[(printable(room) or "no room", "bold"), *with_beings], *(_device(device, width) for device in devices)]


def _device(device: Device, width: int) -> Line:
    routes = [route for part in device.parts for route in part.routes]
    dialect = next((route.convention for route in routes if route.convention), "") or "plain MQTT"
    columns = max(8, width - _STATE - _DIALECT - 3)
    name = printable(device.name or device.id, columns)
    is_lost = device.freshness == "stale" or device.reachable.state == "no"
    state = printable(life(device) if is_lost else state_text(device).partition(", ")[0], _STATE)
    style = _LOST if is_lost else next((style for word, style in _STYLES if state.startswith(word)), "")
    return [(f" {name:<{columns}} ", ""), (f"{state:<{_STATE}} ", style), (dialect[:_DIALECT], "dim")]


def _halves(blocks: Sequence[list[Line]]) -> tuple[list[Line], list[Line]]:
    """Return the rooms as two columns, the first as long as the second, or as little longer as possible."""
    left: list[Line] = []
    half = sum(map(len, blocks)) / 2
    taken = 0
    for block in blocks:
        if left and len(left) >= half:
            break
        left += block
        taken += 1
    return left, [line for block in blocks[taken:] for line in block]


def _beside(left: Sequence[Line], right: Sequence[Line], column: int) -> list[Line]:
    lines: list[Line] = []
    for left_line, other in zip_longest(left, right, fillvalue=()):
        length = sum(len(text) for text, _ in left_line)
        lines.append([*left_line, (" " * max(0, column + _GAP - length), ""), *other])
    return lines


def _story(story: Sequence[StoryLine], width: int, most: int) -> list[Line]:
    """Return the newest lines of the story that fit into *most* lines; long ones are wrapped."""
    lines: list[Line] = []
    for story_line in reversed(story):
        begin = f"{story_line.time} "
        indent = " " * (len(begin) + 2)
        first, *others = textwrap.wrap(story_line.text, max(20, width - len(indent))) or [""]
        if len(lines) + 1 + len(others) > most:
            break
        lines[:0] = [
            [(begin, "dim"), (f"{story_line.sign} {first}", story_line.style)],
            *([(f"{indent}{text}", story_line.style)] for text in others),
        ]
    return lines


class _Box(NamedTuple):
    """The walls of a room, in columns and lines from the top left."""

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
    """The scale of metres to characters.

    Attributes:
        across: Columns per metre.
        down: Lines per metre.
        lines: Lines of the whole plan.
    """

    west: float
    north: float
    across: float
    down: float
    lines: int

    def at(self, x: float, y: float) -> tuple[int, int]:
        """Return the column and the line of a point."""
        return round((x - self.west) * self.across), round((self.north - y) * self.down)

    def box(self, west: float, south: float, east: float, north: float) -> _Box:
        """Return the walls of a room."""
        return _Box(*self.at(west, north), *self.at(east, south))


class PlanPicture(NamedTuple):
    """The shape of a house, in metres.

    Attributes:
        rooms: The west, south, east and north walls of each room of known extent.
    """

    rooms: Mapping[str, tuple[float, float, float, float]]
    doors: Sequence[tuple[float, float]]
    door_width: float

    def lines(self, signs: Mapping[str, str], lit: Collection[str], width: int, height: int) -> list[Line]:
        """Return the lines of the plan; none if a room has no space for its name.

        Args:
            signs: A character for each person or robot, by room.
        """
        if not self.rooms or height < MIN_LINES:
            return []
        wests, souths, easts, norths = zip(*self.rooms.values(), strict=True)
        west, north = min(wests), max(norths)
        metres_across, metres_down = max(easts) - west, north - min(souths)
        wanted = round(metres_down / metres_across * width / _ASPECT)
        lines = min(height, _MAX_LINES, max(MIN_LINES, wanted))
        scale = _Scale(west, north, (width - 1) / metres_across, (lines - 1) / metres_down, lines)
        boxes = {name: scale.box(*walls) for name, walls in self.rooms.items()}
        if not all(box.has_space_for(name) for name, box in boxes.items()):
            return []
        cells = self._walls_with_doors(boxes.values(), scale)
        for name, box in boxes.items():
            cells |= box.label(f"{name} {signs.get(name, '')}", _LIT if name in lit else _DARK)
        return [_join([cells.get((column, line), _EMPTY) for column in range(width)]) for line in range(scale.lines)]

    def _walls_with_doors(self, boxes: Collection[_Box], scale: _Scale) -> dict[tuple[int, int], tuple[str, str]]:
        cells = {place: (_WALLS[ways], _DARK) for place, ways in _walls(boxes).items()}
        for door in self.doors:
            column, line = scale.at(*door)
            half = round(self.door_width * scale.across / 2) if cells.get((column, line), ("",))[0] == "─" else 0
            cells |= {(x, line): _EMPTY for x in range(column - half, column + half + 1)}
        return cells


def _walls(boxes: Collection[_Box]) -> dict[tuple[int, int], int]:
    """Return the sum of the directions in which the wall continues, for each cell with a wall."""
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


def _join(row: Sequence[_Segment]) -> Line:
    return [("".join(sign for sign, _ in some), style) for style, some in groupby(row, lambda cell: cell[1])]
