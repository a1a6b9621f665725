"""Services about the bridges of HomeKit and their pairings."""

from typing import Annotated

from pydantic import Field

from homebot.messages.key_value import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class HomekitPairingRequest(Message):
    """Request for the bridges."""


class HomekitBridgeInfo(Message):
    """A bridge.

    Attributes:
        id: Its pairing ID, as on the network.
        code: The setup code, a secret; empty while it is paired.
        uri: The same for a QR code.
        qr: The rows of that code: 1 for each dark module; empty while it is paired.
        accessories: The names of its accessories.
        controllers: How many controllers are paired with it, such as phones and hubs.
    """

    name: str
    id: str
    address: str
    port: int
    code: Annotated[str, Field(repr=False)] = ""
    uri: Annotated[str, Field(repr=False)] = ""
    qr: Annotated[tuple[str, ...], Field(repr=False)] = ()
    accessories: tuple[str, ...] = ()
    controllers: int = 0


class HomekitPairingResponse(ServiceAnswer):
    """The bridges, and the devices that are exported by type, but not there, with the reasons."""

    bridges: tuple[HomekitBridgeInfo, ...] = ()
    left_out: tuple[KeyValue, ...] = ()


class HomekitUnpairRequest(Message):
    """Request to end all pairings; each bridge gets another setup code."""


class HomekitUnpairResponse(ServiceAnswer):
    """The result, with the number of controllers that were paired."""

    controllers: int = 0


GetHomekitPairing = ServiceType("homebot/srv/GetHomekitPairing", HomekitPairingRequest, HomekitPairingResponse)
UnpairHomekit = ServiceType("homebot/srv/UnpairHomekit", HomekitUnpairRequest, HomekitUnpairResponse)
