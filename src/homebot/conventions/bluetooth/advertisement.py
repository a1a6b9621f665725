"""One received Bluetooth advertisement. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Advertisement", "full_uuid"]

_BASE = "-0000-1000-8000-00805f9b34fb"
_SHORT = 4
_MEDIUM = 8


@dataclass(frozen=True, slots=True)
class Advertisement:
    """The data of an advertisement, and its signal strength.

    Attributes:
        address: Its address, upper case with colons: ``A4:C1:38:0A:0B:0C``; on macOS a UUID.
        rssi: Received signal strength, in dBm.
        name: The local name; empty for none.
        tx_power: The advertised transmit power, in dBm.
        service_data: Bytes by service UUID, full and lower case.
        manufacturer_data: Bytes by company identifier.
        service_uuids: The advertised services, full and lower case.
    """

    address: str
    rssi: int
    name: str = ""
    tx_power: int | None = None
    service_data: Mapping[str, bytes] = field(default_factory=dict)
    manufacturer_data: Mapping[int, bytes] = field(default_factory=dict)
    service_uuids: tuple[str, ...] = ()

    def says_the_same(self, other: Advertisement) -> bool:
        """Return whether it equals *other* in all but the signal."""
        return (
            self.service_data == other.service_data
            and self.manufacturer_data == other.manufacturer_data
            and self.name == other.name
            and self.service_uuids == other.service_uuids
        )


def full_uuid(text: str) -> str:
    """Return a UUID of 16, 32 or 128 bits, as hexadecimal digits, in full and lower case (Core 6.0, Vol 3, B 2.5.1).

    Raises:
        ValueError: It is none.
    """
    digits = text.strip().lower().removeprefix("0x").replace("-", "")
    if any(one not in "0123456789abcdef" for one in digits) or len(digits) not in {_SHORT, _MEDIUM, 32}:
        raise ValueError(f"{text!r} is not a UUID; write 4, 8 or 32 hexadecimal digits")
    if len(digits) <= _MEDIUM:
        return f"{digits:0>8}{_BASE}"
    return "-".join((digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:]))
