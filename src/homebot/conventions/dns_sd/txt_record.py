"""The TXT record of a service. Pure.

Source: RFC 6763 (DNS-Based Service Discovery), sections 6.1 to 6.5.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["TxtRecord", "read_txt"]

MAX_KEYS = 64
"""Keys that are read. Devices have up to twenty."""

_PRINTABLE = range(0x20, 0x7F)


@dataclass(frozen=True, slots=True)
class TxtRecord:
    r"""The content of a TXT record.

    Attributes:
        properties: Values by key in lower case; of a key that occurs twice the first value. A value that is not UTF-8
            has its other bytes written as ``\xff``; a key without a value has an empty one.
        problem: The rule that the record breaks, as text; empty for none. Valid keys are read all the same.
    """

    properties: Mapping[str, str] = field(default_factory=dict)
    problem: str = ""


def read_txt(data: bytes) -> TxtRecord:
    """Return the content of a TXT record.

    Args:
        data: The record: strings of up to 255 bytes, each after its length; as RFC 6763 says, one is passed over if
            it begins with ``=``, or if its key is not printable ASCII.
    """
    properties: dict[str, str] = {}
    problem = ""
    position = 0
    while position < len(data):
        end = position + 1 + data[position]
        if end > len(data):
            problem = f"its TXT record ends within a string of {data[position]} bytes"
        key, _, value = data[position + 1 : end].partition(b"=")
        position = end
        name = key.decode("ascii", "replace").lower()
        if not key or any(byte not in _PRINTABLE for byte in key) or name in properties:
            continue
        if len(properties) == MAX_KEYS:
            problem = f"its TXT record has more than {MAX_KEYS} keys"
            break
        properties[name] = value.decode("utf-8", "backslashreplace")
    return TxtRecord(properties, problem)
