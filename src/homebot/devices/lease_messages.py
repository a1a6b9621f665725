"""Services of the control layer that hold a part of a device at a value."""

from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import Field

from homebot.devices.command_messages import MAX_TRANSITION_S, CommandResult, Setting
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import LocalServiceType, Message, ServiceType

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome

SHORTEST_TTL = 1.0
MAX_TTL = 3600.0

_MAX_SCOPES = 100
_NO_TIME = Time(sec=0, nanosec=0)
_Name = Annotated[str, Field(min_length=1, max_length=100)]


class HolderRequest(Message):
    """A holder and its lease, to renew or to release it.

    Attributes:
        lease: The name that the holder gave its lease.
        by: The holder, as a word for people.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, set by the door.
    """

    lease: _Name
    by: _Name
    issuer: str


class HoldRequest(Message):
    """Request to set a part to a value and hold it.

    Attributes:
        device: The id or the name of the device.
        part: The id of the part; empty for the only one that takes the held setting, not counting configuration parts.
        lease: A name for the lease, chosen by the holder, such as a UUID; unique among its leases.
        by: The holder, as a word for people, such as ``robot``; not blank.
        ttl: Seconds after which the lease ends, unless it is renewed; 1 to 3,600.
        is_open_ended: Whether the holder renews it until it is released, so that its ``ttl`` says nothing to others.
        yields_to_persons: Whether a person's command is obeyed, and outranks it, if all holders say so. The holder may
            request its lease again for another value.
        transition: Seconds that each change to the value takes, if the device supports that; 0 leaves it to the device.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, set by the door.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
        trigger: Its cause, if the holder knows it; ignored for a client of the door.
    """

    device: ShortText
    part: ShortText = ""
    setting: Setting
    lease: _Name
    by: _Name
    ttl: Annotated[float, Field(ge=SHORTEST_TTL, le=MAX_TTL)]
    is_open_ended: bool = False
    yields_to_persons: bool = False
    transition: Annotated[float, Field(ge=0.0, le=MAX_TRANSITION_S)] = 0.0
    issuer: str
    scope: Annotated[tuple[str, ...], Field(max_length=_MAX_SCOPES)] = ()
    trigger: Trigger = NO_TRIGGER


class LeaseState(NamedTuple):
    """The state of a lease.

    Attributes:
        outcome: The outcome of the newest command for it, or the fact that a hand outranks it.
    """

    held: bool
    outcome: "Outcome"


class LeaseResponse(Message):
    """A `LeaseState` for other programs."""

    held: bool
    result: CommandResult

    @staticmethod
    def answer_type() -> type[LeaseState]:
        """Return the type that this message represents."""
        return LeaseState

    @classmethod
    def of(cls, state: LeaseState) -> "LeaseResponse":
        """Return the message that carries *state*."""
        return cls(held=state.held, result=CommandResult.of(state.outcome))


class HolderOfPart(Message):
    """One holder of a part.

    Attributes:
        issuer: The name of its node, or ``client:NAME`` for a client of the door.
        until: When the lease expires unless it is renewed; 0 if it is held until it is released.
    """

    by: str
    issuer: str
    until: Time
    trigger: Trigger = NO_TRIGGER


class HeldPart(Message):
    """A part that is held.

    Attributes:
        outranked_until: Until when a hand outranks the lease; 0 if none does.
    """

    device: str
    part: str = ""
    setting: Setting
    holders: tuple[HolderOfPart, ...] = ()
    outranked_until: Time = _NO_TIME
    saw: str = ""


class GetLeasesRequest(Message):
    """Request for the held parts.

    Attributes:
        device: Only parts of the device with this id; empty for all.
    """

    device: str = ""


class EndLeasesRequest(Message):
    """Request to end all leases of a part of a device.

    Attributes:
        issuer: The issuer of the request; the door sets it for its clients.
    """

    device: str
    issuer: str


class LeasesResponse(Message):
    """Parts with leases, or whose leases were ended, by device."""

    parts: tuple[HeldPart, ...] = ()


GetLeases = ServiceType("homebot/srv/GetLeases", GetLeasesRequest, LeasesResponse)
EndLeases = ServiceType("homebot/srv/EndLeases", EndLeasesRequest, LeasesResponse)
HoldPart: ServiceType[HoldRequest, LeaseState] = LocalServiceType("homebot/srv/HoldPart", HoldRequest, LeaseResponse)
RenewLease: ServiceType[HolderRequest, LeaseState] = LocalServiceType(
    "homebot/srv/RenewLease", HolderRequest, LeaseResponse
)
ReleaseLease: ServiceType[HolderRequest, LeaseState] = LocalServiceType(
    "homebot/srv/ReleaseLease", HolderRequest, LeaseResponse
)
