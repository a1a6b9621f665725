"""The services of a client: those that it calls, and those that it provides."""

import asyncio
import math
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from functools import partial
from typing import Any, final

import anyio

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    AdvertiseService,
    CallService,
    ServiceOperation,
    ServiceResponse,
    failure_frame,
    frame_text,
)
from homebot.bridges.rosbridge.shared_state import Provisions, SharedState
from homebot.bridges.rosbridge.types import request_from_client, service_type_of
from homebot.bridges.time_slices import ServerTurns
from homebot.devices.names import MACHINE_NODE
from homebot.devices.own_services import row_of_service
from homebot.devices.query.term_messages import QueryTerm, query_terms, query_words
from homebot.devices.query.terms import Or
from homebot.devices.services import QueryDevicesResponse
from homebot.errors import (
    HomebotError,
    PeerError,
    RefusedError,
    ServiceFailedError,
    ServiceUnavailableError,
    TypeMismatchError,
    UsageError,
)
from homebot.graph import Client, EntityKind, Graph, Node
from homebot.graph.current_cause import CURRENT_CAUSE, CallCause
from homebot.graph.parameters import PARAMETER_SERVICES
from homebot.messages.definition import fields_of
from homebot.messages.json import message_to_pieces, message_to_text
from homebot.messages.message import Message, ServiceType
from homebot.words.queries import parse_query

_MAX_DRIFT = 0.001
"""Seconds per second by which the clock of a client may be slow."""

LATE = "came too late"


@final
class CallDelays:
    """The delays of the calls of a client by its own clock: a link that was silent delivers late what it was given."""

    def __init__(self) -> None:
        self._least, self._at = math.inf, 0.0

    def check(self, op: CallService, now: float) -> None:
        """Refuse *op* if the client has given it up.

        Args:
            now: The present, in seconds of a steady clock.

        Raises:
            PeerError: It has.
        """
        delay = now - op.sent
        self._least, self._at = min(delay, self._least + (now - self._at) * _MAX_DRIFT), now
        if 0 < op.patience < (late := delay - self._least):
            raise PeerError(f"{op.service} {LATE}, by {late:.0f} s, so it was not carried out; try again")


def named_values(message_type: type[Message], values: object) -> dict[str, Any]:
    """Return *values* by field name; a list has them in order."""
    if isinstance(values, dict):
        return values
    if not isinstance(values, list):
        raise TypeMismatchError(f"not a {message_type.ros_type}: expected an object, got {str(values)[:60]!r}")
    names = [field.name for field in fields_of(message_type)]
    if len(values) > len(names):
        raise TypeMismatchError(f"{message_type.ros_type} has {len(names)} fields, got {len(values)} values")
    return dict(zip(names, values, strict=False))


def parse_queries(
    request_type: type[Message], values: Mapping[str, object]
) -> tuple[Mapping[str, object], UsageError | None]:
    """Return *values* of a request with text queries parsed, and the problem with one, if any.

    An invalid query is replaced by one that matches nothing.
    """
    problem: UsageError | None = None
    parsed: dict[str, object] = {}
    for field in fields_of(request_type):
        text = values.get(field.name)
        if field.message is QueryTerm and isinstance(text, str):
            try:
                parse_query(text)
                parsed[field.name] = query_words(text)
            except UsageError as exc:
                parsed[field.name], problem = query_terms(Or(())), exc
        if field.name == "is_checked" and field.name not in values:
            parsed[field.name] = True
    return {**values, **parsed}, problem


def refusal(service: str, response: Message, problem: UsageError) -> Message:
    """Return the answer of *service* to an invalid query, from its *response* to one that matches nothing."""
    if isinstance(response, QueryDevicesResponse):
        return response.model_copy(update={"success": False, "message": str(problem), "is_mistake": True})
    raise ServiceFailedError(service, str(problem)) from problem


