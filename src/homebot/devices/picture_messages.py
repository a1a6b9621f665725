"""The newest still picture of a device, such as a camera."""

import binascii
from base64 import b64decode
from contextlib import suppress
from typing import Final

from homebot.errors import RefusedError
from homebot.messages.message import Message, ServiceAnswer, ServiceType

MAX_PICTURE_BYTES: Final = 2 * 1024 * 1024

_BEGINNINGS: Final = {b"\xff\xd8\xff": "image/jpeg", b"\x89PNG\r\n\x1a\n": "image/png", b"GIF8": "image/gif"}


class PictureRequest(Message):
    """Request for the newest picture of a device.

    Attributes:
        device: Its id or name; at a gateway, its key there.
        part: At a gateway, the id of the part there.
    """

    device: str
    part: str = ""


class PictureResponse(ServiceAnswer):
    """The picture, or why there is none.

    Attributes:
        media_type: Such as ``image/jpeg``.
        data: At most 2 MiB.
    """

    media_type: str = ""
    data: bytes = b""


GetPicture = ServiceType("homebot/srv/GetPicture", PictureRequest, PictureResponse)


def picture_of(source: str, data: bytes) -> PictureResponse:
    """Return the picture in *data*, plain or in base64, as browsers show it safely.

    Args:
        source: Its device or address, for the error.

    Raises:
        RefusedError: It is none, or too large.
    """
    if not (kind := _type_of(data)):
        with suppress(binascii.Error):
            data = b64decode(data, validate=True)
        kind = _type_of(data)
    if not kind or len(data) > MAX_PICTURE_BYTES:
        raise RefusedError(f"the picture of {source}", "it is no JPEG, PNG, GIF or WebP of at most 2 MiB")
    return PictureResponse(success=True, message="", media_type=kind, data=data)


def _type_of(data: bytes) -> str:
    if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
        return "image/webp"
    return next((kind for beginning, kind in _BEGINNINGS.items() if data.startswith(beginning)), "")
