"""Maps of robots: files of ROS's map_server, and ``nav_msgs/OccupancyGrid`` on the graph. Loaded when used.

A map has free cells and walls, but no rooms: their extents follow from a point in each, and the ends of their doors.

Source: nav2_map_server 1.5.0, map_io.cpp. Its thresholds are compared as 32-bit floating-point numbers.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from struct import pack, unpack
from typing import Annotated, Final, Literal, NamedTuple, TypeAlias

from PIL import Image, ImageDraw
from pydantic import BaseModel, Field

from homebot.cli.yaml import read_yaml
from homebot.config import parse_settings
from homebot.errors import ConfigError, UsageError, WireError
from homebot.messages.json import message_from_json
from homebot.messages.nav_msgs import OccupancyGrid
from homebot.places import HouseRoom
from homebot.places.outline import simplified, traced
from homebot.places.plan import Point
from homebot.places.rigid import MapPose, yaw_of

UNKNOWN: Final = 255
"""The byte of an unknown cell: -1."""

_OCCUPIED: Final = 100
_FREE: Final = re.compile(b"\0+")
_MAX_ROOMS: Final = 150
_MAX_RUNS: Final = 300_000
_MAX_PIXELS: Final = 16_000_000
_UNKNOWN_GREY: Final = 205
_BESIDE: Final = 0.2
"""Metres by which a stated door may end before the map's wall."""

_LARGEST: Final = 1e6
_SMALLEST: Final = 1e-6
"""Limits of the cell size, and of the distance from the origin, in metres."""

_Number: TypeAlias = Annotated[float, Field(ge=-_LARGEST, le=_LARGEST, allow_inf_nan=False)]
_Share: TypeAlias = Annotated[float, Field(ge=0, le=1)]


class MapSettings(BaseModel):
    """The YAML file of a map; unknown keys are ignored.

    Attributes:
        image: The file of the image, relative to the folder of the YAML file.
        resolution: The cell size in metres.
        origin: x, y and yaw of the lower left corner, in metres and radians.
        occupied_thresh: The occupancy from which a cell is occupied.
        free_thresh: The occupancy up to which a cell is free.
        negate: Whether black is free.
        mode: The meaning of greys between the two.
    """

    image: str
    resolution: Annotated[_Number, Field(ge=_SMALLEST)]
    origin: tuple[_Number, _Number, _Number]
    occupied_thresh: _Share
    free_thresh: _Share
    negate: bool | Literal[0, 1]
    mode: Literal["trinary", "scale", "raw"] = "trinary"

    @property
    def warning(self) -> str:
        """A common mistake in the file, in words; empty for none."""
        if self.mode == "trinary" and not self.negate and cell_table(self)[_UNKNOWN_GREY] == 0:
            grey = f"the grey {_UNKNOWN_GREY}, as savers write unknown cells"
            return f"free_thresh {self.free_thresh:g} makes {grey}, free; use 0.196"
        return ""


class RobotMap(NamedTuple):
    """A map.

    Attributes:
        cells: 0 (free) to 100 (occupied), 255 for unknown; the first row is at the top.
        resolution: The cell size in metres.
        origin: The lower left corner.
    """

    cells: Image.Image
    resolution: float
    origin: MapPose

    @classmethod
    def of(cls, message: Mapping[str, object]) -> RobotMap:
        """Return the map in a message as JSON.

        Raises:
            TypeMismatchError: It is not a ``nav_msgs/OccupancyGrid``.
            WireError: The number of cells differs from the stated one, or a number is impossible.
        """
        grid = message_from_json(OccupancyGrid, message)
        info, turn = grid.info, grid.info.origin.orientation
        if len(grid.data) != info.width * info.height or not grid.data:
            raise WireError(f"the map has {len(grid.data):,} cells, and states {info.width:,} x {info.height:,}")
        upwards = Image.frombytes("L", (info.width, info.height), bytes(cell & 255 for cell in grid.data))
        at = info.origin.position
        origin = MapPose(at.x, at.y, yaw_of((turn.x, turn.y, turn.z, turn.w)))
        if not (_SMALLEST <= info.resolution <= _LARGEST and all(abs(coordinate) <= _LARGEST for coordinate in origin)):
            raise WireError(f"the map has cells of {info.resolution:g} m from {origin.x:g},{origin.y:g}")
        return cls(upwards.transpose(Image.Transpose.FLIP_TOP_BOTTOM), info.resolution, origin)

    def rooms(self, points: Mapping[str, Point], doors: Iterable[Sequence[Point]]) -> Iterator[HouseRoom]:
        """Yield the room around each point: its free cells up to walls and the lines between the ends of *doors*.

        Raises:
            UsageError: A point is not free, two are in one area, or an area is not a room.
        """
        names = list(points)
        if len(names) > _MAX_ROOMS:
            raise UsageError(f"{len(names):,} rooms are too many; {_MAX_ROOMS} is the limit")
        # with a wall in each door
        cells = self.cells.copy()
        for first, last in doors:
            share = 1 + _BESIDE / (math.dist(first, last) or 1.0)
            ends = (self._pixel(_between(a, b, share)) for a, b in ((first, last), (last, first)))
            ImageDraw.Draw(cells).line([*ends], fill=_OCCUPIED)
        rows = [bytearray(cells.crop((0, row, cells.width, row + 1)).tobytes()) for row in range(cells.height)]
        for number, (name, point) in enumerate(points.items(), _OCCUPIED + 1):
            column, row = self._pixel(point)
            is_inside = 0 <= column < self.cells.width and 0 <= row < self.cells.height
            here = rows[row][column] if is_inside else UNKNOWN
            if _OCCUPIED < here < UNKNOWN:
                other = names[here - _OCCUPIED - 1]
                door = f'rooms = ["{other}", "{name}"], position = [[X, Y], [X, Y]]'
                hint = f"state both ends of the door between them: [[places.doors]] {door}"
                raise UsageError(f"{other} and {name} are one free area of the map; {hint}")
            if here != 0:
                raise UsageError(f"the point {point[0]:g},{point[1]:g} of {name} is not free in the map")
            ring = simplified(self._in_metres(traced(_fill(rows, row, column, number))))
            if not ring:
                raise UsageError(f"the free area around {point[0]:g},{point[1]:g} is too small for {name}")
            yield HouseRoom(name, polygons=((ring,),))

    def _in_metres(self, ring: Iterable[tuple[int, int]]) -> list[Point]:
        """Return the corners of cells in metres in the house."""
        height, size = self.cells.height, self.resolution
        at = (self.origin.then(MapPose(x * size, (height - y) * size)) for x, y in ring)
        return [(round(point.x, 3), round(point.y, 3)) for point in at]

    def _pixel(self, point: Point) -> tuple[int, int]:
        across = complex(*point) - complex(self.origin.x, self.origin.y)
        at = across / cmath.rect(self.resolution, self.origin.yaw)
        return math.floor(at.real), self.cells.height - 1 - math.floor(at.imag)


