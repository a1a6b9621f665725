"""The port to Bluetooth: the operations that the gateway needs, independent of the library."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager

from homebot.conventions.bluetooth.advertisement import Advertisement
from homebot.errors import LinkError

__all__ = ["BleLink", "BleRadio", "BluetoothUnavailableError"]


class BluetoothUnavailableError(LinkError):
    """There is no Bluetooth adapter, it is turned off, or the Bluetooth service is not running."""


class BleLink(ABC):
    """A connection to one device; characteristics are named by their full UUIDs."""

    @property
    @abstractmethod
    def is_open(self) -> bool:
        """True while the connection is open."""

    @abstractmethod
    def has(self, characteristic: str, *properties: str) -> bool:
        """Return whether the device has a characteristic, and with at least one of *properties*, if any are given."""

    @abstractmethod
    async def read(self, characteristic: str) -> bytes:
        """Return the value of a characteristic.

        Raises:
            LinkError: The connection is lost.
            RefusedError: The device refuses.
        """

    @abstractmethod
    async def write(self, characteristic: str, data: bytes, *, response: bool) -> None:
        """Set the value of a characteristic; with *response*, wait until the device has acknowledged it.

        Raises:
            LinkError: The connection is lost.
            RefusedError: The device refuses.
        """

    @abstractmethod
    async def subscribe(self, characteristic: str, on_value: Callable[[bytes], None]) -> None:
        """Call *on_value* with each value that the device notifies.

        Raises:
            LinkError: The connection is lost.
            RefusedError: The device refuses.
        """

    @abstractmethod
    async def close(self) -> None:
        """Disconnect; does nothing if the connection was lost already."""


class BleRadio(ABC):
    """A Bluetooth adapter."""

    @property
    @abstractmethod
    def heard(self) -> int:
        """The number of addresses that the running scan has seen."""

    @abstractmethod
    def scanning(self, on_heard: Callable[[Advertisement], None]) -> AbstractAsyncContextManager[None]:
        """Return a scan, which runs inside the block.

        Raises:
            BluetoothUnavailableError: There is no adapter, or it was removed.
        """

    @abstractmethod
    async def connect(self, address: str, on_lost: Callable[[], None]) -> BleLink:
        """Connect to a device and discover its services.

        Raises:
            BluetoothUnavailableError: There is no adapter.
            LinkError: The device cannot be reached.
        """
