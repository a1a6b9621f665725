"""Maps of robot vacuums, in real samples and in hostile ones."""

import json
import math
import zlib
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from homebot.errors import WireError
from homebot.integrations.valetudo.formats import read_map
from homebot.places.outline import simplified
from homebot.places.polygon import Polygon

DATA = Path(__file__).parent / "data"
SAMPLES = sorted(DATA.glob("valetudo_*.zlib"))


def pixels_of(tables: Mapping[str, Any]) -> dict[tuple[int, int], str]:
    """Return the segment of each pixel, straight from the JSON."""
    found = {}
    for layer in tables["layers"]:
        if layer["type"] == "segment":
            runs = layer["compressedPixels"]
            for x, y, length in zip(runs[::3], runs[1::3], runs[2::3], strict=True):
                found.update({(x + step, y): layer["metaData"]["segmentId"] for step in range(length)})
    return found


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda one: one.stem)
def test_each_pixel_of_a_real_map_is_in_its_own_room(sample: Path) -> None:
    payload = sample.read_bytes()
    tables, found = json.loads(zlib.decompress(payload)), read_map(payload)
    size, pixel = tables["size"]["y"], tables["pixelSize"]
    for (column, row), segment in pixels_of(tables).items():
        for inside in (0, pixel - 1):
            at = found.segment_at((column * pixel + inside) / 100, (size - row * pixel - inside) / 100)
            assert at is not None
            assert (at[0].id, at[1]) == (segment, 0)


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda one: one.stem)
def test_rooms_whose_pixels_touch_over_a_quarter_of_a_metre_are_joined(sample: Path) -> None:
    payload = sample.read_bytes()
    tables, found = json.loads(zlib.decompress(payload)), read_map(payload)
    pixels, touching = pixels_of(tables), Counter[frozenset[str]]()
    for (x, y), segment in pixels.items():
        touching.update(frozenset((segment, pixels.get(beside, segment))) for beside in ((x + 1, y), (x, y + 1)))
    wanted = {pair for pair, count in touching.items() if len(pair) > 1 and count * tables["pixelSize"] >= 25}
    assert set(map(frozenset, found.joined())) == wanted != set()


@pytest.mark.parametrize(
    ("sample", "room", "centimetres"),
    [
        ("dreame_d9_named_segments", "5", 0),
        ("roborock_s8_unnamed", "17", 0),
        ("viomi_v6_robot_beside_segment", "10", 12),
    ],
)
def test_the_robot_is_in_a_room_or_marked_as_beside_the_nearest(sample: str, room: str, centimetres: int) -> None:
    found = read_map((DATA / f"valetudo_{sample}.zlib").read_bytes())
    assert found.robot is not None
    at = found.segment_at(found.robot.x, found.robot.y)
    assert at is not None
    assert (at[0].id, round(at[1] * 100)) == (room, centimetres)


def test_positions_are_metres_from_the_lower_left_and_angles_counter_clockwise() -> None:
    found = read_map((DATA / "valetudo_viomi_v6_robot_beside_segment.zlib").read_bytes())
    assert found.robot is not None
    assert found.robot[:2] == (19.98, 40 - 19.67)
    assert found.robot.yaw == pytest.approx(math.radians(90 - 178.46480572223663))
    assert [one.name for one in found.segments] == ["room1", "room2"]
    assert found.vendor_id == "1668175879"


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda one: one.stem)
def test_outlines_hold_the_pixels_and_become_polygons_of_few_corners(sample: Path) -> None:
    found = read_map(sample.read_bytes())
    for segment in found.segments:
        outer = Polygon(found.outline(segment))
        area = sum(sum(row[1::2]) - sum(row[::2]) for row in segment.rows.values()) * found.pixel**2
        assert area * 0.98 < outer.area < area * 1.1  # furniture is in it
        room = Polygon(simplified(found.outline(segment)))
        assert len(room.rings[0]) <= 30
        assert room.area == pytest.approx(outer.area, rel=0.15)


def test_version_1_says_the_same() -> None:
    payload = SAMPLES[0].read_bytes()
    found = read_map(payload)
    tables = json.loads(zlib.decompress(payload))
    pixels = pixels_of(tables)
    tables["metaData"]["version"] = 1
    for layer in tables["layers"]:
        layer["pixels"], layer["compressedPixels"] = [], []
        if layer["type"] == "segment":
            own = layer["metaData"]["segmentId"]
            layer["pixels"] = [number for at, one in pixels.items() if one == own for number in at]
            layer["metaData"]["segmentId"] = int(own)
    assert read_map(zlib.compress(json.dumps(tables).encode())) == found


