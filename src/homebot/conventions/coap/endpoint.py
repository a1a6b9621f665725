"""Links of CoRE Link Format, in and out, the endpoints that devices were found on, and their addresses. Pure.

Source: RFC 6690, section 2; the grammar is that of RFC 8288 with an explicit anchor, and with empty elements and
parameters: small devices print a comma after each link. An invalid link is an error, and nothing of it is kept.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from urllib.parse import urlsplit

from homebot.conventions.payload import clean_text, shown
from homebot.devices.identity import identifiers
from homebot.errors import WireError
from homebot.support.addresses import resolve_uri

__all__ = [
    "MAX_LINKS",
    "SCHEMES",
    "CoapEndpoint",
    "WebLink",
    "authority_of",
    "check_uri",
    "endpoint_at",
    "endpoint_of_link",
    "format_links",
    "parse_links",
    "split_address",
    "static_endpoint",
]

_MAX_LINK_FORMAT_BYTES = 256 * 1024
"""Longest list of links that is read; one link has about 100 bytes."""

MAX_LINKS = 2000
_MAX_ATTRIBUTES = 40
_MAX_TEXT = 1000

_COMMAS = re.compile(r"[,\s]+")
_TARGET = re.compile(r"\s*<([^<>\x00-\x1f]*)>\s*")
_EMPTY = re.compile(r"[;\s]*(?=,|$)")
_NAME = re.compile(r"[;\s]*([A-Za-z0-9!#$%&'*+.^_`|~-]+)\s*")
_VALUE = re.compile(r"=\s*(?:\"((?:[^\"\\]|\\.)*)\"|([^,;\"]*))(?=\s*(?:[,;]|$))\s*", re.DOTALL)
_ESCAPED = re.compile(r"\\(.)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class WebLink:
    """A link to a resource, with its attributes.

    Attributes:
        target: The address, as it was spelt: ``/light``.
        attributes: Names and values, in their order; a flag such as ``obs`` has an empty value.
    """

    target: str
    attributes: tuple[tuple[str, str], ...] = ()

    def get(self, name: str) -> str:
        """Return the first value of an attribute; empty if there is none."""
        return next((value for key, value in self.attributes if key == name), "")

    def has(self, name: str) -> bool:
        """Return whether an attribute is there."""
        return any(key == name for key, _ in self.attributes)

    def words(self, name: str) -> tuple[str, ...]:
        """Return the blank-separated words of all values of an attribute, as ``rt``, ``if`` and ``ct`` have them."""
        return tuple(word for key, value in self.attributes if key == name for word in value.split())


def parse_links(payload: bytes) -> tuple[WebLink, ...]:
    """Return the links that *payload* lists.

    Raises:
        WireError: It is no link format, longer than 256 KiB, or lists more than 2,000 links.
    """
    if len(payload) > _MAX_LINK_FORMAT_BYTES:
        raise WireError(f"a list of links of {len(payload)} bytes is longer than {_MAX_LINK_FORMAT_BYTES}")
    try:
        text = payload.decode().strip(", \t\r\n")
    except UnicodeDecodeError:
        raise WireError("a list of links is not UTF-8", payload) from None
    links: list[WebLink] = []
    at = 0
    while at < len(text):
        if len(links) >= MAX_LINKS:
            raise WireError(f"a list has more than {MAX_LINKS} links")
        link, at = _link(text, at)
        links.append(link)
        if at < len(text):
            if text[at] != ",":
                raise WireError(f"a comma is expected after a link, got {shown(text[at : at + 20])}")
            at = _COMMAS.match(text, at).end()  # type: ignore[union-attr]  # there is one
    return tuple(links)


def format_links(links: Iterable[WebLink]) -> bytes:
    """Return *links* as a list."""
    return ",".join(map(_spelt, links)).encode()


def _link(text: str, at: int) -> tuple[WebLink, int]:
    match = _TARGET.match(text, at)
    if match is None:
        raise WireError(f"a link begins with <, got {shown(text[at : at + 40])}")
    target, at = match[1], match.end()
    attributes: list[tuple[str, str]] = []
    while at < len(text) and text[at] == ";":
        if (empty := _EMPTY.match(text, at)) is not None:
            return WebLink(target[:_MAX_TEXT], tuple(attributes)), empty.end()
        name = _NAME.match(text, at)
        if name is None:
            raise WireError(f"an attribute of a link has no name: {shown(text[at : at + 40])}")
        at, value = name.end(), ""
        if at < len(text) and text[at] == "=":
            found = _VALUE.match(text, at)
            if found is None:
                raise WireError(f"the value of {name[1][:40]} of a link does not end")
            at, value = found.end(), found[2].strip() if found[1] is None else _ESCAPED.sub(r"\1", found[1])
        if len(attributes) >= _MAX_ATTRIBUTES:
            raise WireError(f"a link has more than {_MAX_ATTRIBUTES} attributes")
        attributes.append((name[1].lower()[:_MAX_TEXT], value[:_MAX_TEXT]))
    return WebLink(target[:_MAX_TEXT], tuple(attributes)), at


def _spelt(link: WebLink) -> str:
    return ";".join([f"<{link.target}>", *(_attribute(name, value) for name, value in link.attributes)])


def _attribute(name: str, value: str) -> str:
    if not value:
        return name
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return f'{name}="{escaped}"'


SCHEMES = frozenset({"coap", "coaps", "coap+tcp", "coaps+tcp"})

_CONFIGURED = "the configuration"

_COAP_PORT = 5683
_FACTS = {"d": "sector", "et": "endpoint_type"}

_ADDRESS = re.compile(r"\[?([^\[\]]+?)\]?:(\d{1,5})")


@dataclass(frozen=True, slots=True)
class CoapEndpoint:
    """A host with one or more devices.

    Attributes:
        key: The key of its first device: its name in a resource directory, else its address. A name has no slash.
        base: Its address: ``coap://192.168.1.20``.
        is_registered: Whether it is in a resource directory, which says when it is gone.
        source: Its directory, or the path of its registration at homebot's own; :data:`CONFIGURED`, or empty for one
            that answered by itself. Its key belongs to it until it is gone.
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
        return self.source == _CONFIGURED


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
    return CoapEndpoint(uri.rstrip("/"), base, description=uri if has_path else "", source=_CONFIGURED)


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
        base=_checked_base(base, name),
        name=clean_text(name),
        is_registered=True,
        lifetime=float(lifetime) if lifetime.isdecimal() and len(lifetime) < 10 else 0.0,
        facts={fact: clean_text(link.get(key)) for key, fact in _FACTS.items() if link.get(key)},
        identifiers=tuple(one for one in identifiers([name]) if not one.startswith("id:") or one.startswith("id:urn:")),
    )


def authority_of(uri: str) -> str:
    """Return scheme, host and port of an address, for comparison."""
    parts = urlsplit(uri)
    return f"{parts.scheme}://{parts.netloc}".casefold().removesuffix(f":{_COAP_PORT}")


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


def split_address(address: str) -> tuple[str, int]:
    """Return host and port of ``127.0.0.1:5683`` or ``[::1]:5683``.

    Raises:
        ValueError: It is none of these.
    """
    match = _ADDRESS.fullmatch(address)
    if match is None or int(match[2]) > 65535:
        raise ValueError(f"{address!r} is not an address such as 127.0.0.1:5683")
    return match[1], int(match[2])


def _checked_base(base: str, name: str) -> str:
    try:
        parts = urlsplit(base)
        is_usable = parts.scheme in SCHEMES and bool(parts.hostname) and parts.port != 0
        resolved = resolve_uri(base, "/").removesuffix("/")
    except ValueError:
        is_usable, resolved = False, ""
    if not is_usable or not resolved.isprintable():
        raise WireError(f"the endpoint {name[:60]!a} has no usable base: {base[:60]!a}")
    return resolved
