"""Responses of devices to commands, as text. Pure.

No standard defines them: one with an error, as of Zigbee2MQTT and Shelly, is a refusal; any other accepts the command.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.conventions.payload import clean_text, parse_object
from homebot.errors import WireError

__all__ = ["problem_of"]

_LONGEST: Final = 4096  # bytes of a response
_LONGEST_REASON: Final = 200


def problem_of(response: bytes) -> str:
    """Return the reason of a refusing response; empty for any other."""
    try:
        fields = parse_object(response[:_LONGEST])
    except WireError:
        return ""
    error = fields.get("error")
    if not (error or fields.get("status") == "error" or fields.get("success") is False):
        return ""
    text = error.get("message") if isinstance(error, Mapping) else error or fields.get("message")
    return clean_text(text, _LONGEST_REASON) if isinstance(text, str) and text.strip() else "the device refuses"
