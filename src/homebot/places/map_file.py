"""Maps of ROS's map_server: the YAML file, and cells of the image. Pure.

Source: nav2_map_server 1.5.0, map_io.cpp. Its thresholds are compared as 32-bit floating-point numbers.
"""

from __future__ import annotations

import math
from struct import pack, unpack
from typing import NamedTuple

from homebot.errors import ConfigError
from homebot.places.grey_image import GreyImage

__all__ = ["CellGrid", "MapSettings", "cell_table", "make_grid", "read_map_settings"]

UNKNOWN = 255
"""The byte of a cell that is not known: -1."""

_OCCUPIED = 100
_KEYS = ("image", "resolution", "origin", "occupied_thresh", "free_thresh", "negate")
_MODES = ("trinary", "scale", "raw")
_UNKNOWN_GREY = 205


class MapSettings(NamedTuple):
    """A YAML file of map_server.

    Attributes:
        image: The file of the image, from the folder of the YAML file.
        resolution: Metres of a cell.
        origin: x, y and yaw of the lower left corner, in metres and radians.
        occupied: The occupancy, 0 to 1, from which a cell is occupied.
        free: The one up to which it is free.
        negate: Whether black is free.
        mode: ``trinary``, ``scale`` or ``raw``.
    """

    image: str
    resolution: float
    origin: tuple[float, float, float]
    occupied: float
    free: float
    negate: bool = False
    mode: str = "trinary"

    @property
    def warning(self) -> str:
        """A mistake that many files have, in words; empty for none."""
        if self.mode == "trinary" and not self.negate and cell_table(self)[_UNKNOWN_GREY] == 0:
            grey = f"the grey {_UNKNOWN_GREY}, as savers write unknown cells"
            return f"free_thresh {self.free:g} makes {grey}, free; use 0.196"
        return ""


class CellGrid(NamedTuple):
    """The cells of a map, row by row from the lower left corner.

    Attributes:
        width: Columns.
        height: Rows.
        resolution: Metres of a cell.
        origin: x, y and yaw of the corner.
        cells: 0 free to 100 occupied, 255 unknown.
    """

    width: int
    height: int
    resolution: float
    origin: tuple[float, float, float]
    cells: bytes

    def cell_at(self, x: float, y: float) -> int:
        """Return the cell at a point; an unknown one beyond the map."""
        dx, dy, (c, s) = x - self.origin[0], y - self.origin[1], (math.cos(self.origin[2]), math.sin(self.origin[2]))
        column = math.floor((dx * c + dy * s) / self.resolution)
        row = math.floor((dy * c - dx * s) / self.resolution)
        is_inside = 0 <= column < self.width and 0 <= row < self.height
        return self.cells[row * self.width + column] if is_inside else UNKNOWN


def read_map_settings(text: str, source: str) -> MapSettings:
    """Return the settings in a YAML file: keys with a value or a list, and nothing deeper.

    Raises:
        ConfigError: One is missing, or cannot be; names the key and the value.
    """
    table = _flat_yaml(text, source)
    for key in _KEYS:
        if key not in table:
            raise ConfigError(source, key, "is missing")
    number = {key: _number(table[key], source, key) for key in ("resolution", "occupied_thresh", "free_thresh")}
    origin = table["origin"]
    if not isinstance(origin, list) or len(origin) != 3:
        raise ConfigError(source, "origin", f"must be [x, y, yaw], got {origin!r}")
    x, y, yaw = (_number(one, source, "origin") for one in origin)
    negate, mode = str(table["negate"]).lower(), str(table.get("mode", "trinary"))
    if negate not in {"0", "1", "true", "false"}:
        raise ConfigError(source, "negate", f"must be 0 or 1, got {negate!r}")
    if mode not in _MODES:
        raise ConfigError(source, "mode", f"must be one of {', '.join(_MODES)}, got {mode!r}")
    if number["resolution"] <= 0:
        raise ConfigError(source, "resolution", f"must be above 0, got {number['resolution']:g}")
    if not 0 <= number["free_thresh"] < number["occupied_thresh"] <= 1:
        raise ConfigError(source, "free_thresh", "must be below occupied_thresh, and both from 0 to 1")
    limits = number["occupied_thresh"], number["free_thresh"]
    image = str(table["image"])
    return MapSettings(image, number["resolution"], (x, y, yaw), *limits, negate in {"1", "true"}, mode)


def cell_table(settings: MapSettings) -> bytes:
    """Return the cell for each grey."""
    if settings.mode == "raw":
        return bytes(grey if grey <= _OCCUPIED else UNKNOWN for grey in range(256))
    return bytes(_cell(grey, settings) for grey in range(256))


def make_grid(settings: MapSettings, image: GreyImage) -> CellGrid:
    """Return the cells of an image, the first row of which is the uppermost."""
    cells = image.grey.translate(cell_table(settings))
    if image.alpha and settings.mode != "raw":
        cells = bytes(cell if alpha == UNKNOWN else UNKNOWN for cell, alpha in zip(cells, image.alpha, strict=True))
    width = image.width
    rows = (cells[start : start + width] for start in range(len(cells) - width, -1, -width))
    return CellGrid(width, image.height, settings.resolution, settings.origin, b"".join(rows))


def _cell(grey: int, settings: MapSettings) -> int:
    occupied, free = _single(settings.occupied), _single(settings.free)
    share = _single(grey / 255) if settings.negate else _single(1 - _single(grey / 255))
    if share >= occupied:
        return _OCCUPIED
    if share <= free:
        return 0
    return round((share - free) / (occupied - free) * 100) if settings.mode == "scale" else UNKNOWN


def _single(number: float) -> float:
    """Return *number* as a 32-bit floating-point number."""
    return float(unpack("f", pack("f", number))[0])


def _number(value: object, source: str, key: str) -> float:
    try:
        number = float(str(value))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ConfigError(source, key, f"must be a number, got {value!r}")
    return number


def _flat_yaml(text: str, source: str) -> dict[str, object]:
    found: dict[str, object] = {}
    last = ""
    for line in text.splitlines():
        stripped = line.partition(" #")[0].strip()
        if not stripped or stripped[0] in "#%" or stripped in {"---", "..."}:
            continue
        if stripped.startswith("- ") and isinstance(items := found.get(last), list):
            items.append(_scalar(stripped[2:]))
            continue
        key, colon, value = stripped.partition(":")
        if not colon or line[0].isspace():
            raise ConfigError(
                source, last, f"{stripped[:40]!r} is no line with a key and a value, as in a map's YAML file"
            )
        last, value = key.strip().strip("'\""), value.strip()
        if value.startswith("["):
            found[last] = [_scalar(one) for one in value.strip("[]").split(",")]
        else:
            found[last] = _scalar(value) if value else []
    return found


def _scalar(text: str) -> str:
    return text.strip().strip("'\"")
