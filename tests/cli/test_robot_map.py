"""Maps of robots: golden cells of each grey, images, mistakes, and the rooms around points."""

import json
import math
import time
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import pytest
from PIL import Image
from tests.turns import slowness

from homebot.cli.robot_map import MapSettings, RobotMap, cell_table, read_map
from homebot.errors import ConfigError, UsageError
from homebot.places.polygon import Polygon
from homebot.places.rigid import MapPose

TABLES = json.loads((Path(__file__).parent / "data" / "map_server_tables.json").read_text())["tables"]

YAML = """\
# a map
image: "house map.png"
mode: trinary
resolution: 0.050000
origin: [-1.0, -2, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196   # as savers write it
"""


@pytest.mark.parametrize("table", TABLES, ids=lambda one: f"{one['mode']}-{one['negate']}-{one['free_thresh']}")
def test_the_cell_of_each_grey_is_that_of_map_server(table: dict[str, object]) -> None:
    fields = MapSettings.model_fields.keys() & table.keys()
    stated = {name: table[name] for name in fields} | {"image": "", "resolution": 0.05, "origin": (0, 0, 0)}

    cells = cell_table(MapSettings.model_validate(stated))

    assert [cell if cell < 128 else cell - 256 for cell in cells] == table["cells"]


def written(folder: Path, text: str = YAML, image: Image.Image | None = None) -> str:
    (image or Image.new("L", (2, 2), 254)).save(folder / "house map.png")
    (folder / "map.yaml").write_text(text)
    return str(folder / "map.yaml")


@pytest.mark.parametrize("text", [YAML, YAML.replace("[-1.0, -2, 0]", "\n- -1.0\n- -2\n- 0")], ids=["list", "lines"])
def test_a_map_is_read_with_its_first_row_uppermost(text: str, tmp_path: Path) -> None:
    image = Image.new("L", (3, 2), 254)
    image.putpixel((0, 0), 0)
    image.putpixel((1, 0), 205)

    found, warning = read_map(written(tmp_path, text, image))

    assert (found.resolution, found.origin, warning) == (0.05, (-1.0, -2.0, 0.0), "")
    assert found.cells.tobytes() == bytes([100, 255, 0, 0, 0, 0])


def test_a_threshold_that_frees_what_is_unknown_is_warned_of(tmp_path: Path) -> None:
    assert "makes the grey 205" in read_map(written(tmp_path, YAML.replace("0.196", "0.25")))[1]


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("negate: 0\n", "", "negate"),
        ("negate: 0", "negate: 2", "negate"),
        ("0.050000", "-1", "resolution"),
        ("0.050000", ".nan", "resolution"),
        ("0.050000", "1.0e-309", "resolution"),
        ("-1.0", "1.0e+308", "origin"),
        ("[-1.0, -2, 0]", "[-1.0, -2]", "origin"),
        ("trinary", "other", "mode"),
        ("0.196", "0.7", "free_thresh"),
        ("negate: 0", "negate:\n  deep: 0", "negate"),
    ],
)
def test_a_mistake_in_the_settings_is_named_by_its_key(old: str, new: str, key: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError) as caught:
        read_map(written(tmp_path, YAML.replace(old, new)))
    assert caught.value.key.split(".")[0] == key


@pytest.mark.parametrize(
    ("text", "content", "reason"),
    [
        ("image: [", b"", "map.yaml cannot be read"),
        (YAML, b"P5 5000 4000 255\n", "16,000,000 is the limit"),
        (YAML, b"P5 50000 50000 255\n", "pixels"),  # a few bytes can say that there are billions
        (YAML, b"P5 20 40 255\n", "house map.png cannot be read"),
        (YAML, b"\x89PNG\r\n\x1a\n", "house map.png cannot be read"),
        (YAML, b"GIF89a", "house map.png cannot be read"),
    ],
)
def test_a_damaged_or_huge_map_is_refused(text: str, content: bytes, reason: str, tmp_path: Path) -> None:
    file = written(tmp_path, text)
    (tmp_path / "house map.png").write_bytes(content)
    with pytest.raises(UsageError, match=reason):
        read_map(file)


@pytest.mark.newest("maps")
@pytest.mark.parametrize(
    ("image", "cells"),
    [
        (Image.new("RGB", (1, 1), (254, 255, 253)), [0]),
        (Image.new("RGBA", (1, 1), (254, 254, 254, 200)), [255]),
        (Image.new("LA", (1, 1), (0, 255)), [100]),
        (Image.new("1", (1, 1), 1), [0]),
        (Image.new("I;16", (1, 1), 205 * 257), [255]),
        (Image.new("I;16", (1, 1), 254 * 257), [0]),
    ],
    ids=["colours", "not opaque", "opaque", "two", "sixteen bits", "sixteen bits free"],
)
def test_the_kinds_of_png_are_read(image: Image.Image, cells: Sequence[int], tmp_path: Path) -> None:
    assert [*read_map(written(tmp_path, image=image))[0].cells.tobytes()] == cells


