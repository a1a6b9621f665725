"""The map of a robot vacuum with Valetudo: its rooms, and where the robot and its charger are. Pure.

The payload is JSON, compressed by zlib, or the same in a text chunk of a PNG image, for Home Assistant. Lengths in it
are centimetres and pixels from the top left, y down; here they are metres from the bottom left, y up.

Source: Valetudo 2026.08.0, ``backend/lib/entities/map``.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from itertools import pairwise
from typing import Final, NamedTuple, TypeAlias, final

from homebot.conventions.payload import parse_json, text_of
from homebot.errors import WireError

__all__ = ["SegmentAt", "VacuumMap", "VacuumPose", "VacuumSegment", "read_map"]

_MAX_PAYLOAD: Final = 2**20
_MAX_JSON: Final = 2**24
_MAX_LAYERS: Final = 300
_MAX_RUNS: Final = 200_000
_MAX_PIXELS: Final = 20_000
_MAX_PIXEL_SIZE: Final = 100
_MAX_CENTIMETRES: Final = 100_000

_PNG: Final = b"\x89PNG\r\n\x1a\n"
_CHUNK: Final = b"ValetudoMap\0\0"
_NEARBY: Final = 0.5

Run: TypeAlias = tuple[int, int]
"""The first pixel of a row and the one after the last."""

Corner: TypeAlias = tuple[int, int]
"""A corner of pixels: column and row of the one to its lower right."""


class VacuumPose(NamedTuple):
    """A position on the map.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Radians from the x axis, counter-clockwise; None where that is not stated.
    """

    x: float
    y: float
    yaw: float | None = None


class VacuumSegment(NamedTuple):
    """A room as the vacuum sees it.

    Attributes:
        id: Its number, as text; it changes where the map is segmented anew.
        name: Its name; empty without one.
        runs: Its pixels in each row.
    """

    id: str
    name: str
    runs: Mapping[int, tuple[Run, ...]]


class SegmentAt(NamedTuple):
    """The segment of a position.

    Attributes:
        segment: The segment.
        distance: Metres from the position to its nearest pixel; 0 on one.
    """

    segment: VacuumSegment
    distance: float = 0.0


@final
class VacuumMap(NamedTuple):
    """A map.

    Attributes:
        vendor_id: The vacuum's own number of the map; empty without one.
        pixel: Metres of a pixel.
        height: Metres of the map.
        segments: Its rooms.
        robot: Where the robot is; None where that is not stated.
        charger: Where its charger is; None likewise.
    """

    vendor_id: str
    pixel: float
    height: float
    segments: tuple[VacuumSegment, ...]
    robot: VacuumPose | None
    charger: VacuumPose | None

    @property
    def area(self) -> float:
        """Square metres of all segments."""
        runs = (end - begin for one in self.segments for row in one.runs.values() for begin, end in row)
        return sum(runs) * self.pixel**2

    def segment_at(self, x: float, y: float) -> SegmentAt | None:
        """Return the segment on which a position is, else the nearest within 0.5 m."""
        across, down = round(x / self.pixel, 6), round((self.height - y) / self.pixel, 6)
        reach = math.ceil(_NEARBY / self.pixel)
        best: SegmentAt | None = None
        for segment in self.segments:
            for row in range(math.floor(down) - reach, math.floor(down) + reach + 1):
                for begin, end in segment.runs.get(row, ()):
                    if row <= down < row + 1 and begin <= across < end:
                        return SegmentAt(segment)
                    distance = (
                        math.hypot(max(begin - across, 0.0, across - end), max(row - down, 0.0, down - row - 1))
                        * self.pixel
                    )
                    if distance <= _NEARBY and (best is None or distance < best.distance):
                        best = SegmentAt(segment, distance)
        return best

    def outline(self, segment: VacuumSegment) -> tuple[tuple[float, float], ...]:
        """Return the corners of the largest ring around the pixels of *segment*, in metres, counter-clockwise."""
        rings = _rings(segment.runs)
        ring = max(rings, key=_area, default=())
        return tuple((x * self.pixel, self.height - y * self.pixel) for x, y in reversed(ring))


def read_map(payload: bytes) -> VacuumMap:
    """Return the map in *payload*.

    Raises:
        WireError: It is no such map, or one that is too large.
    """
    value = parse_json(_inflated(payload), _MAX_JSON)
    if not isinstance(value, dict) or value.get("__class") != "ValetudoMap":
        raise WireError("it is no map of Valetudo")
    meta = _object(value.get("metaData"))
    if meta.get("version") not in {1, 2}:
        raise WireError(f"maps of version {meta.get('version')!r:.20} are not known")
    pixel = _whole(value.get("pixelSize"), "pixelSize", 1, _MAX_PIXEL_SIZE)
    height = _whole(_object(value.get("size")).get("y"), "size.y", 1, _MAX_CENTIMETRES)
    layers = _objects(value.get("layers"), "layers")
    points = [one for one in _objects(value.get("entities"), "entities") if one.get("__class") == "PointMapEntity"]
    found = {str(one.get("type")): one for one in points}
    vendor_id = meta.get("vendorMapId")
    return VacuumMap(
        vendor_id=str(vendor_id)[:100] if isinstance(vendor_id, (int, str)) else "",
        pixel=pixel / 100,
        height=height / 100,
        segments=tuple(_segments(one for one in layers if one.get("type") == "segment")),
        robot=_pose(found.get("robot_position"), height),
        charger=_pose(found.get("charger_location"), height),
    )


def _inflated(payload: bytes) -> bytes:
    if payload.startswith(_PNG):
        payload = _text_chunk(payload)
    if payload.startswith(b"{"):
        return payload
    if len(payload) > _MAX_PAYLOAD:
        raise WireError(f"it has {len(payload):,} bytes; {_MAX_PAYLOAD:,} is the limit")
    try:
        inflater = zlib.decompressobj()
        text = inflater.decompress(payload, _MAX_JSON)
    except zlib.error as exc:
        raise WireError(f"it is not compressed by zlib: {exc}") from exc
    if not inflater.eof:
        raise WireError(f"it is cut off, or has more than {_MAX_JSON:,} bytes")
    return text


def _text_chunk(image: bytes) -> bytes:
    """Return the compressed map in a PNG image."""
    at = len(_PNG)
    while at + 8 <= len(image):
        length, kind = int.from_bytes(image[at : at + 4], "big"), image[at + 4 : at + 8]
        data = image[at + 8 : at + 8 + length]
        if kind == b"zTXt" and data.startswith(_CHUNK):
            return data[len(_CHUNK) :]
        at += length + 12
    raise WireError("the image has no map of Valetudo in it")


def _segments(layers: Iterable[Mapping[str, object]]) -> Iterator[VacuumSegment]:
    count = 0
    for layer in layers:
        meta = _object(layer.get("metaData"))
        number = meta.get("segmentId")
        if not isinstance(number, (int, str)):
            raise WireError("a segment has no segmentId")
        rows: dict[int, list[Run]] = {}
        for x, y, length in _runs(layer):
            count += 1
            if count > _MAX_RUNS:
                raise WireError(f"it has more than {_MAX_RUNS:,} runs of pixels")
            rows.setdefault(y, []).append((x, x + length))
        yield VacuumSegment(str(number)[:40], text_of(meta.get("name")), {y: _joined(row) for y, row in rows.items()})


def _runs(layer: Mapping[str, object]) -> Iterator[tuple[int, int, int]]:
    """Yield x, y and length of the runs of pixels in a layer, of version 2 or, a pixel each, 1."""
    numbers = layer.get("compressedPixels") or layer.get("pixels") or []
    size = 3 if layer.get("compressedPixels") else 2
    if not isinstance(numbers, list) or len(numbers) % size:
        raise WireError("the pixels of a segment are no list of runs")
    checked = [_whole(one, "pixels", 0, _MAX_PIXELS) for one in numbers]
    for at in range(0, len(checked), size):
        length = checked[at + 2] if size > 2 else 1
        if length < 1:
            raise WireError("a run of pixels is empty")
        yield checked[at], checked[at + 1], length


def _joined(runs: list[Run]) -> tuple[Run, ...]:
    """Return *runs* of one row in order, with those that touch or overlap as one."""
    found: list[Run] = []
    for begin, end in sorted(runs):
        if found and begin <= found[-1][1]:
            found[-1] = found[-1][0], max(end, found[-1][1])
        else:
            found.append((begin, end))
    return tuple(found)


def _rings(runs: Mapping[int, tuple[Run, ...]]) -> list[tuple[Corner, ...]]:
    """Return the rings around pixels, outer ones clockwise with y down; pixels that touch at a corner are apart."""
    after: dict[Corner, list[Corner]] = {}
    for begin, end in _edges(runs):
        after.setdefault(begin, []).append(end)
    rings = []
    while after:
        start = at = next(iter(after))
        ring, before = [start], (0, 0)
        while len(ring) == 1 or at != start:
            # Of two ways on at a corner where pixels touch, the one to the right stays at this pixel.
            following = after[at]
            chosen = max(following, key=partial(_turn, before, at))
            following.remove(chosen)
            if not following:
                del after[at]
            before, at = at, chosen
            ring.append(at)
        rings.append(tuple(ring[:-1]))
    return rings


def _edges(runs: Mapping[int, tuple[Run, ...]]) -> Iterator[tuple[Corner, Corner]]:
    """Yield the edges between pixels and others, with the pixel to the right, y down."""
    for row in sorted(set(runs) | {row + 1 for row in runs}):
        above, here = runs.get(row - 1, ()), runs.get(row, ())
        for begin, end in pairwise(sorted({end for run in (*above, *here) for end in run})):
            is_above, is_here = (any(a <= begin < b for a, b in one) for one in (above, here))
            if is_here and not is_above:
                yield (begin, row), (end, row)
            elif is_above and not is_here:
                yield (end, row), (begin, row)
        for begin, end in here:
            yield (end, row), (end, row + 1)
            yield (begin, row + 1), (begin, row)


def _turn(before: Corner, at: Corner, after: Corner) -> int:
    """Return a number above 0 for a turn to the right, with y down."""
    return (at[0] - before[0]) * (after[1] - at[1]) - (at[1] - before[1]) * (after[0] - at[0])


def _area(ring: tuple[tuple[int, int], ...]) -> int:
    return sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in zip(ring, (*ring[1:], ring[0]), strict=True))


def _pose(entity: Mapping[str, object] | None, height: int) -> VacuumPose | None:
    if entity is None:
        return None
    points = entity.get("points")
    if not isinstance(points, list) or len(points) != 2:
        raise WireError("the points of a position are not two numbers")
    x, y = (_whole(one, "points", -_MAX_CENTIMETRES, _MAX_CENTIMETRES) for one in points)
    angle = _object(entity.get("metaData")).get("angle")
    yaw = math.radians(90 - angle) if isinstance(angle, (int, float)) and not isinstance(angle, bool) else None
    return VacuumPose(x / 100, (height - y) / 100, None if yaw is None else math.remainder(yaw, math.tau))


def _whole(value: object, name: str, least: int, most: int) -> int:
    number = int(value) if isinstance(value, (int, float)) and value == value // 1 else None
    if number is None or isinstance(value, bool) or not least <= number <= most:
        raise WireError(f"{name} is {value!r:.40}, not a whole number from {least:,} to {most:,}")
    return number


def _object(value: object) -> Mapping[str, object]:
    return value if isinstance(value, dict) else {}


def _objects(value: object, name: str) -> list[Mapping[str, object]]:
    if not isinstance(value, list) or len(value) > _MAX_LAYERS:
        raise WireError(f"{name} is no list of at most {_MAX_LAYERS}")
    return [one for one in value if isinstance(one, dict)]
