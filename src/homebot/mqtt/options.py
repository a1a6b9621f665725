"""The address of a broker and the options of a connection."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, Literal, cast
from urllib.parse import SplitResult, unquote, urlsplit

from pydantic import SecretStr

from homebot.errors import UsageError
from homebot.mqtt.packets import Will

MqttProtocol = Literal["auto", "5", "3.1.1"]

_PORTS: Final = {"mqtt": 1883, "mqtts": 8883}


@dataclass(frozen=True, slots=True, kw_only=True)
class MqttOptions:
    """Address, login and limits of one MQTT connection, validated on construction.

    Attributes:
        port: TCP port, 1 to 65535.
        tls: Whether the link is encrypted and the broker's certificate verified.
        ca_file: PEM file of the authorities to trust; None trusts those of the system.
        cert_file: PEM file of the client's certificate; None sends none.
        key_file: PEM file of the client certificate's key; None looks for it in `cert_file`.
        user: Login name; None for none.
        password: Never shown by repr, logs or errors.
        client_id: Name of the client at the broker, unique there; the default is random, so a session
            that should outlive the process needs a stable one.
        keep_alive: Longest silence in seconds before the link is checked, 5 to 65535; a dead link is noticed after one
            and a half times this.
        timeout: Longest wait in seconds for the broker's answer to one request.
        session_expiry: Seconds that the broker keeps subscriptions and unacknowledged messages after the
            link is gone, 0 to 4294967295. 0 starts clean each time. MQTT 3.1.1 only has 0 and forever.
        session_ends_on_close: Whether a clean close ends the session at once, for a client id that is not used again. A
            broken link leaves the session in any case.
        maximum_packet_size: Largest packet to accept, in bytes. MQTT 5 brokers are told; larger packets are dropped and
            counted.
        receive_maximum: Most messages of QoS 1 and 2 that may wait for acknowledgement, 1 to 65535. MQTT
            3.1.1 has no field for it; there the broker's own window is the bound.
        inbox_messages: Most messages of QoS 0 that wait to be read; the oldest is dropped and counted.
        inbox_bytes: Most bytes of such messages, in topics and payloads; likewise.
        protocol: "auto" tries 5 and falls back to 3.1.1 if the broker does not speak 5.

    Raises:
        UsageError: A value is out of its range, or contradicts another.
    """

    host: str
    port: int = 1883
    tls: bool = False
    ca_file: Path | None = None
    cert_file: Path | None = None
    key_file: Path | None = None
    user: str | None = None
    password: SecretStr | None = None
    client_id: str = field(default_factory=lambda: f"homebot-{secrets.token_hex(4)}")
    keep_alive: int = 30
    timeout: float = 10.0
    session_expiry: int = 0
    session_ends_on_close: bool = False
    maximum_packet_size: int = 256 * 1024
    receive_maximum: int = 256
    inbox_messages: int = 10_000
    inbox_bytes: int = 16 * 1024 * 1024
    will: Will | None = None
    protocol: MqttProtocol = "auto"

    def __post_init__(self) -> None:
        for problem, bad in (
            ("host is not a host name or address", not _is_host(self.host)),
            ("port must be 1 to 65535", not 1 <= self.port <= 65535),
            ("a password needs a user", self.password is not None and self.user is None),
            ("CA file and client certificate need mqtts://", not self.tls and (self.ca_file or self.cert_file)),
            ("a client key needs a client certificate", self.key_file and not self.cert_file),
            ("client id must be text of 1 to 256 characters, without NUL", not _is_client_id(self.client_id)),
            ("keep alive must be 5 to 65535 s", not 5 <= self.keep_alive <= 65535),
            ("timeout must be more than 0 s", not self.timeout > 0),
            ("session expiry must be 0 to 4294967295 s", not 0 <= self.session_expiry < 2**32),
            ("maximum packet size must be 1024 to 268435455 bytes", not 1024 <= self.maximum_packet_size < 2**28),
            ("receive maximum must be 1 to 65535", not 1 <= self.receive_maximum <= 65535),
            ("the inbox must hold at least 1 message", self.inbox_messages < 1 or self.inbox_bytes < 1),
            ("protocol must be auto, 5 or 3.1.1", self.protocol not in {"auto", "5", "3.1.1"}),
        ):
            if bad:
                raise UsageError(f"MQTT options: {problem}")

    @classmethod
    def from_url(cls, url: str, **settings: object) -> MqttOptions:
        """Read ``mqtt://[user[:password]@]host[:port]`` or ``mqtts://...``.

        Args:
            url: The address; special characters of user and password are percent-encoded.
            settings: Further fields by name; they override the address.

        Raises:
            UsageError: The address is invalid, or a value is out of range. The message names it, but
                never shows the password.
        """
        parts = _split(url)
        try:
            port = parts.port
        except ValueError:
            raise UsageError("MQTT address: the port is not a number from 1 to 65535") from None
        options = cls(
            host=parts.hostname or "",
            port=_PORTS[parts.scheme] if port is None else port,
            tls=parts.scheme == "mqtts",
            user=None if parts.username is None else unquote(parts.username),
            password=None if parts.password is None else SecretStr(unquote(parts.password)),
        )
        return replace(options, **cast("dict[str, Any]", settings))

    @property
    def url(self) -> str:
        """The address without user and password, fit for logs, as ``mqtt://host:port``."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"mqtt{'s' if self.tls else ''}://{host}:{self.port}"


def _is_host(value: str) -> bool:
    try:
        return bool(value.encode("idna")) and not any(
            map(str.isspace, value)
        )  # the resolver would, with a less clear error
    except UnicodeError:
        return False


def _is_client_id(value: str) -> bool:
    return 1 <= len(value) <= 256 and "\0" not in value


def _split(url: str) -> SplitResult:
    # A password with a bare "/" or "#" ends up in other parts of the address, so no error shows the address.
    try:
        parts = urlsplit(url)
        host = parts.hostname
    except ValueError:
        raise UsageError("MQTT address: the host is invalid") from None
    if parts.scheme not in _PORTS:
        raise UsageError("MQTT address: it must start with mqtt:// or mqtts://")
    if not host:
        raise UsageError("MQTT address: the host is missing (an IPv6 address stands in brackets)")
    if parts.path not in {"", "/"} or parts.query or parts.fragment:
        raise UsageError(
            "MQTT address: nothing may follow the port (a /, ? or # in user or password is written %2F, %3F, %23)"
        )
    return parts
