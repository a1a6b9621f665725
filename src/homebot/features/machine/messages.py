"""Messages between the machines of a house, over Zenoh.

A machine serves ``/HOME/MACHINE/gateways``, and ``follow`` and ``call`` below ``/HOME/MACHINE/GATEWAY``. The homebot
that follows asks again and again: each answer has what is new since the one before, at the latest after
:data:`MAX_QUIET`. So there is one answer on its way at most, nothing is lost without notice, and a slow link gets
the newest of each device.
"""

import math
from typing import Annotated, Final

from pydantic import Field

from homebot.devices import GatewayState, RawMessage, Sighting
from homebot.devices.gateway_messages import CommandAnswer, Report
from homebot.devices.health import Quarantine
from homebot.messages.message import Message, ServiceAnswer, ServiceType
from homebot.names import escape_token

MAX_QUIET: Final = 1.0
"""Seconds after which an answer comes although there is no news."""

MAX_SILENCE_S: Final = 3.0
"""Seconds without an answer after which the link is lost on both sides; of the five that are allowed."""


class GetGatewaysRequest(Message):
    """Request for the gateways of a machine."""


class GetGatewaysResponse(Message):
    """The names of the gateways that a machine exports."""

    names: tuple[str, ...]


class FollowGatewayRequest(Message):
    """Request for the news of a gateway.

    Attributes:
        follower: A random id of this following, new after each loss of the link.
        number: The number of the last answer; 0 at first. Of any other than the last one, everything comes again.
    """

    follower: str
    number: int


class FollowGatewayResponse(Message):
    """The news of a gateway.

    Attributes:
        number: Its number; they count up.
        session: The id of the machine's session, new at each of its starts.
        now: The monotonic clock of the machine.
        is_whole: Whether everything comes again, from here on over as many answers as it takes.
        keys, streams: Of that, all devices and reports that there are; others have left.
        services: Of that, the last parts of the names of the gateway's services.
    """

    number: int
    session: str
    now: float
    is_whole: bool = False
    keys: tuple[str, ...] = ()
    streams: tuple[str, ...] = ()
    services: tuple[str, ...] = ()
    states: tuple[GatewayState, ...] = ()
    sightings: tuple[Sighting, ...] = ()
    reports: tuple[Report, ...] = ()
    answers: tuple[CommandAnswer, ...] = ()
    quarantines: tuple[Quarantine, ...] = ()
    raw: tuple[RawMessage, ...] = ()


class CallGatewayRequest(Message):
    """Call of a service of a gateway, or a message on its topic ``out``.

    Attributes:
        session: As in :class:`FollowGatewayResponse`; no other machine, and none that started anew, carries it out.
        follower: As in :class:`FollowGatewayRequest`; of an earlier one nothing is carried out.
        id: Its number; each is carried out once at most.
        until: The reading of the monotonic clock of the machine after which it is not carried out.
        arrives_by: The same after which it is refused: by then the caller may have counted the link as lost.
        longest: Seconds after which no caller waits for the answer.
        service: The last part of the name.
        request: The message in CDR.
    """

    session: str
    follower: str
    id: int
    until: float
    longest: Annotated[float, Field(gt=0.0, le=3600.0)]
    service: str
    request: Annotated[bytes, Field(repr=False)]
    arrives_by: float = math.inf


class CallGatewayResponse(ServiceAnswer):
    """The answer to a call.

    Attributes:
        is_unanswered: Whether the gateway may have carried it out although it failed.
        response: The response in CDR.
    """

    is_unanswered: bool = False
    response: Annotated[bytes, Field(repr=False)] = b""


GetGateways = ServiceType("homebot/srv/GetGateways", GetGatewaysRequest, GetGatewaysResponse)
FollowGateway = ServiceType("homebot/srv/FollowGateway", FollowGatewayRequest, FollowGatewayResponse)
CallGateway = ServiceType("homebot/srv/CallGateway", CallGatewayRequest, CallGatewayResponse)


def machine_name(home: str, machine: str, *parts: str) -> str:
    """Return the name of a service of *machine* in *home*, or of a gateway of it."""
    return "/".join(("", *map(escape_token, (home, machine)), *parts))
