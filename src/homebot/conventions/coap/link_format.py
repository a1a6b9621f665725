"""Links of CoRE Link Format. Pure.

Source: RFC 6690, section 2; the grammar is that of RFC 8288 with an explicit anchor, and with empty elements and
parameters: small devices print a comma after each link. An invalid link is an error, and nothing of it is kept.
"""

import re
from dataclasses import dataclass
from typing import Final

from homebot.conventions.payload import shown
from homebot.errors import WireError

LINK_FORMAT: Final = 40
"""The number of this content format (IANA, "CoAP Content-Formats")."""

MAX_LINK_FORMAT_BYTES = 256 * 1024
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
    if len(payload) > MAX_LINK_FORMAT_BYTES:
        raise WireError(f"a list of links of {len(payload)} bytes is longer than {MAX_LINK_FORMAT_BYTES}")
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


def _link(text: str, at: int) -> tuple[WebLink, int]:
    match = _TARGET.match(text, at)
    if match is None:
        raise WireError(f"a link begins with <, got {shown(text[at : at + 40])}")
    target, at = match[1], match.end()
    attributes: list[tuple[str, str]] = []
    while at < len(text) and text[at] == ";":
        if (empty := _EMPTY.match(text, at)) is not None:
            return WebLink(target[:_MAX_TEXT], tuple(attributes)), empty.end()
        name, value, at = _next_attribute(text, at)
        if len(attributes) >= _MAX_ATTRIBUTES:
            raise WireError(f"a link has more than {_MAX_ATTRIBUTES} attributes")
        attributes.append((name.lower()[:_MAX_TEXT], value[:_MAX_TEXT]))
    return WebLink(target[:_MAX_TEXT], tuple(attributes)), at


def _next_attribute(text: str, at: int) -> tuple[str, str, int]:
    name = _NAME.match(text, at)
    if name is None:
        raise WireError(f"an attribute of a link has no name: {shown(text[at : at + 40])}")
    at = name.end()
    if at >= len(text) or text[at] != "=":
        return name[1], "", at
    match = _VALUE.match(text, at)
    if match is None:
        raise WireError(f"the value of {name[1][:40]} of a link does not end")
    return name[1], match[2].strip() if match[1] is None else _ESCAPED.sub(r"\1", match[1]), match.end()
