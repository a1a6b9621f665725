"""The brightness of a region of a picture, whatever its encoding; hostile pictures are refused."""

from __future__ import annotations

from io import BytesIO

import pytest

from homebot.errors import UsageError
from homebot.features.identify.pictures import Region, brightness, compressed_brightness
from homebot.messages import Time
from homebot.messages.sensor_msgs import CompressedImage, Image
from homebot.messages.std_msgs import Header

HEADER = Header(stamp=Time(sec=0, nanosec=0), frame_id="camera")


def picture(
    data: bytes, encoding: str, width: int = 4, height: int = 2, step: int = 0, is_bigendian: int = 0
) -> object:
    return Image(
        header=HEADER,
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=step or len(data) // height,
        data=data,
    )


@pytest.mark.parametrize(
    ("data", "encoding", "region", "expected"),
    [
        (bytes([10] * 4 + [30] * 4), "mono8", (), 20),
        (bytes([10] * 4 + [30] * 4), "mono8", (1, 1, 2, 1), 30),
        (bytes([0, 0, 90] * 8), "rgb8", (), 30),
        (bytes([0, 0, 90] * 8), "bgr8", (0, 0, 1, 1), 30),
        (bytes([60, 60, 60, 255] * 8), "rgba8", (), 60),
        (bytes([7, 40] * 8), "mono16", (), 40),
        (bytes([0, 20] * 8), "uyvy", (), 20),
    ],
)
def test_the_mean_of_a_region_is_from_0_to_255(data: bytes, encoding: str, region: Region, expected: float) -> None:
    assert brightness(picture(data, encoding), region) == expected


def test_bytes_between_rows_do_not_count() -> None:
    assert brightness(picture(bytes([10, 10, 99, 10, 10, 99]), "mono8", width=2, step=3), ()) == 10


@pytest.mark.parametrize(
    ("image", "region", "problem"),
    [
        (picture(bytes(8), "bayer_rggb8"), (), "pictures in 'bayer_rggb8' cannot be read; known are mono8"),
        (picture(bytes(8), "mono8"), (3, 0, 2, 1), "the region 3,0,2,1 is not in pictures of 4x2 pixels"),
        (picture(bytes(8), "mono8"), (0, 0, 0, 1), "a region is x, y, width and height"),
        (picture(bytes(8), "mono8"), (1, 2), "a region is x, y, width and height"),
        (picture(bytes(6), "mono8"), (), "a picture of 4x2 has only 6 bytes"),
        (picture(b"", "mono8", width=0), (), "pictures of 0x2 pixels cannot be read"),
        (picture(b"", "mono8", width=2**31), (), "pixels cannot be read"),
    ],
)
def test_what_is_no_picture_is_refused(image: object, region: Region, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        brightness(image, region)


def jpeg(value: int, size: tuple[int, int] = (640, 480), kind: str = "JPEG") -> object:
    """A dark picture with a bright square at 200,120 of 80x80."""
    pillow = pytest.importorskip("PIL.Image")
    scene = pillow.new("RGB", size, (20, 20, 20))
    scene.paste((value, value, value), (200, 120, 280, 200))
    data = BytesIO()
    scene.save(data, kind)
    return CompressedImage(header=HEADER, format="jpeg", data=data.getvalue())


@pytest.mark.newest("camera")
@pytest.mark.parametrize("kind", ["JPEG", "PNG"])
def test_the_region_of_a_compressed_picture_is_read(kind: str) -> None:
    assert compressed_brightness(jpeg(200, kind=kind), (200, 120, 80, 80)) == pytest.approx(200, abs=6)
    assert compressed_brightness(jpeg(200, kind=kind), ()) == pytest.approx(20 + 180 * 6400 / 307200, abs=2)


@pytest.mark.parametrize("data", [b"", b"GIF89a", b"\xff\xd8\xff\xe0" + bytes(100)])
def test_what_is_no_compressed_picture_is_refused(data: bytes) -> None:
    with pytest.raises(UsageError, match="cannot be read"):
        compressed_brightness(CompressedImage(header=HEADER, format="jpeg", data=data), ())


def test_a_truncated_picture_is_refused() -> None:
    whole = jpeg(200).data  # type: ignore[attr-defined]
    with pytest.raises(UsageError, match="cannot be read"):
        compressed_brightness(CompressedImage(header=HEADER, format="jpeg", data=bytes(whole)[:500]), ())


def test_a_hundred_rows_and_columns_of_a_picture_are_read() -> None:
    """A picture of a megapixel costs as much as a small one."""
    row = bytes(255 * (x % 7 > 0) for x in range(640))  # every seventh column is black, and so is every fifth row
    image = picture(b"".join(row if y % 5 == 0 else b"\xff" * 640 for y in range(480)), "mono8", 640, 480)
    assert brightness(image, ()) == 0
