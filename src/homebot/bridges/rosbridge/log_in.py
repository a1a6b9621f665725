"""The log-in of homebot's own page: browsers cannot set headers, and a token in a URL ends in logs and histories."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, SecretStr, ValidationError

__all__ = ["token_in"]


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
