"""Services of the control layer that keep a part of a device as it is wanted."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from homebot.devices.command_messages import CommandResult, Setting
from homebot.messages.message import Message, ServiceType

__all__ = [
    "LONGEST_TTL",
    "SHORTEST_TTL",
    "HoldPart",
    "HoldRequest",
    "HolderRequest",
    "LeaseResponse",
    "ReleaseLease",
    "RenewLease",
]

SHORTEST_TTL = 1.0
LONGEST_TTL = 3600.0

_MOST_SCOPES = 100
_Name = Annotated[str, Field(min_length=1, max_length=100)]


class HolderRequest(Message):
    """A holder and its lease, to renew or to release it.

    Attributes:
        lease: The name that the holder gave to its lease.
        by: Who holds it, in a word for people.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, where the door sets it.
    """

    lease: _Name
    by: _Name
    issuer: str


class HoldRequest(Message):
    """A wish to have one value of a part, and to keep it.

    Attributes:
        device: The id of the device.
        part: The id of the part.
        setting: The capability and the value that is held.
        lease: A name for the lease that the holder chooses, such as a UUID, unique among its own.
        by: Who holds it, in a word for people, such as ``robot``; not blank.
        ttl: Seconds after which the lease ends, unless it is renewed; 1 to 3,600.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, where the door sets it.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
    """

    device: str
    part: str = ""
    setting: Setting
    lease: _Name
    by: _Name
    ttl: Annotated[float, Field(ge=SHORTEST_TTL, le=LONGEST_TTL)]
    issuer: str
    scope: Annotated[tuple[str, ...], Field(max_length=_MOST_SCOPES)] = ()


class LeaseResponse(Message):
    """The state of a lease.

    Attributes:
        held: Whether the holder has it now.
        result: What became of the newest command for it, or that a hand outranks it.
    """

    held: bool
    result: CommandResult


HoldPart = ServiceType("homebot/srv/HoldPart", HoldRequest, LeaseResponse)
RenewLease = ServiceType("homebot/srv/RenewLease", HolderRequest, LeaseResponse)
ReleaseLease = ServiceType("homebot/srv/ReleaseLease", HolderRequest, LeaseResponse)
