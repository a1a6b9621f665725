"""Service calls that a client makes."""

from __future__ import annotations

from typing import Any

from homebot.bridges.rosbridge.protocol import CallService, Frame, service_failure, service_success
from homebot.bridges.rosbridge.queries import parse_queries, refusal
from homebot.bridges.rosbridge.values import message_from_client
from homebot.errors import HomebotError, ServiceFailedError, ServiceUnavailableError, TypeMismatchError
from homebot.graph import EntityKind, Node
from homebot.messages.definition import fields_of
from homebot.messages.message import Message

__all__ = ["call_service"]

_DEFAULT_TIMEOUT = 5.0
_MAX_TIMEOUT = 3600.0
_MOST, _LONGEST = 200, 100  # names compared, and of how many characters: a client may ask again and again


async def call_service(node: Node, op: CallService) -> Frame:
    """Make the call *op* on the graph of *node* and return the frame that answers it, be it a failure."""
    try:
        return service_success(op.service, op.id, await _call(node, op))
    except ServiceFailedError as exc:
        return service_failure(op.service, op.id, exc.reason)
    except ServiceUnavailableError as exc:
        return service_failure(op.service, op.id, _unavailable(node, exc))
    except HomebotError as exc:
        return service_failure(op.service, op.id, str(exc))


async def _call(node: Node, op: CallService) -> Message:
    name = node.resolve_name(op.service, "service name")
    service_type = node.graph.get_service_type(name)
    if service_type is None:
        raise ServiceUnavailableError(name)
    values, problem = parse_queries(service_type.Request, _values(service_type.Request, op.args))
    request = message_from_client(service_type.Request, values)
    timeout = min(op.timeout, _MAX_TIMEOUT) if op.timeout > 0 else _DEFAULT_TIMEOUT
    # A client of its own for each call: one that is kept would hold the name's type after the server is gone.
    client = node.create_client(service_type, name)
    try:
        response: Message = await client.call(request, timeout)
        return response if problem is None else refusal(name, response, problem)
    finally:
        client.close()


def _unavailable(node: Node, error: ServiceUnavailableError) -> str:
    """Return the error for a program outside, which has no client object to wait with."""
    if node.graph.get_endpoints(kind=EntityKind.SERVICE, name=error.service):
        return str(error)
    known = [info.name for info in node.graph.get_endpoints(kind=EntityKind.SERVICE)]
    from difflib import get_close_matches  # noqa: PLC0415 - as in homebot.similar

    similar = get_close_matches(error.service[:_LONGEST], known, n=1, cutoff=0.7) if len(known) <= _MOST else []
    hint = f"did you mean {similar[0]}?" if similar else "/rosapi/services lists all"
    return f"service {error.service} has no server now; {hint}"


def _values(request_type: type[Message], args: dict[str, Any] | list[Any]) -> dict[str, Any]:
    if isinstance(args, dict):
        return args
    names = [field.name for field in fields_of(request_type)]
    if len(args) > len(names):
        raise TypeMismatchError(f"{request_type.ros_type} has {len(names)} fields, got {len(args)} values")
    return dict(zip(names, args, strict=False))
