"""Comparison of the areas of rooms with a map of a robot: a file of map_server, or ``/map`` on the graph."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from homebot.cli.door_client import DoorClient
from homebot.errors import LinkError, UsageError
from homebot.messages.json import message_from_json
from homebot.messages.nav_msgs import OccupancyGrid
from homebot.places.grey_image import read_grey_image
from homebot.places.map_file import CellGrid, make_grid, read_map_settings
from homebot.places.polygon import Polygon
from homebot.places.rigid import yaw_of

if TYPE_CHECKING:
    from homebot.devices.places_messages import AreaRing, RoomInfo

__all__ = ["map_on_graph", "misfits", "read_map"]

MAP = "/map"

_LARGEST_YAML = 100_000
_LARGEST_IMAGE = 64_000_000
_WAIT = 10.0
_MOST_MISFIT = 0.25
"""The share of a room that may be occupied or unknown in a map: furniture and its shadows."""

_STEPS = 60


def read_map(file: str) -> tuple[CellGrid, str]:
    """Return the map of a YAML file and its image, and a warning that is empty for none.

    Raises:
        ConfigError, UsageError: One of them cannot be read, or is none; names the file and the value.
    """
    settings = read_map_settings(_content(Path(file), _LARGEST_YAML).decode(errors="replace"), file)
    image = Path(file).parent / settings.image
    content = _content(image, _LARGEST_IMAGE)
    try:
        return make_grid(settings, read_grey_image(content)), settings.warning
    except UsageError as exc:
        raise UsageError(f"{image} {exc}") from exc


def map_on_graph(door: DoorClient) -> CellGrid:
    """Return the map on the topic ``/map``.

    Raises:
        LinkError: There is none.
    """
    door.subscribe(MAP)
    for message in door.until(_WAIT):
        if message.topic == MAP:
            found = message_from_json(OccupancyGrid, message.message)
            info, pose = found.info, found.info.origin
            turn = pose.orientation
            origin = pose.position.x, pose.position.y, yaw_of((turn.x, turn.y, turn.z, turn.w))
            cells = bytes(cell & 255 for cell in found.data)
            return CellGrid(info.width, info.height, info.resolution, origin, cells)
    raise LinkError(f"no map was published on {MAP}; start the robot's map_server, or state a FILE")


def misfits(grid: CellGrid, rooms: Sequence[RoomInfo]) -> Iterator[tuple[str, float]]:
    """Yield each room of which more than a quarter is not free in the map, and the share."""
    for room in rooms:
        shares = [_blocked(grid, area) for area in _areas(room.areas)]
        if shares and max(shares) > _MOST_MISFIT:
            yield room.name, max(shares)


def _blocked(grid: CellGrid, area: Polygon) -> float:
    """Return the share of an area that is occupied, unknown, or beyond the map."""
    box = area.box
    columns, rows = (box.right - box.left) / _STEPS, (box.top - box.bottom) / _STEPS
    points = (
        (box.left + (column + 0.5) * columns, box.bottom + (row + 0.5) * rows)
        for column in range(_STEPS)
        for row in range(_STEPS)
    )
    cells = [grid.cell_at(x, y) for x, y in points if area.contains(x, y)]
    return sum(cell != 0 for cell in cells) / len(cells) if cells else 0.0


def _areas(rings: Sequence[AreaRing]) -> Iterator[Polygon]:
    several: list[list[list[tuple[float, float]]]] = []
    for ring in rings:
        corners = list(zip(ring.x, ring.y, strict=True))
        if ring.is_hole and several:
            several[-1].append(corners)
        else:
            several.append([corners])
    return (Polygon(first, holes) for first, *holes in several)


def _content(path: Path, most: int) -> bytes:
    try:
        with path.open("rb") as opened:
            content = opened.read(most + 1)
    except OSError as exc:
        raise UsageError(f"{path} cannot be read: {exc.strerror or exc}") from exc
    if len(content) > most:
        raise UsageError(f"{path} is larger than {most // 1000:,} kB")
    return content
