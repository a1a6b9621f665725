"""Requests to the HTTP API: each is a short-lived client of the rosbridge server with the rights of its token."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from http import HTTPStatus
from importlib import import_module
from typing import TYPE_CHECKING
from urllib.parse import unquote

import anyio
from anyio import to_thread

from homebot.bridges.home_api.routes import ApiAnswer, ApiRequest, answer
from homebot.bridges.home_api.routes import problem_body as problem_body
from homebot.bridges.home_api.shapes import ProblemError
from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
from homebot.bridges.rosbridge.client import OutsideClient
from homebot.bridges.rosbridge.protocol import CallService
from homebot.bridges.rosbridge.services import call_service
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import UsageError
from homebot.graph import EntityKind
from homebot.plugins import check_extra
from homebot.support.addresses import network_of
from homebot.support.bounded_map import BoundedMap
from homebot.support.limits import RateLimit

if TYPE_CHECKING:
    from anyio.abc import TaskGroup

    from homebot.bridges.rosbridge.agents import AgentServers
    from homebot.bridges.rosbridge.connection import HttpExchange, RosbridgeConnection

_MAX_ADDRESSES = 1000


class HttpRequests:
    """Answers requests: per address and second as many as a client may send frames."""

    def __init__(self, shared: SharedState, home: str, tasks: TaskGroup) -> None:
        self._shared, self._tasks = shared, tasks
        self._agents: AgentServers | None = None
        self._home = unquote(home)
        self._asking: dict[RosbridgeConnection, anyio.CancelScope] = {}
        self._rates: BoundedMap[str, RateLimit] = BoundedMap(_MAX_ADDRESSES)

    @property
    def count(self) -> int:
        """Number of requests that are being answered."""
        return len(self._asking)

    def stop(self) -> None:
        """Cancel all requests."""
        for scope in self._asking.values():
            scope.cancel()

    def end_sessions(self, names: Iterable[str]) -> None:
        """End the sessions of agents with tokens of these *names*."""
        if self._agents is not None:
            for name in names:
                self._agents.end(name)

    async def answer(
        self, connection: RosbridgeConnection, access: ClientAccess, address: str, exchange: HttpExchange | None
    ) -> ApiAnswer | None:
        """Return the answer; the request is cancelled if its client leaves.

        Args:
            exchange: That of an agent, which gets the answer instead; None for the HTTP API.
        """
        connection.has_arrived()
        posted = connection.posted
        more = () if posted is None else (posted.content_type, posted.body)
        asked = ApiRequest(posted.method if posted and not posted.is_reading else "GET", connection.target, *more)
        with anyio.CancelScope() as scope:
            self._asking[connection] = scope
            connection.connection_lost_waiter.add_done_callback(lambda _: scope.cancel())
            try:
                await self._wait(network_of(address.rpartition(":")[0]))
                client = OutsideClient(self._shared, access, address)
                if exchange is None:
                    return await answer(asked, self._calls_of(client))
                try:
                    if (servers := self._agents) is None:
                        check_extra("/mcp", "mcp", "mcp")
                        module = await to_thread.run_sync(import_module, "homebot.bridges.rosbridge.agents")
                        # Another request may have begun meanwhile.
                        servers = self._agents = self._agents or module.AgentServers(self._calls_of, self._tasks)
                except UsageError as exc:
                    return problem_body(HTTPStatus.SERVICE_UNAVAILABLE, str(exc))
                await servers.answer(client, exchange)
            finally:
                del self._asking[connection]
                connection.has_answer()
        return problem_body(HTTPStatus.SERVICE_UNAVAILABLE, "homebot stops") if exchange is None else None

    def _calls_of(self, client: OutsideClient) -> _Calls:
        return _Calls(client, self._home)

    async def _wait(self, address: str) -> None:
        """Wait until a request from *address* is within the rate limit, and for its turn."""
        counters, settings = self._shared.counters, self._shared.settings
        counters.frames += 1
        most = settings.max_frames_per_second
        rate = self._rates.get(address) or RateLimit(most, at_once=most)
        self._rates[address] = rate
        if wait := rate.charge(self._shared.node.graph.clock.monotonic()):
            counters.slowed_down += 1
            await anyio.sleep(wait)
        await self._shared.turns.turn()


class _Calls:
    """The services of the house for one request, see :class:`homebot.bridges.home_api.device_search.HomeCalls`."""

    def __init__(self, client: OutsideClient, home: str) -> None:
        self._client, self._node = client, client.shared.node
        self.home = home

    def now(self) -> float:
        return self._node.graph.clock.now()

    def offers(self, service: str) -> bool:
        return bool(self._node.graph.get_endpoints(kind=EntityKind.SERVICE, name=service))

    async def call(self, service: str, request: Mapping[str, object]) -> JsonMessage:
        access = self._client.access
        op = CallService(op="call_service", service=service, args=dict(request))
        try:
            access.check(op, self._node.resolve_name)
        except MissingRightError as exc:
            self._client.record_missing_right(op, exc)
            raise ProblemError(HTTPStatus.FORBIDDEN, str(exc)) from exc
        frames: list[str] = []
        await call_service(self._node, op, self._client.shared.turns, access, frames.append)
        response = json.loads(frames[0])
        if not response["result"]:
            raise ProblemError(HTTPStatus.SERVICE_UNAVAILABLE, str(response["values"]))
        return JsonMessage(response["values"])
