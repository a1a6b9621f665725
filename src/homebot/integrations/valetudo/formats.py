"""The map of a robot vacuum with Valetudo: its rooms, and where the robot is. Pure.

The payload is JSON, as a rule compressed by zlib. Lengths in it are centimetres and pixels from the top left, y down;
here they are metres from the bottom left, y up.

Source: Valetudo 2026.08.0, ``backend/lib/entities/map``.
"""

import math
import zlib
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, FailFast, Field, ValidationError
from pydantic.alias_generators import to_camel

from homebot.conventions.payload import text_of
from homebot.conventions.vacuum_map import VacuumMap, VacuumSegment
from homebot.errors import WireError
from homebot.places.rigid import MapPose

_MAX_PAYLOAD: Final = 2**20
_MAX_JSON: Final = 2**23
_MAX_NUMBERS: Final = 600_000
_MAX_VALUES: Final = 100_000
"""Keys, lists and tables: in memory each takes a hundred times its length."""

_Pixels: TypeAlias = Annotated[int, Field(ge=0, le=20_000)]


class _Json(BaseModel):
    model_config = ConfigDict(strict=True, alias_generator=to_camel, defer_build=True)


class _Meta(_Json):
    version: Literal[1, 2] = 2
    vendor_map_id: int | str = ""
    segment_id: int | str | None = None
    name: object = None
    angle: Annotated[float, Field(allow_inf_nan=False)] = 90.0


class _Layer(_Json):
    type: str
    meta_data: _Meta
    pixels: Annotated[list[_Pixels], FailFast()] = []
    compressed_pixels: Annotated[list[_Pixels], FailFast()] = []


class _Entity(_Json):
    type: str
    points: Annotated[list[Annotated[float, Field(ge=-100_000, le=100_000)]], FailFast()]
    meta_data: _Meta


class _Size(_Json):
    y: Annotated[int, Field(ge=1, le=100_000)]


class _Map(_Json):
    kind: Annotated[Literal["ValetudoMap"], Field(alias="__class")]
    meta_data: _Meta
    size: _Size
    pixel_size: Annotated[int, Field(ge=1, le=100)]
    layers: Annotated[list[_Layer], Field(max_length=300)]
    entities: Annotated[list[_Entity], Field(max_length=300)]


class ValetudoMaps:
    """The reader of maps; see :class:`homebot.conventions.vacuum_map.MapReader`."""

    origin = "Valetudo"
    state_topic = "$state"
    status_topic = "StatusStateAttribute/status"
    map_topic = "MapData/map-data"

    def read(self, payload: bytes) -> VacuumMap:
        """Return the map in *payload*; as :func:`read_map`."""
        return read_map(payload)


def read_map(payload: bytes) -> VacuumMap:
    """Return the map in *payload*.

    Raises:
        WireError: It is no such map, or one that is too large.
    """
    text = _inflate(payload)
    if sum(map(text.count, (b":", b"[", b"{"))) > _MAX_VALUES:
        raise WireError(f"it has more than {_MAX_VALUES:,} keys, lists and tables")
    try:
        vacuum_map = _Map.model_validate_json(text)
    except ValidationError as exc:
        error = exc.errors(include_url=False, include_input=False)[0]
        raise WireError(f"it is no map of Valetudo: {'.'.join(map(str, error['loc']))} {error['msg']}") from exc
    layers = [layer for layer in vacuum_map.layers if layer.type == "segment"]
    if sum(len(layer.compressed_pixels) + len(layer.pixels) for layer in layers) > _MAX_NUMBERS:
        raise WireError(f"its pixels have more than {_MAX_NUMBERS:,} numbers")
    robots = [entity for entity in vacuum_map.entities if entity.type == "robot_position"]
    return VacuumMap(
        vendor_id=str(vacuum_map.meta_data.vendor_map_id)[:100],
        pixel=vacuum_map.pixel_size / 100,
        height=vacuum_map.size.y / 100,
        segments=tuple(map(_segment, layers)),
        robot=_pose(robots[-1], vacuum_map.size.y) if robots else None,
    )


def _inflate(payload: bytes) -> bytes:
    if len(payload) > _MAX_PAYLOAD:
        raise WireError(f"it has {len(payload):,} bytes; {_MAX_PAYLOAD:,} is the limit")
    if payload.startswith(b"{"):  # a file, or what another program has unpacked
        return payload
    try:
        inflater = zlib.decompressobj()
        text = inflater.decompress(payload, _MAX_JSON)
    except zlib.error as exc:
        raise WireError(f"it is not compressed by zlib: {exc}") from exc
    if not inflater.eof:
        raise WireError(f"it is cut off, or has more than {_MAX_JSON:,} bytes")
    return text


def _segment(layer: _Layer) -> VacuumSegment:
    """Return the segment of a layer, of version 2 with runs of pixels or 1 with one by one."""
    numbers, size = (layer.compressed_pixels, 3) if layer.compressed_pixels else (layer.pixels, 2)
    if len(numbers) % size or layer.meta_data.segment_id is None:
        raise WireError("a segment has no segmentId, or its pixels are no list of runs")
    lengths = numbers[2::3] if size > 2 else [1] * (len(numbers) // 2)
    rows: dict[int, set[int]] = {}
    for x, y, length in zip(numbers[::size], numbers[1::size], lengths, strict=True):
        rows.setdefault(y, set()).symmetric_difference_update((x, x + length))  # runs that touch become one
    ends = {y: tuple(sorted(row)) for y, row in rows.items()}
    return VacuumSegment(str(layer.meta_data.segment_id)[:40], text_of(layer.meta_data.name), ends)


def _pose(entity: _Entity, height: int) -> MapPose:
    if len(entity.points) != 2:
        raise WireError("the points of a position are not two numbers")
    x, y = entity.points
    yaw = math.remainder(math.radians(90 - entity.meta_data.angle), math.tau)
    return MapPose(x / 100, (height - y) / 100, yaw)
