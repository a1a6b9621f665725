"""Bluetooth advertisements, and the interface of their parsers, a plug-in group (``homebot.ble_parsers``). Pure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from homebot.conventions.description import AutoExpiry
from homebot.conventions.units import sensor_type
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue

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
        receiver: The address of the proxy that heard it; empty for the adapter of this computer.
    """

    address: str
    rssi: int
    name: str = ""
    tx_power: int | None = None
    service_data: Mapping[str, bytes] = field(default_factory=dict)
    manufacturer_data: Mapping[int, bytes] = field(default_factory=dict)
    service_uuids: tuple[str, ...] = ()
    receiver: str = ""

    def says_the_same(self, other: Advertisement) -> bool:
        """Return whether it equals *other* in all but the signal and the receiver."""
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
    if any(digit not in "0123456789abcdef" for digit in digits) or len(digits) not in {_SHORT, _MEDIUM, 32}:
        raise ValueError(f"{text!r} is not a UUID; write 4, 8 or 32 hexadecimal digits")
    if len(digits) <= _MEDIUM:
        return f"{digits:0>8}{_BASE}"
    return "-".join((digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:]))


def sensor_part(
    part_id: str, capability: str, *, unit: str = "", service_type: str = "", tag: str = "", category: Category = ""
) -> Part:
    """Return a part with one capability that is only reported; its type is that of a sensor by default."""
    return Part(
        id=part_id,
        service_type=service_type or sensor_type(capability),
        tag=tag,
        category=category,
        capabilities=(Capability(name=capability, unit=unit),),
    )


class BroadcastValue(NamedTuple):
    """One value that a part reported."""

    part: str
    capability: str
    value: PlainValue


@dataclass(frozen=True, slots=True)
class Broadcast:
    """The meaning of an advertisement, with all that is known of its device.

    Attributes:
        key: The key of the device if it is not its address, which beacons may change.
        name: Its name by its model, or the one that it advertises; empty for none.
        values: New values; empty if the advertisement repeats an earlier one.
        expiries: Values that end by themselves, by part.
        identifiers: Identifiers that other gateways may see too, beside its address.
        rssi_at_1m: Signal strength at one metre, in dBm, if it states that.
        silence: Seconds for which it may be silent at least; 0 for no particular time.
        problem: Why it cannot be read, as text; empty if it can.
    """

    key: str = ""
    name: str = ""
    parts: tuple[Part, ...] = ()
    values: tuple[BroadcastValue, ...] = ()
    expiries: Mapping[str, tuple[AutoExpiry, ...]] = field(default_factory=dict)
    metadata: Mapping[str, str] = field(default_factory=dict)
    identifiers: tuple[str, ...] = ()
    rssi_at_1m: float | None = None
    silence: float = 0.0
    problem: str = ""


class BroadcastParser(ABC):
    """Reads the advertisements of one kind of device, and keeps state for each device.

    Args:
        bind_keys: The keys of devices that encrypt, by address.
    """

    def __init__(self, bind_keys: Mapping[str, bytes]) -> None:
        self.bind_keys = bind_keys

    @abstractmethod
    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether an advertisement is of this kind; must be fast."""

    @abstractmethod
    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return the meaning of an advertisement at *now* seconds; None if it is of no known device.

        Raises:
            WireError: It does not follow its format.
        """

    def forget(self, address: str) -> None:  # noqa: B027 - no duty: some keep nothing
        """Forget the state of the device at *address*."""
