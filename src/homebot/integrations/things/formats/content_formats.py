"""Content formats of CoAP: their numbers, and documents in JSON, CBOR, SenML and plain text. Pure.

Source: IANA, "CoAP Content-Formats"; RFC 8428 (SenML), sections 4, 5 and 6.
"""

import json
import math
import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.conventions.cbor import decode_cbor, encode_cbor
from homebot.conventions.coap.link_format import LINK_FORMAT
from homebot.conventions.payload import parse_json, shown
from homebot.errors import WireError
from homebot.integrations.things.formats.payload import PayloadFormat, basic_formats, media_type

TD_FORMAT: Final = 432

_TYPES: Mapping[int, str] = {
    0: "text/plain",
    LINK_FORMAT: "application/link-format",
    42: "application/octet-stream",
    50: "application/json",
    60: "application/cbor",
    110: "application/senml+json",
    112: "application/senml+cbor",
    TD_FORMAT: "application/td+json",
}
_NUMBERS = {name: number for number, name in _TYPES.items()}
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
    kind = media_type(content_type)
    if columns := _SENML.get(kind):
        return columns
    return _PLAIN_CBOR if _CBOR.fullmatch(kind) else basic_formats(content_type)


_LABELS: Mapping[int, str] = MappingProxyType(
    {-2: "bn", -4: "bu", -5: "bv", 0: "n", 1: "u", 2: "v", 3: "vs", 4: "vb", 5: "s", 8: "vd"}
)
"""The labels of records in CBOR, as far as they count here; RFC 8428, table 4."""

_LABEL_NUMBERS = {name: number for number, name in _LABELS.items()}
_MAX_RECORDS = 1000
_VALUES = ("vb", "vs", "vd", "s")
"""The labels of values other than numbers."""


def read_senml(pack: object) -> object:
    """Return the document that a SenML pack, as parsed JSON or CBOR, is: the value of its one name, or values by name.

    Of several records of a name the last counts. Base names and base values are added.

    Raises:
        WireError: It is no pack: a list of records, each with a value.
    """
    if not isinstance(pack, list) or not 0 < len(pack) <= _MAX_RECORDS:
        raise WireError(f"a SenML pack is a list of 1 to {_MAX_RECORDS} records, not {shown(pack)}")
    base_name, base_value = "", 0.0
    values: dict[str, object] = {}
    for given in pack:
        if not isinstance(given, dict):
            raise WireError(f"a SenML record is an object, not {shown(given)}")
        record = {_LABELS.get(key, "") if isinstance(key, int) else key: value for key, value in given.items()}
        base_name = _text(record.get("bn"), base_name)
        base_value = _number(record.get("bv"), base_value)
        name = base_name + _text(record.get("n"), "")
        if "v" in record:
            values[name] = base_value + _number(record["v"], 0.0)
        elif (label := next((label_found for label_found in _VALUES if label_found in record), None)) is not None:
            values[name] = record[label]
    if not values:
        raise WireError("a SenML pack has no value")
    return next(iter(values.values())) if len(values) == 1 else values


def _text(value: object, default: str) -> str:
    if value is None:
        return default
    if not isinstance(value, str) or len(value) > 1000:
        raise WireError(f"a SenML name is a text, not {shown(value)}")
    return value


def _number(value: object, default: float) -> float:
    if value is None:
        return default
    if isinstance(value, bool) or not isinstance(value, (int, float)) or abs(value) > 1e300 or not math.isfinite(value):
        raise WireError(f"a SenML value is a number, not {shown(value)}")
    return float(value)


def _record(document: object) -> dict[str, object]:
    match document:
        case bool():
            return {"vb": document}
        case int() | float():
            return {"v": document}
        case str():
            return {"vs": document}
        case _:
            return {"vs": json.dumps(document, ensure_ascii=False)}


def _as_senml_json(document: object) -> bytes:
    return json.dumps([_record(document)], ensure_ascii=False).encode(errors="replace")


def _as_senml_cbor(document: object) -> bytes:
    return encode_cbor([{_LABEL_NUMBERS[label]: value for label, value in _record(document).items()}])


_PLAIN_CBOR = PayloadFormat(decode_cbor, encode_cbor)
_SENML: Mapping[str, PayloadFormat] = {
    "application/senml+json": PayloadFormat(lambda payload: read_senml(parse_json(payload)), _as_senml_json),
    "application/senml+cbor": PayloadFormat(lambda payload: read_senml(decode_cbor(payload)), _as_senml_cbor),
}