def test_pixels_that_touch_at_a_corner_are_one_room() -> None:
    pixels = {(10, 10), (11, 11), (12, 10), (11, 9), (13, 11), (12, 12)}
    runs = [number for x, y in sorted(pixels) for row in range(10) for number in (x * 10, y * 10 + row, 10)]
    [segment] = (found := read_map(table(layers=[layer(*runs)]))).segments
    outer = Polygon(found.outline(segment))
    assert outer.area == pytest.approx(8 * 0.25, abs=0.1)  # with the two that they are around


def table(**changes: object) -> bytes:
    base: dict[str, object] = {
        "__class": "ValetudoMap",
        "metaData": {"version": 2},
        "size": {"x": 1000, "y": 1000},
        "pixelSize": 5,
        "layers": [],
        "entities": [],
    }
    return zlib.compress(json.dumps({**base, **changes}).encode())


def layer(*numbers: object, **meta: object) -> dict[str, object]:
    return {"type": "segment", "metaData": {"segmentId": "1", **meta}, "compressedPixels": list(numbers)}


POINT = {"__class": "PointMapEntity", "type": "robot_position", "metaData": {}}


@pytest.mark.parametrize(
    ("payload", "problem"),
    [
        (b"", "not compressed|cut off"),
        (zlib.compress(b" " * 2**25), "more than"),
        (zlib.compress(b'{"a":1,' * 100_001), "100,000 keys"),
        (table(layers=[[]] * 100_001), "100,000 keys, lists"),
        (table()[:-8], "cut off"),
        (zlib.compress(b'{"a":' + b"[" * 50_000 + b"]" * 50_000 + b"}"), "recursion"),
        (zlib.compress(b"[1]"), "no map"),
        (table(metaData={"version": 3}), "version Input should be 1 or 2"),
        (table(metaData=7), "metaData Input should be"),
        (table(pixelSize=0), "pixelSize Input should be greater"),
        (table(pixelSize=True), "pixelSize Input should be a valid integer"),
        (table(size={"y": 1e12}), r"size\.y"),
        (table(layers={}), "layers Input should be"),
        (table(layers=[{}] * 1000), "layers"),
        (table(layers=[layer(1, 2)]), "no list of runs"),
        (table(layers=[layer(1, 2, 1_000_000)]), "compressedPixels.2 Input should be less"),
        (table(layers=[layer(1, -2, 3)]), "compressedPixels.1 Input should be greater"),
        (table(layers=[layer("1", 2, 3)]), "compressedPixels.0 Input should be a valid integer"),
        (table(layers=[layer(*[1] * 900_000)]), "more than"),
        (table(layers=[layer(1, 2, 3, segmentId=None)]), "segmentId"),
        (table(entities=[{**POINT, "points": [1]}]), "two numbers"),
        (table(entities=[{**POINT, "points": [1, float("1e200")]}]), "points.1 Input should be less"),
    ],
)
def test_a_hostile_map_is_refused_with_the_reason(payload: bytes, problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        read_map(payload)


@pytest.mark.parametrize(
    "changes",
    [{"entities": [{**POINT, "points": ["a"] * 1000}]}, {"layers": [layer(*["a"] * 1000)]}],
    ids=lambda one: next(iter(one)),
)
def test_only_the_first_wrong_number_of_a_list_is_an_error(changes: dict[str, Any]) -> None:
    """Each error takes a kilobyte, and 22 kB unpack into three million numbers."""
    with pytest.raises(WireError) as refused:
        read_map(table(**changes))
    assert isinstance(refused.value.__cause__, ValidationError)
    assert refused.value.__cause__.error_count() == 1


def test_a_map_may_be_unpacked_already() -> None:
    payload = (DATA / "valetudo_dreame_d9_named_segments.zlib").read_bytes()
    assert read_map(zlib.decompress(payload)) == read_map(payload)


def test_a_map_without_a_robot_or_rooms_is_one() -> None:
    found = read_map(
        table(entities=[{"__class": "PathMapEntity", "type": "path", "points": [1, 2, 3], "metaData": {}}])
    )
    assert (found.robot, found.segments) == (None, ())
    assert found.segment_at(1, 1) is None
