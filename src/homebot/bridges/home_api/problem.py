"""The error of a request to the HTTP API."""

from __future__ import annotations

from collections.abc import Mapping
from http import HTTPStatus
from typing import Literal, TypeAlias

from homebot.errors import HomebotError

__all__ = ["PROBLEMS", "ProblemError", "ProblemOutcome"]

ProblemOutcome: TypeAlias = Literal["refused", "not_found", "several", "invalid", "failed"]

PROBLEMS: Mapping[HTTPStatus, ProblemOutcome] = {
    HTTPStatus.BAD_REQUEST: "invalid",
    HTTPStatus.UNAUTHORIZED: "refused",
    HTTPStatus.FORBIDDEN: "refused",
    HTTPStatus.NOT_FOUND: "not_found",
    HTTPStatus.METHOD_NOT_ALLOWED: "invalid",
    HTTPStatus.CONFLICT: "several",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "invalid",
    HTTPStatus.TOO_MANY_REQUESTS: "refused",
    HTTPStatus.SERVICE_UNAVAILABLE: "failed",
}
"""The word for each status."""


class ProblemError(HomebotError):
    """A request cannot be carried out.

    Attributes:
        status: The status of the answer.
        policy: The policy that refused it; empty for another reason.
    """

    def __init__(self, status: HTTPStatus, detail: str, policy: str = "") -> None:
        super().__init__(detail)
        self.status = status
        self.policy = policy
