"""The port to accessories: how they are announced, paired and connected to.

Source: HomeKit Accessory Protocol Specification R2, 6.4 (discovery), table 6-8 (status flags).
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from typing import Final, TypeAlias

import anyio

from homebot.conventions.homekit.accessory import CharacteristicId
from homebot.devices import Sighting
from homebot.errors import WireError

__all__ = ["FoundAccessory", "HomekitLink", "HomekitPort", "OnEvent", "Pairing", "StatusCodes"]

SERVICE_TYPE: Final = "_hap._tcp"
_ID: Final = re.compile(r"(?:[0-9A-F]{2}:){5}[0-9A-F]{2}")
_UNPAIRED: Final = 1
"""The bit of the status flags that says that it is paired with nobody."""

Pairing: TypeAlias = Mapping[str, object]
"""The keys of a pairing: secret. Only the port reads them."""

OnEvent: TypeAlias = Callable[[object], None]
"""Takes the JSON of an event, unchecked; never raises."""

StatusCodes: TypeAlias = dict[CharacteristicId, int]
"""The HAP status codes of characteristics that could not be written; empty if all were."""


@dataclass(frozen=True, slots=True)
class FoundAccessory:
    """An accessory server on the network: an accessory or a bridge.

    Attributes:
        id: Its pairing ID, ``AA:BB:CC:DD:EE:FF``; it changes when it is reset.
        is_paired: Whether it is paired with some controller.
        version: Its configuration number, which grows when its accessories change.
        features: Its feature flags, which say how it is paired.
    """

    id: str
    name: str
    address: str
    port: int
    model: str = ""
    is_paired: bool = True
    version: str = ""
    features: int = 0

    @classmethod
    def of(cls, sighting: Sighting) -> FoundAccessory | None:
        """Return the accessory that an mDNS gateway sighted; None for another service.

        Raises:
            WireError: Its TXT record breaks the rules.
        """
        facts = {one.key: one.value for one in sighting.metadata}
        if facts.get("dns_sd_type") != SERVICE_TYPE:
            return None
        key = facts.get("txt_id", "").upper()
        flags, port, features = (facts.get(name, "0") for name in ("txt_sf", "port", "txt_ff"))
        if not _ID.fullmatch(key):
            raise WireError(f"the TXT record of {sighting.key[:100]} has the id {key[:40]!r}, not six pairs of digits")
        if not all(one.isascii() and one.isdecimal() and len(one) <= 5 for one in (flags, port, features)):
            raise WireError(f"the TXT record of {sighting.key[:100]} has sf {flags[:10]!r} and ff {features[:10]!r}")
        is_paired = not int(flags) & _UNPAIRED
        version, address = facts.get("txt_c#", ""), facts.get("ip_address", "")
        return cls(key, sighting.name, address, int(port), facts.get("model", ""), is_paired, version, int(features))


class HomekitLink(ABC):
    """An encrypted connection to an accessory.

    Attributes:
        lost: Set when it is lost.
    """

    lost: anyio.Event

    @abstractmethod
    async def list_accessories(self) -> object:
        """Return the JSON of all accessories, unchecked. Like all here, it raises LinkError or PeerError."""

    @abstractmethod
    async def read(self, ids: Iterable[CharacteristicId]) -> object:
        """Return the JSON of the values of characteristics, unchecked."""

    @abstractmethod
    async def write(self, values: Mapping[CharacteristicId, object], *, is_timed: bool) -> StatusCodes:
        """Write characteristics; a write that is cancelled or too late does not reach the accessory any more.

        Args:
            is_timed: Whether the accessory wants a timed write.
        """

    @abstractmethod
    async def subscribe(self, ids: Iterable[CharacteristicId]) -> None:
        """Ask for events of these characteristics."""

    @abstractmethod
    async def unpair(self) -> None:
        """Remove the pairing from the accessory."""


class HomekitPort:
    """The library behind the gateway."""

    def connected(
        self, found: FoundAccessory, pairing: Pairing, on_event: OnEvent
    ) -> AbstractAsyncContextManager[HomekitLink]:
        """Connect to a paired accessory; the connection is closed at the end of the block.

        Raises:
            LinkError: It cannot be reached.
            PeerError: It refuses homebot's key.
        """
        raise NotImplementedError

    async def pair(self, found: FoundAccessory, digits: str) -> Pairing:
        """Pair with an accessory by its setup code ``123-45-678``.

        Raises:
            LinkError: It cannot be reached.
            PeerError: It refuses; the message gives the reason, and never the code.
        """
        raise NotImplementedError
