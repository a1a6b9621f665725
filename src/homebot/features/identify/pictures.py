"""Mean brightness of a region of a picture. No I/O."""

from __future__ import annotations

from collections.abc import Mapping
from io import BytesIO
from types import MappingProxyType
from typing import Any, Final, NamedTuple, TypeAlias

from homebot.errors import UsageError
from homebot.plugins import check_extra

Region: TypeAlias = tuple[int, ...]
"""x, y, width and height in pixels; empty for the whole picture."""

_SAMPLES: Final = 100
"""Rows, and pixels of a row, that are read at most: a mean needs no more, and a large picture costs no more."""

_MAX_PIXELS: Final = 50_000_000
_FORMATS: Final = ("JPEG", "PNG")


class _Encoding(NamedTuple):
    """Bytes of a pixel, the ones that count, and whether each is the lower or upper byte of two."""

    size: int
    channels: tuple[int, ...]
    is_wide: bool = False


_ENCODINGS: Final[Mapping[str, _Encoding]] = MappingProxyType(
    dict.fromkeys(("mono8", "8UC1"), _Encoding(1, (0,)))
    | dict.fromkeys(("rgb8", "bgr8", "8UC3"), _Encoding(3, (0, 1, 2)))
    | dict.fromkeys(("rgba8", "bgra8", "8UC4"), _Encoding(4, (0, 1, 2)))
    | dict.fromkeys(("mono16", "16UC1"), _Encoding(2, (1,), is_wide=True))
    | dict.fromkeys(("yuv422", "uyvy"), _Encoding(2, (1,)))
    | dict.fromkeys(("yuv422_yuy2", "yuyv"), _Encoding(2, (0,)))
)


def brightness(image: Any, region: Region) -> float:
    """Return the mean of a ``sensor_msgs/Image``, from 0 to 255.

    Raises:
        UsageError: Its encoding is unknown, the region is not in it, or it has less data than it says.
    """
    encoding = _ENCODINGS.get(image.encoding)
    if encoding is None:
        known = ", ".join(_ENCODINGS)
        raise UsageError(f"pictures in {image.encoding[:40]!r} cannot be read; known are {known}")
    x, y, width, height = _check(region, image.width, image.height)
    size, step, data = encoding.size, max(image.step, image.width * encoding.size), bytes(image.data)
    if len(data) < step * (image.height - 1) + image.width * size:
        raise UsageError(f"a picture of {image.width}x{image.height} has only {len(data)} bytes")
    stride, total, count = size * -(-width // _SAMPLES), 0, 0
    for row in range(y, y + height, -(-height // _SAMPLES)):
        start = row * step + x * size
        for channel in encoding.channels:
            offset = 0 if encoding.is_wide and image.is_bigendian else channel
            values = data[start + offset : start + width * size : stride]
            total, count = total + sum(values), count + len(values)
    return total / count


def compressed_brightness(image: Any, region: Region) -> float:
    """Return the mean of a ``sensor_msgs/CompressedImage``, from 0 to 255.

    Raises:
        UsageError: Pillow is not installed, the picture cannot be read, or the region is not in it.
    """
    check_extra("a compressed picture", "camera", "PIL")
    from PIL import Image, ImageStat  # noqa: PLC0415 - an extra

    try:
        with Image.open(BytesIO(bytes(image.data)), formats=_FORMATS) as picture:
            x, y, width, height = _check(region, *picture.size)
            across = picture.width
            picture.draft("L", (across * _SAMPLES // width, picture.height * _SAMPLES // height))
            scale = picture.width / across
            box = (
                x * scale,
                y * scale,
                max((x + width) * scale, x * scale + 1),
                max((y + height) * scale, y * scale + 1),
            )
            part = picture.convert("L").crop(tuple(map(int, box)))  # type: ignore[arg-type]  # four
            return float(ImageStat.Stat(part).mean[0])
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as exc:
        raise UsageError(f"a picture of {len(image.data)} bytes cannot be read: {exc}") from exc


def _check(region: Region, width: int, height: int) -> tuple[int, int, int, int]:
    if not 0 < width * height <= _MAX_PIXELS:
        raise UsageError(f"pictures of {width}x{height} pixels cannot be read")
    if not region:
        return 0, 0, width, height
    if len(region) != 4 or 0 in region[2:]:
        raise UsageError(f"a region is x, y, width and height in pixels, not {', '.join(map(str, region))}")
    x, y, wide, high = region
    if x + wide > width or y + high > height:
        raise UsageError(f"the region {x},{y},{wide},{high} is not in pictures of {width}x{height} pixels")
    return x, y, wide, high