def read_map(file: str) -> tuple[RobotMap, str]:
    """Return the map of a YAML file and its image, and a warning, empty for none.

    Raises:
        ConfigError, UsageError: A file cannot be read, or is invalid; names the file and the value.
    """
    table = read_yaml(file)
    settings = parse_settings(MapSettings, table if isinstance(table, dict) else {}, file, "")
    if settings.free_thresh >= settings.occupied_thresh:
        raise ConfigError(file, "free_thresh", "must be below occupied_thresh")
    path = Path(file).parent / settings.image
    try:
        with Image.open(path, formats=("PPM", "PNG", "BMP")) as image:
            if image.width * image.height > _MAX_PIXELS:
                raise UsageError(f"{path} has {image.width:,} x {image.height:,} pixels; {_MAX_PIXELS:,} is the limit")
            return RobotMap(_cells(image, settings), settings.resolution, MapPose(*settings.origin)), settings.warning
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as exc:
        raise UsageError(f"{path} cannot be read: {getattr(exc, 'strerror', None) or exc}") from exc


def cell_table(settings: MapSettings) -> bytes:
    """Return the cell value for each grey."""
    if settings.mode == "raw":
        return bytes(grey if grey <= _OCCUPIED else UNKNOWN for grey in range(256))
    return bytes(_cell(grey, settings) for grey in range(256))


def _cells(image: Image.Image, settings: MapSettings) -> Image.Image:
    """Return the cells of an image by the mean of its colours; transparent pixels are unknown."""
    if image.mode.startswith("I"):  # 16 bits
        image = image.convert("I").point(lambda grey: grey * (1 / 257)).convert("L")
    colours = image.convert("RGBA")
    mean = colours.convert("RGB").convert("L", (1 / 3, 1 / 3, 1 / 3, 0))
    cells = mean.point(list(cell_table(settings)))
    if settings.mode != "raw":
        cells.paste(UNKNOWN, mask=colours.getchannel("A").point([255] * 255 + [0]))
    return cells


def _cell(grey: int, settings: MapSettings) -> int:
    occupied, free = _single(settings.occupied_thresh), _single(settings.free_thresh)
    share = _single(grey / 255) if settings.negate else _single(1 - _single(grey / 255))
    if share >= occupied:
        return _OCCUPIED
    if share <= free:
        return 0
    return round((share - free) / (occupied - free) * 100) if settings.mode == "scale" else UNKNOWN


def _fill(rows: list[bytearray], row: int, column: int, value: int) -> dict[int, list[int]]:
    """Give the free cells that are connected with one *value*; return the columns at which they begin and end, by row.

    Raises:
        UsageError: They are no room, but noise.
    """
    ends: dict[int, list[int]] = {}
    runs = 0
    waiting = [(row, column, column + 1)]
    while waiting:
        row, left, right = waiting.pop()
        cells = rows[row]
        while (at := cells.find(0, left, right)) >= 0:
            begin = len(cells[:at].rstrip(b"\0"))
            match = _FREE.match(cells, at)
            left = match.end() if match else right
            cells[begin:left] = bytes((value,)) * (left - begin)
            ends.setdefault(row, []).extend((begin, left))
            runs += 1
            if runs > _MAX_RUNS:
                raise UsageError(f"a free area of the map has over {_MAX_RUNS:,} strips; filter its noise first")
            waiting += [(near_row, begin, left) for near_row in (row - 1, row + 1) if 0 <= near_row < len(rows)]
    return {row: sorted(columns) for row, columns in ends.items()}


def _single(number: float) -> float:
    return float(unpack("f", pack("f", number))[0])


def _between(first: Point, last: Point, share: float) -> Point:
    return first[0] + (last[0] - first[0]) * share, first[1] + (last[1] - first[1]) * share
