"""Addresses of CoAP. Pure."""

from __future__ import annotations

import re
from urllib.parse import urlsplit

__all__ = ["SCHEMES", "check_uri", "split_address"]

SCHEMES = frozenset({"coap", "coaps", "coap+tcp", "coaps+tcp"})

_ADDRESS = re.compile(r"\[?([^\[\]]+?)\]?:(\d{1,5})")


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
