"""Admission to a server for other programs: its address, and the rules for Host, Origin and token.

Any web page can make a browser connect to a local port; the browser then sends the page's origin, and the name that the
page used for this server. Foreign origins, and foreign names that resolve to our address (DNS rebinding), are refused.
"""

import errno
import hmac
import ipaddress
import re
import socket
from collections.abc import Mapping, Sequence
from typing import Annotated
from urllib.parse import parse_qs, urlsplit

from pydantic import BaseModel, ConfigDict, Field, SecretStr, field_validator

from homebot.support.addresses import is_loopback

_HOST = re.compile(r"[A-Za-z0-9._~%:\[\]-]*")
"""A name or an address with its port (RFC 9110, section 7.2), with which addresses in answers begin."""

_ORIGIN = re.compile(r"null|[a-z][a-z0-9+.-]*://[^/?#\s]*")
"""An origin (RFC 6454, section 6.2); nothing else can be that of a page."""

Count = Annotated[int, Field(ge=1)]


class AccessSettings(BaseModel):
    """The settings that all servers for other programs share.

    Attributes:
        host: Name or address to listen on. Any other than a loopback one needs a token.
        port: TCP port; 0 takes a free one.
        token: The required token, as ``Authorization: Bearer TOKEN``.
        allowed_origins: Web pages that may connect in addition to those of the same host and of loopback, for example
            ``https://panel.example.org``; ``null`` is a page opened from a file. If every client needs a token, their
            host names also count as names of this server, such as behind a proxy.
        max_clients: Most clients at a time; one more is refused.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    host: str = "127.0.0.1"
    port: Annotated[int, Field(ge=0, le=65535)] = 0
    token: Annotated[SecretStr, Field(min_length=1)] | None = None
    allowed_origins: tuple[str, ...] = ()
    max_clients: Count = 64

    @field_validator("host")
    @classmethod
    def _check_host(cls, host: str) -> str:
        if not re.fullmatch(r"[\w.-]*", host):
            try:
                _address(host)
            except ValueError:
                raise ValueError(f"{host[:100]!r} is no name or address; its port is a key of its own") from None
        return host

    @field_validator("allowed_origins")
    @classmethod
    def _check_origins(cls, origins: tuple[str, ...]) -> tuple[str, ...]:
        for origin in origins:
            if not _ORIGIN.fullmatch(origin):
                raise ValueError(f"{origin[:100]!r} is no origin; write it like https://house.example, without a path")
        return origins

    def why_not_free(self, key: str) -> str:
        """Return why listening on the address is impossible now, with the remedy; empty if possible, or for port 0."""
        if not self.port:
            return ""
        with socket.socket(socket.AF_INET6 if ":" in self.host else socket.AF_INET) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((self.host, self.port))
            except OSError as exc:
                return self.listening_problem(exc, key)
        return ""

    def listening_problem(self, error: OSError, key: str) -> str:
        """Return why the address cannot be used, with the remedy: *key* chooses another port."""
        where = f"{self.host}:{self.port}"
        if error.errno == errno.EADDRINUSE:
            return f"{where} is in use, maybe by another homebot; stop that one, or choose another port ({key})"
        if error.errno == errno.EACCES:
            return f"{where} is reserved by the system; choose a port from 1024 on ({key})"
        return f"cannot listen on {where}: {error.strerror or error}"


def refusal(settings: AccessSettings, hosts: Sequence[str], origins: Sequence[str]) -> str | None:
    """Return why a client with these Host and Origin headers is refused, or None."""
    if len(hosts) != 1 or len(origins) > 1:
        return "exactly one Host and at most one Origin header are expected"
    host = _host_of(f"//{hosts[0]}") if _HOST.fullmatch(hosts[0]) else ""
    if not _is_ours(settings, host):
        return f"this server does not accept the host name {(host or hosts[0])[:100]!a}; see token and allowed_origins"
    if origins and origins[0] not in settings.allowed_origins:
        origin = _host_of(origins[0])
        if origin != host and not is_loopback(origin):
            return f"web pages from {origins[0][:100]!r} are not allowed; see allowed_origins"
    return None


def is_same_origin(host: str, origin: str) -> bool:
    """Return whether the page at *origin* comes from the server that it calls *host*, port included."""
    return urlsplit(origin).netloc.lower() == host.lower()


def token_of(authorizations: Sequence[str], websocket_path: str = "") -> str:
    """Return the token in the Authorization header of a request; empty for none.

    Args:
        websocket_path: The path of a WebSocket handshake, whose query may have it instead: some clients can send no
            header. That of other requests has none, as it would stay in histories and logs.
    """
    for value in authorizations:
        scheme, _, token = value.partition(" ")
        if scheme.lower() == "bearer":
            return token.strip()
    return parse_qs(websocket_path.partition("?")[2]).get("token", [""])[-1]


def name_of_token(tokens: Mapping[str, SecretStr], shown: str) -> str:
    """Return the name of the token *shown*, empty if it is wrong; takes equally long in both cases."""
    given, owner_name = shown.encode(errors="replace"), ""
    for name, token in tokens.items():
        if hmac.compare_digest(given, token.get_secret_value().encode()):
            owner_name = name
    return owner_name


def _is_ours(settings: AccessSettings, host: str) -> bool:
    if is_loopback(host) or host == settings.host.lower():
        return True
    needs_token = settings.token is not None or not is_loopback(settings.host)
    if needs_token and host in set(map(_host_of, settings.allowed_origins)) - {""}:
        return True
    try:
        _address(host)
        return _address(settings.host).is_unspecified  # it listens everywhere; only names can be rebound, not addresses
    except ValueError:
        return False


def _host_of(url: str) -> str:
    try:
        return (urlsplit(url).hostname or "").lower()
    except ValueError:
        return ""


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    return ipaddress.ip_address(host.removeprefix("[").removesuffix("]"))
