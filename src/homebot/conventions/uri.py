"""Resolution of addresses in descriptions. Pure."""

from __future__ import annotations

from urllib.parse import urljoin, urlsplit

__all__ = ["resolve_uri"]


def resolve_uri(base: str, href: str) -> str:
    """Return *href* resolved against *base* by RFC 3986, section 5.2, for any scheme; Python knows only some.

    Raises:
        ValueError: One of them is invalid.
    """
    scheme, separator, rest = base.partition("://")
    if urlsplit(href).scheme or not separator:
        return href
    return f"{scheme}:{urljoin(f'http://{rest}', href).removeprefix('http:')}"
