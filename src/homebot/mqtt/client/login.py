"""Login of a client: the MQTT version that it speaks, the session it is granted, and the meaning of a refusal."""

from collections.abc import Awaitable, Callable
from typing import Final, Literal, NamedTuple, TypeAlias, TypeVar, final

from homebot.errors import LinkError, RefusedError, UnansweredError
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets.reason import ReasonCode
from homebot.support.logger import get_logger

MqttVersion: TypeAlias = Literal["5", "3.1.1"]
T = TypeVar("T")
_log = get_logger()


class SessionGrant(NamedTuple):
    """The session as the broker granted it when the link was made.

    Attributes:
        resumed: The broker still knew this client: its subscriptions stand, and unacknowledged messages follow.
        receive_maximum: Most publishes of QoS 1 and 2 that the broker wants to have open.
        maximum_packet_size: Largest packet that the broker takes, in bytes; None is without limit.
    """

    resumed: bool
    protocol: MqttVersion
    maximum_qos: int = 2
    retain_available: bool = True
    receive_maximum: int = 65535
    maximum_packet_size: int | None = None


class ClosedEarlyError(LinkError):
    """The broker closed the connection, or said something else, where it should have answered CONNECT."""


@final
class VersionChoice:
    """The version for the next link: of "auto" 5, and 3.1.1 once a broker that never spoke 5 wanted it so.

    A broker that does not answer 5 in time, as amqtt does not, is asked with 3.1.1 the next time, and then with 5
    again, because it may only be slow. One that refuses 3.1.1 is asked with 5 at once.
    """

    def __init__(self, options: MqttOptions) -> None:
        self._options = options
        self._has_answered = False
        self._is_silent = False
        self._version: MqttVersion = "3.1.1" if options.protocol == "3.1.1" else "5"

    async def open(self, open_as: Callable[[MqttVersion], Awaitable[T]]) -> T:
        """Make a link with *open_as*, once more with 3.1.1 where "auto" allows that and the broker wants it so.

        Raises:
            LinkError: As *open_as* does.
            RefusedError: Likewise.
        """
        if self._is_silent:
            return await self._open_after_silence(open_as)
        try:
            opened = await open_as(self._version)
        except UnansweredError:
            self._is_silent = self._may_fall_back() and not self._has_answered
            raise
        except (RefusedError, ClosedEarlyError) as error:
            if not self._falls_back(error):
                raise
            reason = str(error)
        else:
            self._has_answered = True
            return opened
        opened = await open_as("3.1.1")
        self._version = "3.1.1"  # from now on the first, so this is said once
        self._has_answered = True
        self._log_version("supports MQTT 3.1.1, not 5", reason)
        return opened

    async def _open_after_silence(self, open_as: Callable[[MqttVersion], Awaitable[T]]) -> T:
        self._is_silent = False
        try:
            opened = await open_as("3.1.1")
        except (RefusedError, ClosedEarlyError) as error:
            if isinstance(error, RefusedError) and not _is_about_version(error):
                raise
            return await self.open(open_as)  # so it was only slow
        self._log_version("says nothing to MQTT 5, and speaks 3.1.1", "")
        return opened

    def _log_version(self, what: str, reason: str) -> None:
        url = self._options.url
        _log.info("mqtt.fell_back", message=f"{url} {what}", broker=url, reason=reason)

    def _may_fall_back(self) -> bool:
        return self._options.protocol == "auto" and self._version == "5"

    def _falls_back(self, error: RefusedError | ClosedEarlyError) -> bool:
        if not self._may_fall_back():
            return False
        if isinstance(error, RefusedError):
            return _is_about_version(error)
        return not self._has_answered  # a broker that has spoken 5 before closed for another reason


def _is_about_version(error: RefusedError) -> bool:
    return error.code == ReasonCode.UNSUPPORTED_PROTOCOL_VERSION


def early_end(reason: LinkError | RefusedError, options: MqttOptions) -> LinkError | RefusedError:
    """Interpret the end of a link before the answer to CONNECT; *reason* is how it ended."""
    if isinstance(reason, RefusedError | ClosedEarlyError):
        return reason
    hint = (
        "does the broker require a client certificate (cert_file)?"
        if options.tls
        else "is this a port for TLS (mqtts://)?"
    )
    return ClosedEarlyError(f"{reason} instead of answering; {hint}")


_TRY_LATER: Final = {
    ReasonCode.SERVER_UNAVAILABLE,
    ReasonCode.SERVER_BUSY,
    ReasonCode.QUOTA_EXCEEDED,
    ReasonCode.CONNECTION_RATE_EXCEEDED,
}
_WRONG_LOGIN: Final = {ReasonCode.BAD_USER_NAME_OR_PASSWORD, ReasonCode.NOT_AUTHORIZED}
_THROWN_OUT: Final = {
    ReasonCode.NOT_AUTHORIZED,
    ReasonCode.BANNED,
    ReasonCode.SESSION_TAKEN_OVER,
    ReasonCode.ADMINISTRATIVE_ACTION,
}


def reason_text(code: int) -> str:
    """Return a reason code in words, such as ``not authorized``."""
    try:
        return ReasonCode(code).text
    except ValueError:
        return f"reason 0x{code:02x}"


def login_error(code: int) -> LinkError | RefusedError:
    """Return the error for a CONNACK with *code* (0x80 or more)."""
    if code in _TRY_LATER:
        return LinkError(f"the broker answered: {reason_text(code)}")
    hint = "; check user and password_file, which are read at the start" if code in _WRONG_LOGIN else ""
    return RefusedError("the login", f"{reason_text(code)}{hint}", code)


def disconnect_error(code: int) -> LinkError | RefusedError:
    """Return the error for a DISCONNECT with *code* from the broker."""
    if code == ReasonCode.SESSION_TAKEN_OVER:
        return RefusedError("the connection", "session taken over, another client uses this client id", code)
    if code in _THROWN_OUT:
        return RefusedError("the connection", reason_text(code), code)
    return LinkError(f"the broker disconnected: {reason_text(code) if code else 'no reason given'}")
