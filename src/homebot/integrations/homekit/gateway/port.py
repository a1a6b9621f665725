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

from homebot.devices import Sighting
from homebot.devices.names import OWN_MODEL
from homebot.errors import WireError
from homebot.integrations.homekit.formats.accessory import CharacteristicId

_THREAD: Final = "_hap._udp"
_SERVICE_TYPES: Final = frozenset({"_hap._tcp", _THREAD})
_ID: Final = re.compile(r"(?:[0-9A-F]{2}:){5}[0-9A-F]{2}")
_UNPAIRED: Final = 1
"""The bit of the status flags of an unpaired accessory."""

PAIRS_WITHIN: Final = 60.0
"""Seconds; small processors need half a minute for the keys."""

Pairing: TypeAlias = Mapping[str, object]
"""The keys of a pairing, a secret that only the port reads."""

HomekitValues: TypeAlias = Mapping[CharacteristicId, Mapping[str, object]]
"""The ``value`` or the HAP ``status`` of characteristics, unchecked."""

OnEvent: TypeAlias = Callable[[HomekitValues], None]
"""Receives the values of an event; never raises."""

StatusCodes: TypeAlias = dict[CharacteristicId, int]
"""The HAP status codes of characteristics that could not be written; empty if all were."""


@dataclass(frozen=True, slots=True)
class FoundAccessory:
    """An accessory server on the network: an accessory or a bridge.

    Attributes:
        id: Its pairing ID, ``AA:BB:CC:DD:EE:FF``; it changes when it is reset.
        service_type: The type of its DNS-SD service.
        is_paired: Whether it is paired with any controller.
        version: Its configuration number, which grows when its accessories change.
        state: Its state number, which grows with changes that it could not push.
        features: Its feature flags, which describe how it can be paired.
    """

    id: str
    name: str
    address: str
    port: int
    service_type: str = "_hap._tcp"
    model: str = ""
    is_paired: bool = True
    version: str = ""
    state: str = ""
    features: int = 0

    @property
    def is_on_thread(self) -> bool:
        """True if it is reached by CoAP over Thread."""
        return self.service_type == _THREAD

    @classmethod
    def of(cls, sighting: Sighting) -> FoundAccessory | None:
        """Return the accessory in an mDNS sighting, None for others, also homebot; raise WireError if it is wrong."""
        facts = {fact.key: fact.value for fact in sighting.metadata}
        if (service_type := facts.get("dns_sd_type", "")) not in _SERVICE_TYPES or facts.get("txt_md") == OWN_MODEL:
            return None
        key = facts.get("txt_id", "").upper()
        flags, port, features = (facts.get(name, "0") for name in ("txt_sf", "port", "txt_ff"))
        if not _ID.fullmatch(key):
            raise WireError(f"the TXT record of {sighting.key[:100]} has the id {key[:40]!r}, not six pairs of digits")
        if not all(text.isascii() and text.isdecimal() and len(text) <= 5 for text in (flags, port, features)):
            raise WireError(f"the TXT record of {sighting.key[:100]} has sf {flags[:10]!r} and ff {features[:10]!r}")
        return cls(
            key,
            sighting.name,
            facts.get("ip_address", ""),
            int(port),
            service_type,
            facts.get("model", ""),
            is_paired=not int(flags) & _UNPAIRED,
            version=facts.get("txt_c#", ""),
            state=facts.get("txt_s#", ""),
            features=int(features),
        )


class HomekitLink(ABC):
    """An encrypted connection to an accessory. Its methods raise LinkError or PeerError."""

    lost: anyio.Event

    @abstractmethod
    async def list_accessories(self) -> object:
        """Return all accessories, as JSON objects, unchecked."""

    @abstractmethod
    async def read(self, ids: Iterable[CharacteristicId]) -> HomekitValues:
        """Return the values of characteristics."""

    @abstractmethod
    async def write(self, values: Mapping[CharacteristicId, object], *, is_timed: bool) -> StatusCodes:
        """Write characteristics; a cancelled or late write is not sent any more.

        A router of a Thread network may keep a sent one until the accessory is awake.
        """

    @abstractmethod
    async def subscribe(self, ids: Iterable[CharacteristicId]) -> None:
        """Ask for events of these characteristics."""

    @abstractmethod
    async def unpair(self) -> None:
        """Remove the pairing from the accessory."""


class HomekitPort(ABC):
    """The port to the library."""

    @abstractmethod
    def connected(
        self, sighted: FoundAccessory, pairing: Pairing, on_event: OnEvent
    ) -> AbstractAsyncContextManager[HomekitLink]:
        """Connect to a paired accessory; the connection is closed at the end of the block.

        Raises:
            LinkError: It cannot be reached.
            PeerError: It refuses homebot's key.
        """

    @abstractmethod
    async def pair(self, sighted: FoundAccessory, digits: str) -> Pairing:
        """Pair with an accessory by its setup code ``123-45-678``.

        Raises:
            LinkError: It cannot be reached.
            PeerError: It refuses; the message gives the reason, and never the code.
        """