_DEFAULT_TIMEOUT = 5.0
_MAX_TIMEOUT = 3600.0
_OF_PARAMETERS = frozenset(PARAMETER_SERVICES.values())
_ROSAPI = "/rosapi/"
"""The services that libraries call with types of their own: ``rosapi/Topics``, ``rosapi_msgs/srv/ActionServers``."""
_MAX_COMPARED, _MAX_NAME_CHARACTERS = 200, 100  # names compared, and their lengths: a client may ask repeatedly


async def call_service(
    node: Node,
    op: CallService,
    turns: ServerTurns,
    access: ClientAccess,
    answer: Callable[[str], None],
    on_request: Callable[[Client[Any, Any], Message], None] = lambda *_: None,
) -> None:
    """Make the call *op* on the graph of *node*, and *answer* it, even if it fails.

    The ``issuer`` and ``scope`` of a request, if it has them, are replaced by those of *access*.

    It returns at the end of the handler, perhaps after the client's time limit, so that short limits do not allow a
    client more handlers. Long responses are written in several *turns*. *on_request* is called with the client of the
    service and the request.
    """
    try:
        await _wait_if_coming(node.graph, node.resolve_name(op.service, "service name"))
        client, request, problem = _prepare(node, op, access)
    except HomebotError as exc:
        answer(_failure(node, op, exc))
        return
    on_request(client, request)
    CURRENT_CAUSE.set(cause_of_call(node, access, client.service_name))
    try:
        response = await client.call(request, _timeout(op, client.service_name))
        if not isinstance(response, Message):
            response = client.service_type.Response.of(response)
        if problem is not None:
            response = refusal(client.service_name, response, problem)
        pieces = message_to_pieces(response)
        written = [next(pieces)]
        for piece in pieces:
            written.append(piece)
            await turns.turn()
        frame = frame_text("service_response", op.id, {"service": op.service, "result": True}, values="".join(written))
    except HomebotError as exc:
        frame = _failure(node, op, exc)
    finally:
        client.close()
    answer(frame)
    await client.wait_for_handlers()


async def _wait_if_coming(graph: Graph, name: str) -> None:
    await graph.begin(name)
    if name not in graph.coming or graph.get_service_type(name) is not None:
        return
    with anyio.move_on_after(_DEFAULT_TIMEOUT), graph.watch(only=(EntityKind.SERVICE, name)) as changes:
        await anext(changes)


def cause_of_call(node: Node, access: ClientAccess, name: str) -> CallCause | None:
    """Return the cause of an app's actions for a client that calls its service or action *name*, or None."""
    return CallCause(access.issuer, name, node.graph.clock.now()) if access.wishes(name) else None


def missing_service(node: Node, op: CallService) -> str:
    """Return that the service of *op* does not exist, with a suggestion; empty if it does."""
    name = node.resolve_name(op.service, "service name")
    is_known = bool(node.graph.get_endpoints(kind=EntityKind.SERVICE, name=name))
    return "" if is_known else _unavailable(node, ServiceUnavailableError(name))


def _failure(node: Node, op: CallService, error: HomebotError) -> str:
    if isinstance(error, ServiceFailedError):
        return failure_frame(op, error.reason)
    return failure_frame(op, _unavailable(node, error) if isinstance(error, ServiceUnavailableError) else str(error))


def _prepare(node: Node, op: CallService, access: ClientAccess) -> tuple[Client[Any, Any], Message, UsageError | None]:
    """Return a client of the service, the request, and the problem with a query in it.

    The client is only for this call: a lasting one would fix the type of the name after the server is gone.
    """
    name = node.resolve_name(op.service, "service name")
    if node.graph.get_service_type(name) is None:
        raise ServiceUnavailableError(name)
    service_type = service_type_of(node.graph, name, "" if name.startswith(_ROSAPI) else op.type)
    request_type: type[Message] = service_type.Request
    values, problem = parse_queries(request_type, named_values(request_type, op.args))
    request = request_from_client(request_type, access.stamped(request_type, values), node.graph.clock.now())
    return node.create_client(service_type, name), request, problem


