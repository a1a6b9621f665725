"""Endpoints, the hosts that devices were found on, and their addresses. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import unquote, urlsplit

from homebot.conventions.coap.link_format import WebLink
from homebot.conventions.payload import clean_text
from homebot.devices.identity import identifiers
from homebot.errors import WireError
from homebot.support.addresses import resolve_uri

SCHEMES = frozenset({"coap", "coaps", "coap+tcp", "coaps+tcp"})

CONFIGURED = "the configuration"

_COAP_PORT = 5683
_FACTS = {"d": "sector", "et": "endpoint_type"}


@dataclass(frozen=True, slots=True)
class CoapEndpoint:
    """A host with one or more devices.

    Attributes:
        key: The key of its first device: its name in a resource directory, else its address. A name has no slash.
        base: Its address: ``coap://192.168.1.20``.
        is_registered: Whether it is in a resource directory, which says when it is gone.
        source: Its directory; :data:`CONFIGURED`, or empty for one that answered by itself. Its key belongs to it until
            it is gone.
        is_foreign: Whether another host named its address.
        lifetime: Seconds after which its registration ends; 0 if that is not known.
        identifiers: Its identifiers beyond this gateway.
    """

    key: str
    base: str
    name: str = ""
    description: str = ""
    is_registered: bool = False
    source: str = ""
    is_foreign: bool = False
    lifetime: float = 0.0
    facts: Mapping[str, str] = field(default_factory=dict)
    identifiers: tuple[str, ...] = ()

    @property
    def is_static(self) -> bool:
        """True if it is in the configuration."""
        return self.source == CONFIGURED


def endpoint_at(host: str, port: int) -> CoapEndpoint:
    """Return the endpoint at an address that answered a question."""
    quoted = f"[{host.replace('%', '%25')}]" if ":" in host else host
    base = f"coap://{quoted}" + ("" if port == _COAP_PORT else f":{port}")
    return CoapEndpoint(base, base)


def static_endpoint(uri: str) -> CoapEndpoint:
    """Return the endpoint of an address in the configuration; with a path that is the address of a description."""
    parts = urlsplit(uri)
    base = f"{parts.scheme}://{parts.netloc}"
    has_path = parts.path not in {"", "/"}
    return CoapEndpoint(uri.rstrip("/"), base, description=uri if has_path else "", source=CONFIGURED)


def endpoint_of_link(link: WebLink) -> CoapEndpoint:
    """Return the endpoint that one link of an endpoint lookup is about; RFC 9176, section 6.4.

    Raises:
        WireError: It has no name, or no usable address; says which.
    """
    name, sector = link.get("ep"), link.get("d")
    base = link.get("base") or link.get("con")
    if not name:
        raise WireError(f"the registration {link.target[:60]!a} has no ep")
    lifetime = link.get("lt")
    return CoapEndpoint(
        key=clean_text(f"{name}@{sector}" if sector else name, 200).replace("/", "%2F"),  # no address, nor below one
        base=_check_base(base, name),
        name=clean_text(name),
        is_registered=True,
        lifetime=float(lifetime) if lifetime.isdecimal() and len(lifetime) < 10 else 0.0,
        facts={fact: clean_text(link.get(key)) for key, fact in _FACTS.items() if link.get(key)},
        identifiers=tuple(
            identifier
            for identifier in identifiers([name])
            if not identifier.startswith("id:") or identifier.startswith("id:urn:")
        ),
    )


def authority_of(uri: str) -> str:
    """Return scheme, host and port of an address, for comparison."""
    parts = urlsplit(uri)
    return f"{parts.scheme}://{parts.netloc}".casefold().removesuffix(f":{_COAP_PORT}")


def host_of(uri: str) -> str:
    """Return the host of an address, with its scope if it has one; empty for none."""
    return unquote(urlsplit(uri).hostname or "")


def check_uri(uri: str) -> str:
    """Return *uri*, an address such as ``coap://192.168.1.20``.

    Raises:
        ValueError: It is none.
    """
    try:
        parts = urlsplit(uri)
        port = parts.port
    except ValueError as exc:
        raise ValueError(f"{uri!r} is not an address: {exc}") from None
    if parts.scheme not in SCHEMES or not parts.hostname or port == 0:
        raise ValueError(f"{uri!r} is not an address such as coap://192.168.1.20")
    return uri


def _check_base(base: str, name: str) -> str:
    try:
        parts = urlsplit(base)
        is_usable = parts.scheme in SCHEMES and bool(parts.hostname) and parts.port != 0
        resolved = resolve_uri(base, "/").removesuffix("/")
    except ValueError:
        is_usable, resolved = False, ""
    if not is_usable or not resolved.isprintable():
        raise WireError(f"the endpoint {name[:60]!a} has no usable base: {base[:60]!a}")
    return resolved
