"""The log-in of homebot's own page: browsers cannot set headers, and a token in a URL ends in logs and histories."""

from __future__ import annotations

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, SecretStr, ValidationError

__all__ = ["LOG_IN", "token_in"]

LOG_IN: Final = "homebot.log_in"
"""The WebSocket subprotocol of a page whose first frame is ``{"op": "auth", "token": "…"}``; empty without one."""


def token_in(frame: str) -> str | None:
    """Return the token in the first *frame* of a page; None if it is no such frame."""
    try:
        return _LogIn.model_validate_json(frame).token.get_secret_value()
    except ValidationError:
        return None


class _LogIn(BaseModel):
    model_config = ConfigDict(extra="forbid", defer_build=True)

    op: Literal["auth"]
    token: SecretStr
