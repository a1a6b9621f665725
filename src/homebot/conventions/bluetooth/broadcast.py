"""The interface of parsers for Bluetooth broadcasts, a plug-in group (``homebot.ble_parsers``). Pure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from homebot.conventions.bluetooth.advertisement import Advertisement
from homebot.conventions.description import AutoExpiry
from homebot.devices.part import Part
from homebot.devices.value import PlainValue

__all__ = ["Broadcast", "BroadcastParser", "BroadcastValue"]


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
        name: The name that it advertises; empty for none.
        parts: All parts known so far.
        values: New values; empty if the advertisement repeats an earlier one.
        expiries: Values that end by themselves, by part.
        metadata: Further facts.
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
        """Return the meaning of an advertisement that :meth:`concerns` this parser; None if it is of no known device.

        Args:
            advertisement: The advertisement.
            now: Seconds of the gateway's clock.

        Raises:
            WireError: It does not follow its format.
        """

    def forget(self, address: str) -> None:  # noqa: B027 - no duty: some keep nothing
        """Forget the state of the device at *address*."""
