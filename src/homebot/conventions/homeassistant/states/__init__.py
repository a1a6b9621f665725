"""Entities of Home Assistant by their states, as its WebSocket shows them."""

from typing import Final

__all__ = ["HOW_TO_LOG_IN"]

HOW_TO_LOG_IN: Final = (
    "make a token in Home Assistant (your profile, Security, Long-lived access tokens) and put it into a file that "
    "only you can read, named by token_file"
)
