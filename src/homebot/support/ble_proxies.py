"""Bluetooth receivers in other rooms, as a service of the host: drivers hand them over, a gateway listens to them."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Final, final

from homebot.clock import Clock
from homebot.support.bounded_map import BoundedMap
from homebot.support.limits import RateLimit

MAX_PER_SECOND, MAX_AT_ONCE = 500.0, 2_000.0
"""Advertisements of one proxy; a busy one hears a hundred each second."""

NEW_PER_SECOND, NEW_AT_ONCE = 5.0, 300.0
"""Addresses that one proxy has not told of lately."""

MAX_ADDRESSES = 1_000
MAX_ADVERTISEMENT_BYTES = 255
_WEAKEST, _STRONGEST = -127, 20


@final
class ProxyGate:
    """The limits of one proxy.

    Attributes:
        refused: Number of advertisements that were dropped: too many, or of impossible size or strength.
    """

    def __init__(self, clock: Clock) -> None:
        self.refused = 0
        self._clock = clock
        self._all = RateLimit(MAX_PER_SECOND, MAX_AT_ONCE)
        self._new = RateLimit(NEW_PER_SECOND, NEW_AT_ONCE)
        self._known: BoundedMap[int | str, None] = BoundedMap(MAX_ADDRESSES)

    def admits(self, address: int | str, rssi: int, size: int) -> bool:
        """Return whether an advertisement of *size* bytes is let through; *rssi* is in dBm."""
        now = self._clock.monotonic()
        is_possible = _WEAKEST <= rssi <= _STRONGEST and size <= MAX_ADVERTISEMENT_BYTES
        if is_possible and self._all.admits(now) and (address in self._known or self._new.admits(now)):
            self._known[address] = None
            return True
        self.refused += 1
        return False


class BleProxies(ABC):
    """The proxies that are connected.

    Attributes:
        takes_found: Whether those are taken that were found on the network and proved that they are the owner's.
    """

    takes_found: bool

    @abstractmethod
    def attached(
        self, source: str, name: str, room: str, make_scanner: Callable[[ProxyGate], object]
    ) -> AbstractContextManager[object]:
        """Listen to a proxy inside the block.

        Args:
            source: Its hardware address.
            name: Its name for people.
            room: The room that it is in; empty if that is unknown.
            make_scanner: Returns its scanner, a ``habluetooth.BaseHaRemoteScanner``.

        Raises:
            RefusedError: Another proxy has its address, or too many are connected.
        """


PROXY_EXTRA: Final = "ble-proxies"
"""The extra with the libraries of proxies."""
