"""The contract of parsers of broadcasts; the plug-in group is ``homebot.ble_parsers``. Pure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from homebot.conventions.bluetooth.advertisement import Advertisement
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
    """The meaning of an advertisement, and what is known of its device by now.

    Attributes:
        key: What the device is called, where that is not its address: beacons change theirs.
        name: The name that it says; empty for none.
        parts: All its parts that are known.
        values: What is new; nothing where the advertisement repeats one that was read.
        metadata: Further facts.
        identifiers: What it is known by beyond this gateway, beside its address.
        rssi_at_1m: How strongly it is received at a distance of one metre, in dBm, where it says so.
        silence: Seconds for which it may be silent at least; 0 for no particular time.
        problem: What keeps it from being read, as text; empty where all is well.
    """

    key: str = ""
    name: str = ""
    parts: tuple[Part, ...] = ()
    values: tuple[BroadcastValue, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    identifiers: tuple[str, ...] = ()
    rssi_at_1m: float | None = None
    silence: float = 0.0
    problem: str = ""


class BroadcastParser(ABC):
    """Reads the advertisements of one kind of device; it keeps what it has to know of each.

    Args:
        bind_keys: The keys of devices that encrypt, by address.
    """

    def __init__(self, bind_keys: Mapping[str, bytes]) -> None:
        self.bind_keys = bind_keys

    @abstractmethod
    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether an advertisement is of this kind, by what is seen at once."""

    @abstractmethod
    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return what one says that :meth:`concerns` it; None where that tells no device.

        Args:
            advertisement: The advertisement.
            now: Seconds of the gateway's clock.

        Raises:
            WireError: It breaks the rules of its kind.
        """

    def forget(self, address: str) -> None:  # noqa: B027 - no duty: some keep nothing
        """Forget what is kept of the device that has *address*."""
