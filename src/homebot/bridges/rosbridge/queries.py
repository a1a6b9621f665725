"""Queries that a client sends as text, in a field that carries terms on the graph."""

from __future__ import annotations

from collections.abc import Mapping

from homebot.devices.query import Or, QueryTerm, query_terms
from homebot.devices.services import QueryDevicesResponse
from homebot.errors import ServiceFailedError, UsageError
from homebot.isolation import error_text
from homebot.messages.definition import fields_of
from homebot.messages.message import Message

__all__ = ["parse_queries", "refusal"]


def parse_queries(
    request_type: type[Message], values: Mapping[str, object]
) -> tuple[Mapping[str, object], UsageError | None]:
    """Return *values* of a request with the terms of each query that is text, and what is wrong with one.

    In the place of a query that cannot be parsed stands one that nothing matches.
    """
    problem: UsageError | None = None
    parsed: dict[str, object] = {}
    for field in fields_of(request_type):
        text = values.get(field.name)
        if field.message is QueryTerm and isinstance(text, str):
            from homebot.devices.query.parse import parse_query  # noqa: PLC0415 - loaded with the first text

            try:
                parsed[field.name] = query_terms(parse_query(text))
            except UsageError as exc:
                parsed[field.name], problem = query_terms(Or(())), exc
    return {**values, **parsed}, problem


def refusal(service: str, response: Message, problem: UsageError) -> Message:
    """Return the answer of *service* to a text that is no query, given its *response* to one that nothing matches.

    Raises:
        ServiceFailedError: A call of the service fails for such a text.
    """
    if isinstance(response, QueryDevicesResponse):
        return response.model_copy(update={"success": False, "message": str(problem)})
    raise ServiceFailedError(service, error_text(problem)) from problem
