"""Messages of the rosbridge server about its clients and the types that they define."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32


class AccessRefused(Message):
    """A request of a rosbridge client that lacks the right for it.

    Attributes:
        issuer: The client, as ``client:NAME``.
        address: Its address and port.
        operation: The requested operation by its rosbridge name, for example ``publish``.
        target: The topic or service, as the client wrote it; at most 247 characters of it.
        held_back: Earlier refusals of this client for which no message was published.
        subject: The device or address that a command was for, as the client wrote it; at most 247 characters of it,
            empty for none.
        wanted: The command, if it was a plain word such as ``unlock``; else empty, because it may contain a code.
    """

    issuer: str
    address: str
    operation: str
    target: str
    right: str
    reason: str
    refused_at: Time
    held_back: UInt32 = 0
    subject: str = ""
    wanted: str = ""


class ListedToken(Message):
    """A token of the door, without its secret.

    Attributes:
        scope: Its rights as they are written; empty for the owner's, which has every one.
        until: When it ends, in seconds since 1970; 0 for never.
        used_at: When a client last showed it; 0 for never since the start.
        is_connected: Whether a client with it is connected now.
    """

    name: str
    scope: tuple[str, ...] = ()
    until: float = 0.0
    used_at: Time
    is_connected: bool = False


class ListTokensRequest(Message):
    """Request for the tokens of the door."""


class ListTokensResponse(Message):
    """The tokens of the door.

    Attributes:
        since: The start, since which their uses are known.
    """

    since: Time
    tokens: tuple[ListedToken, ...] = ()


class DefineTypeRequest(Message):
    """A type that a client wants to use by name.

    Attributes:
        type: Its name: ``package/msg/Name``, or with ``srv`` or ``action`` in place of ``msg``.
        definition: The text of its file; nested messages may follow, each after a line of 80 ``=`` and a line
            ``MSG: package/Name``.
        issuer: The client as ``client:NAME``, set by the door.
    """

    type: str
    definition: str
    issuer: str = ""


class DefineTypeResponse(ServiceAnswer):
    """The result of defining a type, which lasts until homebot ends.

    Attributes:
        type_hash: Its hash in ROS 2 (RIHS01).
    """

    type_hash: str = ""


ListTokens = ServiceType("homebot/srv/ListTokens", ListTokensRequest, ListTokensResponse)
DefineType = ServiceType("homebot/srv/DefineType", DefineTypeRequest, DefineTypeResponse)
