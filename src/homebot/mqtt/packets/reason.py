"""Reason codes, protocol versions, and the one error that every bad packet raises."""

from enum import IntEnum, unique
from typing import Final

from homebot.errors import WireError


@unique
class ProtocolVersion(IntEnum):
    """The protocol level a client asks for in CONNECT."""

    V31 = 3
    V311 = 4
    V5 = 5


@unique
class ReasonCode(IntEnum):
    """The result of a request. Below 0x80 it worked. Source: MQTT 5.0, section 2.4.

    In SUBACK 0x00 to 0x02 are the granted QoS. MQTT 3 has other numbers in CONNACK; the codec translates, so
    the rest of the program knows only these.
    """

    SUCCESS = 0x00
    GRANTED_QOS_1 = 0x01
    GRANTED_QOS_2 = 0x02
    DISCONNECT_WITH_WILL = 0x04
    NO_MATCHING_SUBSCRIBERS = 0x10
    NO_SUBSCRIPTION_EXISTED = 0x11
    CONTINUE_AUTHENTICATION = 0x18
    REAUTHENTICATE = 0x19
    UNSPECIFIED_ERROR = 0x80
    MALFORMED_PACKET = 0x81
    PROTOCOL_ERROR = 0x82
    IMPLEMENTATION_SPECIFIC_ERROR = 0x83
    UNSUPPORTED_PROTOCOL_VERSION = 0x84
    CLIENT_IDENTIFIER_NOT_VALID = 0x85
    BAD_USER_NAME_OR_PASSWORD = 0x86
    NOT_AUTHORIZED = 0x87
    SERVER_UNAVAILABLE = 0x88
    SERVER_BUSY = 0x89
    BANNED = 0x8A
    SERVER_SHUTTING_DOWN = 0x8B
    BAD_AUTHENTICATION_METHOD = 0x8C
    KEEP_ALIVE_TIMEOUT = 0x8D
    SESSION_TAKEN_OVER = 0x8E
    TOPIC_FILTER_INVALID = 0x8F
    TOPIC_NAME_INVALID = 0x90
    PACKET_IDENTIFIER_IN_USE = 0x91
    PACKET_IDENTIFIER_NOT_FOUND = 0x92
    RECEIVE_MAXIMUM_EXCEEDED = 0x93
    TOPIC_ALIAS_INVALID = 0x94
    PACKET_TOO_LARGE = 0x95
    MESSAGE_RATE_TOO_HIGH = 0x96
    QUOTA_EXCEEDED = 0x97
    ADMINISTRATIVE_ACTION = 0x98
    PAYLOAD_FORMAT_INVALID = 0x99
    RETAIN_NOT_SUPPORTED = 0x9A
    QOS_NOT_SUPPORTED = 0x9B
    USE_ANOTHER_SERVER = 0x9C
    SERVER_MOVED = 0x9D
    SHARED_SUBSCRIPTIONS_NOT_SUPPORTED = 0x9E
    CONNECTION_RATE_EXCEEDED = 0x9F
    MAXIMUM_CONNECT_TIME = 0xA0
    SUBSCRIPTION_IDENTIFIERS_NOT_SUPPORTED = 0xA1
    WILDCARD_SUBSCRIPTIONS_NOT_SUPPORTED = 0xA2

    @property
    def failed(self) -> bool:
        """True if the code is a refusal or an error."""
        return self >= 0x80

    @property
    def text(self) -> str:
        """The code for people, such as ``not authorized``."""
        return self.name.lower().replace("_", " ")


FAILURES: Final = tuple(code for code in ReasonCode if code.failed)
"""All codes of refusals and errors."""


def by_number(*codes: ReasonCode) -> dict[int, ReasonCode]:
    """Return *codes* by their numbers."""
    return {int(code): code for code in codes}


class PacketError(WireError):
    """A peer sent a packet that cannot be parsed or that MQTT does not allow."""

    def __init__(self, problem: str, frame: bytes = b"", code: ReasonCode = ReasonCode.MALFORMED_PACKET) -> None:
        super().__init__(problem, frame)
        self.code = code
