"""HTTP addresses: checked, and in a form fit for people. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from homebot.conventions.payload import clean_text
from homebot.errors import WireError

if TYPE_CHECKING:
    from yarl import URL


def http_origin(address: str, port: int, scheme: Literal["http", "https"] = "http") -> str:
    """Return the origin of a server: ``http://10.0.0.7``, ``https://[fe80::1%eth0]:8443``.

    Args:
        address: Its IP address, with the scope where it is link-local, or its name.
        scheme: ``https`` for TLS.

    Raises:
        WireError: It is not an address.
    """
    host = f"[{address}]" if ":" in address else address
    return str(parse_url(f"{scheme}://{host}:{port}").origin())


def parse_url(url: str, *schemes: str) -> URL:
    """Return *url* if it is a complete address.

    Args:
        schemes: Those that are allowed; by default ``http`` and ``https``.

    Raises:
        WireError: It is none, is of another scheme, or contains a user or a password.
    """
    from yarl import URL  # noqa: PLC0415 - an extra

    schemes = schemes or ("http", "https")
    try:
        u_r_l = URL(url)
    except ValueError:
        raise WireError("what should be an address of HTTP is none") from None
    if u_r_l.scheme not in schemes or not u_r_l.host:
        begins = clean_text(u_r_l.scheme, 20) or "no scheme"
        raise WireError(f"what should be an address of HTTP begins with {begins}")
    if u_r_l.user is not None or u_r_l.password is not None:
        raise WireError(f"the address of {shown_url(u_r_l)} contains a user or password; remove them")
    return u_r_l


def shown_url(url: URL) -> str:
    """Return *url* for people, without the parts that may be secret."""
    host = f"[{url.host}]" if url.host is not None and ":" in url.host else url.host
    port = "" if url.is_default_port() else f":{url.port}"
    return clean_text(f"{host}{port}{url.raw_path}")