WALL = {0, 40, 79}


def two_rooms(yaw: float = 0.0) -> RobotMap:
    """Two rooms of about 4 m by 5 m with a wall between them, in which a door is 0.8 m wide, and furniture in one."""
    cells = Image.new("L", (80, 50), 0)
    for column in range(80):
        for row in range(50):
            is_door = column == 40 and 2 <= row < 10
            is_wall = (column in WALL and not is_door) or row in {0, 49} or (10 <= column < 15 and 20 <= row < 25)
            cells.putpixel((column, row), 100 if is_wall else 0)
    return RobotMap(cells, 0.1, MapPose(2.0, 1.0, yaw))


def turned(x: float, y: float, yaw: float) -> tuple[float, float]:
    return 2 + x * math.cos(yaw) - y * math.sin(yaw), 1 + x * math.sin(yaw) + y * math.cos(yaw)


@pytest.mark.parametrize("yaw", [0.0, math.pi / 2, math.pi])
def test_a_room_is_the_free_area_around_a_point_up_to_walls_and_doors(yaw: float) -> None:
    door = turned(4.05, 4.0, yaw), turned(4.05, 4.8, yaw)
    points = {"Hall": turned(1, 1, yaw), "Kitchen": turned(6, 1, yaw)}

    hall, kitchen = two_rooms(yaw).rooms(points, [door])

    for room, (left, right) in ((hall, (0.1, 4.0)), (kitchen, (4.1, 7.9))):
        area = Polygon(room.polygons[0][0])
        corners = [turned(x, y, yaw) for x in (left, right) for y in (0.1, 4.9)]
        assert area.area == pytest.approx((right - left) * 4.8, abs=0.2)
        assert all(area.border_distance(*corner) < 0.15 for corner in corners)


@pytest.mark.parametrize(
    ("points", "problem"),
    [
        ({"Hall": (3.0, 2.0), "Kitchen": (8.0, 2.0)}, "Hall and Kitchen are one free area of the map"),
        ({"Hall": (3.2, 3.7)}, "the point 3.2,3.7 of Hall is not free"),
        ({"Hall": (-3.0, 2.0)}, "the point -3,2 of Hall is not free"),
        ({f"Room {one}": (3.0, 2.0) for one in range(151)}, "150 is the limit"),
    ],
)
def test_a_point_that_gives_no_room_is_refused(points: Mapping[str, tuple[float, float]], problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        list(two_rooms().rooms(points, []))


def test_a_short_file_does_not_grow_by_aliases(tmp_path: Path) -> None:
    file = tmp_path / "house.yaml"
    levels = (f"{name}: &{name} [{', '.join(['*' + before] * 9)}]" for before, name in pairwise("abcdefghijkl"))
    file.write_text("\n".join(("a: &a [x]", *levels, "image: *l", "resolution: 0.05")))
    with pytest.raises(UsageError, match="write the value itself"):
        read_map(str(file))


def cluttered(share: float) -> RobotMap:
    """A hall of 100 m x 100 m in which a *share* of the cells is occupied, as by legs of chairs."""
    row = bytes(100 if column * 1237 % 2000 < share * 2000 else 0 for column in range(2000))
    shifts = [line * line * 911 % 2000 for line in range(2000)]
    cells = Image.frombytes("L", (2000, 2000), b"".join(row[shift:] + row[:shift] for shift in shifts))
    cells.paste(0, (900, 900, 1100, 1100))
    return RobotMap(cells, 0.05, MapPose(0.0, 0.0, 0.0))


def test_a_room_of_four_million_cells_takes_seconds() -> None:
    """Cell by cell it took minutes, on the smaller computers of robots."""
    began = time.process_time()
    (hall,) = cluttered(0.04).rooms({"Hall": (50.0, 50.0)}, [])
    assert time.process_time() - began < 15 * slowness()
    assert Polygon(hall.polygons[0][0]).area == pytest.approx(10_000, rel=0.01)


def test_noise_is_no_room() -> None:
    """Millions of its edges would fill the memory."""
    with pytest.raises(UsageError, match="a free area of the map has over 300,000 strips; filter its noise first"):
        list(cluttered(0.2).rooms({"Hall": (50.0, 50.0)}, []))
