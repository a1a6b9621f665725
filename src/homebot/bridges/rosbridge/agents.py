"""MCP over HTTP at the rosbridge server: a session outlives its connection, and each token has a server of its own.

A request is checked as one to the HTTP API is, and a tool has the rights that its token has there.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final, final

import anyio
from anyio import to_thread

from homebot.bridges.home_api.agent_server import (
    MAX_SESSIONS,
    AgentMistakeError,
    HouseApi,
    RosbridgeAddress,
    agent_app,
)
from homebot.bridges.home_api.routes import ApiRequest, answer
from homebot.bridges.rosbridge.access import MissingRightError
from homebot.bridges.rosbridge.goals import SentGoals
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import SendActionGoal
from homebot.errors import PeerError

if TYPE_CHECKING:
    from anyio.abc import TaskGroup, TaskStatus

    from homebot.bridges.home_api.device_search import HomeCalls
    from homebot.bridges.rosbridge.client import OutsideClient
    from homebot.bridges.rosbridge.connection import HttpExchange
    from homebot.rights import OfferedService

_METHODS: Final = ("DELETE", "POST")
_SESSION: Final = "mcp-session-id"
_MAX_FRAMES: Final = 100
_MAX_BYTES: Final = 1024 * 1024
"""Frames and bytes of a goal that wait for the agent's client."""


@final
class HouseOfAgent(HouseApi):
    """The house with the rights of one token.

    Attributes:
        client: The newest request with the token.
    """

    is_of_house = True

    def __init__(
        self, client: OutsideClient, calls_of: Callable[[OutsideClient], HomeCalls], server: RosbridgeAddress
    ) -> None:
        self.client, self.server = client, server
        self._calls_of = calls_of

    async def ask(self, method: str, target: str, body: bytes = b"") -> tuple[int, str]:
        """See :meth:`HouseApi.ask`."""
        request = ApiRequest(method, target, "application/json" if body else "", body)
        reply = await answer(request, self._calls_of(self.client))
        return reply.status, reply.body.decode()

    @asynccontextmanager
    async def send_goal(
        self, action: OfferedService, goal: Mapping[str, object]
    ) -> AsyncIterator[Callable[[], Awaitable[Any]]]:
        """See :meth:`HouseApi.send_goal`."""
        client, shared = self.client, self.client.shared
        op = SendActionGoal(op="send_action_goal", id="goal", action=action.name, args=dict(goal), feedback=True)
        try:
            client.access.check(op, shared.node.resolve_name)
        except MissingRightError as exc:
            client.record_missing_right(op, exc)
            raise AgentMistakeError("refused", str(exc)) from exc
        sent, frames = anyio.create_memory_object_stream[str | bytes](_MAX_FRAMES)
        with sent, frames:
            async with anyio.create_task_group() as tasks:
                outbox = Outbox(sent.send, tasks.cancel_scope.cancel, shared.turns, _MAX_BYTES)
                tasks.start_soon(outbox.run)
                goals = SentGoals(client, outbox, tasks)
                try:
                    goals.send(op)
                except PeerError as exc:
                    sent.send_nowait(json.dumps({"op": "action_result", "msg": str(exc)}))

                async def received() -> Any:
                    return json.loads(await frames.receive())

                yield received
                goals.close_one()
                tasks.cancel_scope.cancel()


@final
class _AgentServer:
    """The server of one token. Most clients never end a session, so the one that was idle for longest gives way."""

    def __init__(self, house: HouseOfAgent, app: Any) -> None:
        self.house, self.app = house, app
        self.scope = anyio.CancelScope()
        self._sessions: dict[str, None] = {}  # the last one that was used is the last
        self._in_work = Counter[str]()

    async def run(self, *, task_status: TaskStatus[None]) -> None:
        with self.scope:
            async with self.app.router.lifespan_context(self.app):
                task_status.started()
                await anyio.sleep_forever()

    async def answer(self, exchange: HttpExchange) -> None:
        """Answer a request."""
        session = exchange.headers.get(_SESSION, "")
        self._in_work[session] += 1
        try:
            await self.app(exchange.scope, exchange.receive, exchange.send)
        finally:
            self._in_work -= {session: 1}  # without those at 0
        self._sessions.pop(session, None)
        if used := exchange.method == "POST" and exchange.response.headers.get(_SESSION):
            self._sessions[used] = None
        idle = [one for one in self._sessions if one not in self._in_work]
        for one in idle[: max(0, len(self._sessions) - MAX_SESSIONS)]:
            del self._sessions[one]
            ending = {"method": "DELETE", "headers": [(_SESSION.encode(), one.encode())]}
            await self.app(exchange.scope | ending, _no_body, _to_nobody)


async def _no_body() -> dict[str, object]:
    return {"type": "http.request", "body": b""}


async def _to_nobody(_: Mapping[str, object]) -> None:
    pass


@final
class AgentServers:
    """The servers of all tokens.

    Args:
        calls_of: Returns the services of the house for a request.
        tasks: Those of the rosbridge server, with which all servers end.
    """

    def __init__(self, calls_of: Callable[[OutsideClient], HomeCalls], tasks: TaskGroup) -> None:
        self._calls_of, self._tasks = calls_of, tasks
        self._servers: dict[tuple[str, bool], _AgentServer] = {}
        self._starting = anyio.Lock()

    async def answer(self, client: OutsideClient, exchange: HttpExchange) -> None:
        """Answer a request."""
        if exchange.method not in _METHODS:  # GET is for messages without a request
            exchange.refuse(HTTPStatus.METHOD_NOT_ALLOWED, ", ".join(_METHODS))
            return
        key = client.access.name, client.access.is_page
        async with self._starting:
            if key not in self._servers:
                host, port = exchange.local_address
                address = RosbridgeAddress(host, port, exchange.token, client.shared.settings.has_tls)
                house = HouseOfAgent(client, self._calls_of, address)
                server = _AgentServer(house, await to_thread.run_sync(agent_app, house))
                await self._tasks.start(server.run)
                self._servers[key] = server
        server = self._servers[key]
        server.house.client = client
        await server.answer(exchange)

    def end(self, name: str) -> None:
        """End the sessions of the token *name*."""
        for key in ((name, False), (name, True)):
            if (server := self._servers.pop(key, None)) is not None:
                server.scope.cancel()
