"""Writes CoRE Link Format."""

from collections.abc import Iterable

from homebot.conventions.coap.link_format import WebLink


def format_links(links: Iterable[WebLink]) -> bytes:
    return ",".join(";".join([f"<{one.target}>", *map(_attribute, one.attributes)]) for one in links).encode()


def _attribute(attribute: tuple[str, str]) -> str:
    name, value = attribute
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return f'{name}="{escaped}"' if value else name
