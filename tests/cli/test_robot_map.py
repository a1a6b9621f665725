"""Files of map_server: golden cells of each grey, images, and mistakes."""

from __future__ import annotations

import json
import zlib
from pathlib import Path
from random import Random
from struct import pack

import pytest

from homebot.errors import ConfigError, UsageError
from homebot.places.grey_image import GreyImage, read_grey_image
from homebot.places.map_file import MapSettings, cell_table, make_grid, read_map_settings

TABLES = json.loads((Path(__file__).parent / "data" / "map_server_tables.json").read_text())["tables"]

YAML = """\
# a map
image: "house map.pgm"
mode: trinary
resolution: 0.050000
origin: [-1.0, -2, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196   # as savers write it
"""


@pytest.mark.parametrize("table", TABLES, ids=lambda one: f"{one['mode']}-{one['negate']}-{one['free_thresh']}")
def test_the_cell_of_each_grey_is_that_of_map_server(table: dict[str, object]) -> None:
    settings = MapSettings(
        "",
        0.05,
        (0, 0, 0),
        float(str(table["occupied_thresh"])),
        float(str(table["free_thresh"])),
        bool(table["negate"]),
        str(table["mode"]),
    )

    assert [cell if cell < 128 else cell - 256 for cell in cell_table(settings)] == table["cells"]


@pytest.mark.parametrize("text", [YAML, YAML.replace("[-1.0, -2, 0]", "\n- -1.0\n- -2\n- 0")], ids=["list", "lines"])
def test_the_settings_of_a_map_are_read(text: str) -> None:
    settings = read_map_settings(text, "map.yaml")

    assert settings == MapSettings("house map.pgm", 0.05, (-1.0, -2.0, 0.0), 0.65, 0.196)
    assert not settings.warning
    assert "makes the grey 205" in settings._replace(free=0.25).warning


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("negate: 0\n", "", "negate"),
        ("negate: 0", "negate: 2", "negate"),
        ("0.050000", "-1", "resolution"),
        ("0.050000", "nan", "resolution"),
        ("[-1.0, -2, 0]", "[-1.0, -2]", "origin"),
        ("trinary", "other", "mode"),
        ("0.196", "0.7", "free_thresh"),
        ("negate: 0", "negate:\n  deep: 0", "negate"),
    ],
)
def test_a_mistake_in_the_settings_is_named_by_its_key(old: str, new: str, key: str) -> None:
    with pytest.raises(ConfigError) as caught:
        read_map_settings(YAML.replace(old, new), "map.yaml")
    assert caught.value.key == key


def test_the_first_row_of_an_image_is_the_uppermost_of_the_map() -> None:
    settings = read_map_settings(YAML, "map.yaml")
    image = GreyImage(2, 3, bytes([0, 254, 254, 254, 254, 205]), bytes([255, 255, 255, 0, 255, 255]))
    grid = make_grid(settings, image)

    assert grid.cells == bytes([0, 255, 0, 255, 100, 0])
    assert grid.cell_at(-0.99, -1.87) == 100
    assert grid.cell_at(-0.94, -1.99) == 255
    assert grid.cell_at(-1.01, -1.99) == 255
    turned = grid._replace(origin=(0.0, 0.0, 1.5707963267948966))
    assert turned.cell_at(-0.12, 0.02) == 100


def test_the_formats_of_pgm_are_read() -> None:
    for content in (
        b"P2\n# made by hand\n2 2\n255\n0 128\n# more\n254 255\n",
        b"P5 2 2 255\n\x00\x80\xfe\xff",
        b"P5\n2 2\n# 16 bit\n65535\n\x00\x00\x80\x80\xfe\xfe\xff\xff",
    ):
        assert read_grey_image(content) == GreyImage(2, 2, bytes([0, 128, 254, 255]))
    assert read_grey_image(b"P2 2 1 100\n100 50").grey == bytes([255, 127])


def png(kind: int, depth: int, width: int, rows: list[bytes], **chunks: bytes) -> bytes:
    head = pack(">IIBBBBB", width, len(rows), depth, kind, 0, 0, chunks.pop("interlaced", b"\0")[0])
    parts = {"IHDR": head, **chunks, "IDAT": zlib.compress(b"".join(rows)), "IEND": b""}
    body = b"".join(
        pack(">I", len(data)) + name.encode() + data + pack(">I", zlib.crc32(name.encode() + data))
        for name, data in parts.items()
    )
    return b"\x89PNG\r\n\x1a\n" + body


def filtered(rows: list[bytes], kinds: list[int], step: int) -> list[bytes]:
    """Return rows with a filter of PNG each, as an encoder writes them."""
    found, above = [], bytes(len(rows[0]))
    for row, kind in zip(rows, kinds, strict=True):
        out = bytearray()
        for index, value in enumerate(row):
            left, corner = (row[index - step], above[index - step]) if index >= step else (0, 0)
            up = above[index]
            estimate = left + up - corner
            paeth = min((abs(estimate - one), number, one) for number, one in enumerate((left, up, corner)))[2]
            out.append((value - (0, left, up, (left + up) // 2, paeth)[kind]) & 255)
        found.append(bytes([kind, *out]))
        above = row
    return found


def test_each_filter_of_png_is_taken_out() -> None:
    random = Random(3)  # noqa: S311 - a test that repeats
    for step, kind in ((1, 0), (2, 4), (3, 2), (4, 6)):
        rows = [random.randbytes(9 * step) for _ in range(10)]
        image = read_grey_image(png(kind, 8, 9, filtered(rows, [0, 1, 2, 3, 4] * 2, step)))
        colours = max(1, step - step % 2 if step < 3 else 3)
        colours = 1 if step < 3 else 3
        pixels = [row[at : at + step] for row in rows for at in range(0, 9 * step, step)]
        assert image.grey == bytes(sum(pixel[:colours]) // colours for pixel in pixels)
        assert image.alpha == (bytes(pixel[-1] for pixel in pixels) if step in {2, 4} else b"")


def test_palettes_and_few_bits_are_read() -> None:
    palette = bytes([0, 0, 0, 254, 254, 254, 205, 205, 205])
    rows = [bytes([0, 0b00011000])]
    assert read_grey_image(png(3, 2, 3, rows, PLTE=palette)).grey == bytes([0, 254, 205])
    assert read_grey_image(png(3, 2, 3, rows, PLTE=palette, tRNS=b"\0")).alpha == bytes([0, 255, 255])
    assert read_grey_image(png(0, 1, 4, [bytes([0, 0b10100000])])).grey == bytes([255, 0, 255, 0])
    assert read_grey_image(png(0, 16, 1, [bytes([0, 0x80, 0x01])])).grey == bytes([0x80])


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"GIF89a", "is no image that is known"),
        (b"P5 9000 9000 255\n", "16,000,000 is the limit"),
        (b"P5 2 2 255\n\x00", "is cut"),
        (png(0, 8, 60_000, [b""] * 60_000), "16,000,000 is the limit"),
        (png(0, 8, 4, [bytes(3)]), "is cut"),
        (png(0, 8, 4, [bytes(5)], interlaced=b"\1"), "interlaced"),
        (png(0, 8, 4, [bytes([9, 0, 0, 0, 0])]), "unknown filter"),
        (png(0, 8, 4, [bytes(5)])[:40], "damaged"),
    ],
)
def test_a_damaged_or_huge_image_is_refused(content: bytes, reason: str) -> None:
    with pytest.raises(UsageError, match=reason):
        read_grey_image(content)
