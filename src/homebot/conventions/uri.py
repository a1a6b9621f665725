"""Resolution of addresses in descriptions. Pure."""

from __future__ import annotations

from urllib.parse import urljoin, urlsplit

__all__ = ["resolve_uri"]


def resolve_uri(base: str, href: str) -> str:
    """Return *href* resolved against *base* as RFC 3986, section 5.2, has it, whatever the scheme.

    Python does so only for the schemes that it knows.

    Raises:
        ValueError: One of them is no address.
    """
    scheme, separator, rest = base.partition("://")
    if urlsplit(href).scheme or not separator:
        return href
    return f"{scheme}:{urljoin(f'http://{rest}', href).removeprefix('http:')}"
