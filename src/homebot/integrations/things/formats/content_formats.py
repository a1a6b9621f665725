"""Content formats of CoAP: their numbers, and documents in JSON, CBOR and plain text. Pure.

Source: IANA, "CoAP Content-Formats".
"""

import re
from collections.abc import Mapping
from typing import Final

from homebot.conventions.cbor import decode_cbor, encode_cbor
from homebot.conventions.coap.link_format import LINK_FORMAT
from homebot.integrations.things.formats.payload import PayloadFormat, basic_formats, media_type

TD_FORMAT: Final = 432

_TYPES: Mapping[int, str] = {
    0: "text/plain",
    LINK_FORMAT: "application/link-format",
    42: "application/octet-stream",
    50: "application/json",
    60: "application/cbor",
    TD_FORMAT: "application/td+json",
}
_NUMBERS = {name: number for number, name in _TYPES.items()}
_PLAIN_CBOR = PayloadFormat(decode_cbor, encode_cbor)
_CBOR = re.compile(r"application/([a-z0-9.+-]+\+)?cbor")
_UNKNOWN = "application/x-coap-format-"


def content_type_of(number: int | None) -> str:
    """Return the content type that *number* stands for; one of its own for a number that is not known."""
    return "" if number is None else _TYPES.get(number, f"{_UNKNOWN}{number}")


def content_format_of(content_type: str) -> int | None:
    """Return the number of a content type; None if it is not known."""
    kind = media_type(content_type)
    if kind.startswith(_UNKNOWN) and kind.removeprefix(_UNKNOWN).isdecimal():
        return int(kind.removeprefix(_UNKNOWN)[:5])
    return _NUMBERS.get(kind)


def coap_formats(content_type: str) -> PayloadFormat | None:
    """Return the format that *content_type* names; None if it is not understood."""
    return _PLAIN_CBOR if _CBOR.fullmatch(media_type(content_type)) else basic_formats(content_type)
