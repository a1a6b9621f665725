"""Service types and TXT records of DNS-SD. Pure.

Source: RFC 6763, sections 4.1.2, 6.1 to 6.5, 7 and 9; RFC 6335, section 5.1 for the characters of a service name.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = [
    "ENUMERATION",
    "TxtRecord",
    "base_type",
    "full_type",
    "instance_label",
    "is_service_type",
    "read_txt",
]

ENUMERATION = "_services._dns-sd._udp.local."
"""The name that every service type on the network is listed under (RFC 6763, section 9)."""

_TYPE = re.compile(r"(?:_[^.]{1,63}\._sub\.)?_[a-z0-9](?:[a-z0-9-]{0,13}[a-z0-9])?\._(?:tcp|udp)\.local\.")


def full_type(text: str) -> str:
    """Return a service type in full: of ``_shelly._tcp`` that is ``_shelly._tcp.local.``, with the dot."""
    name = text.strip().rstrip(".").lower()
    return f"{name}." if name.endswith(".local") else f"{name}.local."


def is_service_type(full: str) -> bool:
    """Return whether *full* is a service type in full, perhaps with a subtype."""
    return full == ENUMERATION or _TYPE.fullmatch(full) is not None


def base_type(full: str) -> str:
    """Return a type without its subtype: ``_directory._sub._wot._tcp.local.`` becomes ``_wot._tcp.local.``."""
    return full.rpartition("._sub.")[2]


def instance_label(name: str, full: str) -> str:
    """Return the name for people in the full name of a service of the type *full*: its first label."""
    base = base_type(full)
    return name[: -len(base) - 1] if name.lower().endswith(f".{base}") else name


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
