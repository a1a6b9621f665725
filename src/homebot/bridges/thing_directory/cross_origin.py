"""The header fields with which a browser lets a page of another origin use the directory. Pure.

Source: WHATWG Fetch Living Standard, section 3.3 (HTTP CORS protocol).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Final

from homebot.bridges.thing_directory.documents import DirectoryAnswer

__all__ = ["PREFLIGHT", "is_preflight", "sharing_headers"]

PREFLIGHT: Final = DirectoryAnswer(
    status=HTTPStatus.NO_CONTENT,
    headers={
        "Access-Control-Allow-Methods": "GET, HEAD, PUT",
        "Access-Control-Allow-Headers": "Authorization, Content-Type, If-None-Match, Last-Event-ID",
        "Access-Control-Max-Age": "600",
    },
)
"""The answer to a browser's preflight request, which comes without a token."""


def sharing_headers(origins: Sequence[str]) -> Mapping[str, str]:
    """Return the header fields that let the page of *origins* read the answer; it must have been admitted before.

    Nothing is shared with anything else: a program that is no page sends no origin.
    """
    if len(origins) != 1 or not (origins[0].isascii() and origins[0].isprintable()):
        return {}
    return {
        "Access-Control-Allow-Origin": origins[0],
        "Access-Control-Expose-Headers": "Allow, ETag, Link, Retry-After",
        "Vary": "Origin",
    }


def is_preflight(method: str, asked_methods: Sequence[str]) -> bool:
    """Return whether a request is a preflight: *asked_methods* is its ``Access-Control-Request-Method``."""
    return method == "OPTIONS" and bool(asked_methods)