def _timeout(op: CallService, service: str) -> float:
    return min(op.timeout, _MAX_TIMEOUT) if op.timeout > 0 else usual_timeout(service)


def usual_timeout(service: str) -> float:
    """Return the seconds that a call of *service* may take if its client names none."""
    row = row_of_service(service)
    return _MAX_TIMEOUT if row is not None and row.waits else _DEFAULT_TIMEOUT


def _unavailable(node: Node, error: ServiceUnavailableError) -> str:
    """Return the error for an outside program, which has no client object for waiting."""
    if node.graph.get_endpoints(kind=EntityKind.SERVICE, name=error.service):
        return str(error)
    if node.graph.get_node(MACHINE_NODE) is not None:
        return f"service {error.service} has no server on this machine with gateways only; ask the homebot of its house"
    services = node.graph.get_endpoints(kind=EntityKind.SERVICE)
    known = [info.name for info in services if info.ros_type not in _OF_PARAMETERS]  # six for each node
    return f"service {error.service} has no server now; {similar_name(error.service, known, '/rosapi/services')}"


def similar_name(name: str, known: Sequence[str], listing: str) -> str:
    """Return a suggestion for the misspelt *name*: a similar one, or the service that lists all."""
    similar = (
        get_close_matches(name[:_MAX_NAME_CHARACTERS], known, n=1, cutoff=0.7) if len(known) <= _MAX_COMPARED else []
    )
    return f"did you mean {similar[0]}?" if similar else f"{listing} lists all"


class ProvidedServices:
    """The services provided by one connection of a client, with a limit of unanswered calls."""

    def __init__(self, shared: SharedState, outbox: Outbox, provisions: Provisions) -> None:
        self._node, self._limit = shared.node, shared.settings.max_calls
        self._outbox, self._provisions = outbox, provisions
        self._pending: dict[str, asyncio.Future[ServiceResponse]] = {}
        self._calls = 0

    def advertise(self, op: AdvertiseService) -> None:
        """Offer a service of the client, taking it over from an older connection. Idempotent."""
        name = self._node.resolve_name(op.service, "service name")
        service_type = service_type_of(self._node.graph, name, op.type)
        ask = partial(self._ask, op.service, service_type)
        create = partial(self._node.create_service, concurrent=True, cancel_with_caller=True)
        self._provisions.add(name, lambda: create(service_type, name, ask))

    def unadvertise(self, op: ServiceOperation) -> None:
        """Withdraw a service; calls under way fail."""
        if not self._provisions.remove(self._node.resolve_name(op.service, "service name")):
            raise PeerError(f"service {op.service} is not provided by this client")

    def answer(self, op: ServiceResponse) -> None:
        """Handle the client's answer to a call."""
        pending = self._pending.get(str(op.id))
        if pending is None or pending.done():
            raise PeerError(f"no call of {op.service} with the id {op.id!r} is waiting for a response")
        pending.set_result(op)

    async def _ask(self, name: str, service_type: ServiceType[Any, Any], request: Message) -> Message:
        if len(self._pending) >= self._limit:
            raise RefusedError(f"the call of {name}", f"its provider has {self._limit} calls waiting already")
        if not self._outbox.has_room:
            raise RefusedError(f"the call of {name}", "its provider is not reading its messages")
        self._calls += 1
        identifier = f"service_request:{name}:{self._calls}"
        pending = self._pending[identifier] = asyncio.get_running_loop().create_future()
        try:
            args = message_to_text(request)
            self._outbox.answer(frame_text("call_service", identifier, {"service": name}, args=args))
            response = await pending
        finally:
            del self._pending[identifier]
        if not response.result:
            raise RefusedError(f"the call of {name}", str(response.values or "its provider gave no reason")[:500])
        values = named_values(service_type.Response, response.values or {})
        return request_from_client(service_type.Response, values, self._node.graph.clock.now())
