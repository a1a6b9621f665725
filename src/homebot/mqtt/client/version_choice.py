"""Choice of the version of MQTT that a client speaks with its broker."""

from __future__ import annotations

from typing import Literal, TypeAlias, final

from homebot.errors import HomebotError, LinkError, RefusedError
from homebot.logger import get_logger
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets.reason import ReasonCode

__all__ = ["ClosedEarlyError", "MqttVersion", "VersionChoice"]

MqttVersion: TypeAlias = Literal["5", "3.1.1"]
_log = get_logger()


class ClosedEarlyError(LinkError):
    """The broker closed the connection where it should have answered CONNECT."""


@final
class VersionChoice:
    """The version for the next link: of "auto" 5, and 3.1.1 once a broker that never spoke 5 wanted it so.

    Args:
        options: What is allowed.

    Attributes:
        version: For the next try.
    """

    def __init__(self, options: MqttOptions) -> None:
        self._options = options
        self._has_spoken = False
        self._reason = ""
        self.version: MqttVersion = "3.1.1" if options.protocol == "3.1.1" else "5"

    def falls_back(self, error: HomebotError) -> bool:
        """Return True to try 3.1.1 after *error*; then `version` says so."""
        if self._options.protocol != "auto" or self.version != "5":
            return False
        if isinstance(error, RefusedError):
            if error.code != ReasonCode.UNSUPPORTED_PROTOCOL_VERSION:
                return False
        elif self._has_spoken or not isinstance(error, ClosedEarlyError):
            return False  # a broker that has spoken 5 before closed for another reason
        self._reason = str(error)
        self.version = "3.1.1"
        return True

    def succeeded(self) -> None:
        """The broker speaks `version`: it is asked for this one from now on."""
        if self._reason:
            _log.info(
                "mqtt.fell_back",
                message=f"{self._options.url} speaks MQTT 3.1.1, not 5",
                broker=self._options.url,
                reason=self._reason,
            )
            self._reason = ""
        self._has_spoken = True

    def failed(self) -> None:
        """No link came of it: where 3.1.1 was only a try, the next link begins with 5 again."""
        if self._reason:
            self._reason = ""
            self.version = "5"
