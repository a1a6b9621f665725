"""The rosbridge server: listens, admits clients, gives each a session, and closes them cleanly.

Only this file, ``connection`` and ``handshake`` import the WebSocket server.
"""

from __future__ import annotations

import errno
import logging
import ssl
from collections.abc import Callable, Mapping
from functools import partial
from http import HTTPStatus
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast
from urllib.parse import quote

import anyio
from anyio import to_thread
from anyio.abc import TaskGroup, TaskStatus
from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from homebot.bridges.client_error_log import LibraryLog
from homebot.bridges.rosbridge.connection import (
    HttpExchange,
    PendingConnections,
    RosbridgeConnection,
    client_frames,
    http_response,
    is_roslibpy,
)
from homebot.bridges.rosbridge.handshake import (
    LOG_IN,
    Handshake,
    Site,
    address_of,
    is_for_agents,
    is_for_api,
    is_for_websocket,
)
from homebot.bridges.rosbridge.settings import RosbridgeSettings
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.devices.client_rights import LOCAL_RIGHTS, ClientRights
from homebot.devices.exposure import NetworkService
from homebot.devices.health import Count, HealthRequest, HealthResponse
from homebot.devices.names import HOME_HEADER
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.rights import Right
from homebot.support.counters import Severity
from homebot.support.listening import stop_accepting
from homebot.support.logger import get_logger
from homebot.support.owner_token import OwnerToken

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.first_code import FirstCode
    from homebot.bridges.rosbridge.http_requests import HttpRequests
    from homebot.bridges.rosbridge.session import ClientSession
    from homebot.bridges.rosbridge.tls import ServerTls
    from homebot.devices.access_messages import ListTokensRequest, ListTokensResponse
    from homebot.devices.robot_owners import RobotOwners

SERVICE_TYPE = "_rosbridge._tcp"
"""The DNS-SD service type by which apps find robots; ROS's own server announces nothing."""

_CLOSE_TIMEOUT: Final = 1.0  # seconds for a client to close its side
_STOP_TIMEOUT: Final = 1.5  # the whole process has 5 s to stop
_MORE_PORTS: Final = 9
"""Ports after the default one to try."""

_MISTAKE: Final = "a client of the rosbridge server sent what is no WebSocket and no HTTP"
_CRASHES: Final = {
    "connection handler failed": "a client's session crashed",
    "process_request failed": "the answer to a client's request crashed",
}
"""Mistakes of clients, by the lines of the library."""

_LIMITS: Final[Mapping[int, str]] = {
    CloseCode.MESSAGE_TOO_BIG: "max_frame_bytes",
    CloseCode.TRY_AGAIN_LATER: "max_arriving_bytes_of_all",
}
_FULL: Final = "too many clients are connected"
_KEPT: Final = 2
"""Places for clients with the right ``manage``, so that others do not lock the owner out."""

_GREETING: Final = "this is homebot's rosbridge v2 WebSocket server, not a web page\n"

_log = get_logger(node="/rosbridge_websocket")


class RosbridgeServer:
    """Connects programs outside the process to the graph by rosbridge v2.

    Mistakes of clients are logged, and reported to them as :mod:`homebot.bridges.rosbridge.protocol` describes.

    Args:
        node: The node that acts for the clients; it must outlive the rosbridge server.
        announce: Called with it as a network service when it starts and stops listening.
        local_rights: The rights of clients without a token, unless the settings have a scope for them.
        owners: Returns the robots of the house, with their topics and frames; by default those of the tokens.
        home: The name of the home, for clients; empty for none.
        open_timeout: Seconds within which a client must send its request.
        owner: The owner's token in the data folder; None for none.
        tls_folder: Where the authority of ``tls`` is kept; None where homebot keeps no data.
        first_code: As for :class:`Handshake`.

    Raises:
        ConfigError: The host is not a loopback address and there is no token.
    """

    def __init__(
        self,
        node: Node,
        settings: RosbridgeSettings,
        announce: Callable[[NetworkService], None] = lambda _: None,
        local_rights: ClientRights = LOCAL_RIGHTS,
        owners: Callable[[], RobotOwners] | None = None,
        home: str = "",
        open_timeout: float = 10.0,
        site: Site | None = None,
        owner: OwnerToken | None = None,
        tls_folder: Path | None = None,
        first_code: FirstCode | None = None,
    ) -> None:
        self._settings, self._tls_folder = settings, tls_folder
        self._shared = shared = SharedState(node, settings, owners or settings.robot_owners)
        self._handshake = Handshake(settings, local_rights, shared, site, open_timeout, owner, first_code)
        self._sessions: dict[RosbridgeConnection, ClientSession] = {}
        self._pending = PendingConnections(settings.max_arriving_bytes_of_all)
        self._api: HttpRequests | None = None
        self._tasks: TaskGroup
        self._port = settings.port
        self._announce = announce
        self._home = quote(home)
        self._open_timeout = open_timeout
        self._since = node.graph.clock.now()

    @property
    def port(self) -> int:
        """The TCP port; the actual one once the rosbridge server listens, also for port 0."""
        return self._port

    @property
    def page(self) -> str:
        """The address of its page."""
        return self._settings.page(self._port)

    @property
    def client_count(self) -> int:
        """The number of connected clients, including requests being answered."""
        return len(self._sessions) + (0 if self._api is None else self._api.count)

    def health(self, _request: HealthRequest) -> HealthResponse:
        """Return counters and guessing addresses, for the service ``health``."""
        counts = {
            "wrong_tokens": self._handshake.tokens.wrong,
            "latched_displaced": self._shared.kept.lost,
            "clients_now": self.client_count,
        }
        lost = Count(name="messages_lost", count=self._shared.backlog.lost, severity=Severity.LOSS)
        counted = (*Count.of(self._shared.counters), lost, *Count.each(counts))
        return HealthResponse(counts=counted, troubles=self._handshake.tokens.problems())

    def list_tokens(self, _request: ListTokensRequest) -> ListTokensResponse:
        """Return the tokens, with their rights and uses."""
        connected = {session.client.access.name for session in self._sessions.values()}
        return self._handshake.list_tokens(connected, self._since)

    def update_tokens(self, settings: RosbridgeSettings) -> None:
        """Use the tokens and rights of *settings*, and disconnect clients whose token or rights have changed."""
        changed = self._handshake.update_tokens(settings)
        for connection, session in self._sessions.items():
            if session.client.access.name in changed:
                connection.transport.abort()
        if self._api is not None:
            self._api.end_sessions(changed)

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled, which closes connections cleanly; ``started()`` once it listens.

        Raises:
            ConfigError: It cannot listen on the address: taken, reserved, or not of this machine.
        """
        tls: ServerTls | None = None
        if self._settings.has_tls:
            from homebot.bridges.rosbridge.tls import ServerTls  # noqa: PLC0415 - few servers have it

            clock = self._shared.node.graph.clock
            tls = await to_thread.run_sync(ServerTls, self._settings, self._tls_folder, clock)
        server = await self._listen(None if tls is None else tls.context)
        self._port = next(iter(server.sockets)).getsockname()[1]
        if self._port != (wanted := self._settings.port) and wanted:
            _log.warning(
                "door.other_port",
                message=f"port {wanted} is in use, maybe by another homebot; listening on {self._port}: tools "
                f"here need --door {self._port}, or state a port in [door]",
                port=self._port,
            )
        addresses = tuple(dict.fromkeys(socket.getsockname()[0] for socket in server.sockets))
        self._announce(NetworkService(service_type=SERVICE_TYPE, addresses=addresses, port=self._port))
        try:
            async with anyio.create_task_group() as tasks:
                self._tasks = tasks
                await tasks.start(self._shared.expected.run)
                if tls is not None:
                    tasks.start_soon(tls.run)
                task_status.started()
                await anyio.sleep_forever()
        finally:
            self._announce(NetworkService(service_type=SERVICE_TYPE, is_withdrawn=True))
            with anyio.CancelScope(shield=True):
                await self._stop(server)

    async def _stop(self, server: Server) -> None:
        await stop_accepting(server.sockets)
        server.close()
        if self._api is not None:
            self._api.stop()
        with anyio.move_on_after(_STOP_TIMEOUT):
            await server.wait_closed()
            return
        # A client that does not read, or has not sent a request, cannot be sent a close frame.
        for connection in (*self._sessions, *self._pending):
            connection.transport.abort()
        await server.wait_closed()

    async def _listen(self, tls: ssl.SSLContext | None) -> Server:
        """Listen on the port of the settings; if that is taken and only the default, on one of the next."""
        settings, port = self._settings, self._settings.port
        last = port if "port" in settings.model_fields_set else port + _MORE_PORTS
        while True:
            try:
                return await self._listen_on(port, tls)
            except OSError as exc:
                if exc.errno != errno.EADDRINUSE or port >= last:
                    raise UsageError(f"door: {settings.listening_problem(exc, '--door or [door] port')}") from exc
            port += 1

    async def _listen_on(self, port: int, tls: ssl.SSLContext | None) -> Server:
        settings, shared = self._settings, self._shared
        log = logging.Logger("door", logging.ERROR)  # noqa: LOG001  # of this rosbridge server alone; it leads into our own log
        log.addHandler(LibraryLog(shared.error_log, "door", _MISTAKE, lambda line: _CRASHES.get(str(line.msg), "")))
        return await serve(
            self._serve,
            settings.host,
            port,
            ssl=tls,
            process_request=self._admit,
            process_response=self._finish,
            select_subprotocol=lambda _, offered: LOG_IN if LOG_IN in offered else None,
            compression=None,  # not worth it on a local link, and a small frame could expand without limit
            server_header=None,
            max_size=settings.max_frame_bytes,
            open_timeout=None,  # of the connection: an API request may take as long as a device
            close_timeout=_CLOSE_TIMEOUT,
            max_queue=1,  # frames, which may be large
            create_connection=cast(
                "type[ServerConnection]", partial(RosbridgeConnection, shared.turns, self._pending, self._open_timeout)
            ),
            logger=log,
        )

    def _finish(self, connection: ServerConnection, _: Request, response: Response) -> None:
        response.headers[HOME_HEADER] = self._home
        posted = cast("RosbridgeConnection", connection).posted
        if posted is not None and posted.method == "HEAD":
            response.body = b""

    async def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        arriving = cast("RosbridgeConnection", connection)
        arriving.has_asked()
        if (response := await self._handshake.admit(arriving, request)) is not None:
            return response
        if self._handshake.knows(arriving) and (problem := self._lack_of_places(arriving)):
            return self._handshake.turn_away(arriving, HTTPStatus.SERVICE_UNAVAILABLE, problem)
        if is_for_api(request):
            return await self._answer(arriving, HttpExchange(arriving) if is_for_agents(request) else None)
        if not is_for_websocket(request):
            response = connection.respond(HTTPStatus.UPGRADE_REQUIRED, _GREETING)
            response.headers["Upgrade"] = "websocket"
            return response
        return None

    def _lack_of_places(self, connection: RosbridgeConnection) -> str:
        """Return why there is no place for a client of this token and address; empty if there is one."""
        access, host = self._handshake.access_of(connection), address_of(connection).rpartition(":")[0]
        most, kept = self._settings.max_clients, 0 if access.rights.has(Right.MANAGE) else _KEPT
        if self.client_count >= most - min(kept, most // 8):
            return _FULL
        own = [session.client for session in self._sessions.values() if session.client.access.name == access.name]
        if sum(other.address.rpartition(":")[0] == host for other in own) >= most - most // 4:
            return f"too many clients with the token {access.name} are connected from this address"
        return ""

    async def _answer(self, connection: RosbridgeConnection, exchange: HttpExchange | None) -> Response:
        from homebot.bridges.rosbridge.http_requests import HttpRequests  # noqa: PLC0415 - loaded with the first

        if self._api is None:
            self._api = HttpRequests(self._shared, self._home, self._tasks)
        self._shared.counters.clients += 1
        access = self._handshake.access_of(connection)
        answer = await self._api.answer(connection, access, address_of(connection), exchange)
        if answer is not None:
            return http_response(*answer)
        return connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "") if exchange is None else exchange.response

    async def _serve(self, opened: ServerConnection) -> None:
        connection, handshake = cast("RosbridgeConnection", opened), self._handshake
        from homebot.bridges.rosbridge.client import OutsideClient  # noqa: PLC0415 - loaded with the first
        from homebot.bridges.rosbridge.session import ClientSession, SessionLink  # noqa: PLC0415 - likewise

        def cut() -> None:
            self._shared.counters.clients_cut += 1
            connection.transport.abort()

        texts = client_frames(connection)
        if not await handshake.log_in(connection, texts):
            return
        if problem := self._lack_of_places(connection):  # several were let in at the same time
            await connection.close(CloseCode.TRY_AGAIN_LATER, problem)
            return
        self._shared.counters.clients += 1
        connection.has_arrived()
        send = partial(connection.send_in_time, self._settings.stall_timeout, cut)
        link = SessionLink(send, cut, connection.round_trip, connection.is_excused)
        access = handshake.access_of(connection)
        asking = OutsideClient(self._shared, access, address_of(connection))
        session = ClientSession(asking, link, is_roslibpy=is_roslibpy(connection))
        self._sessions[connection] = session
        try:
            with anyio.move_on_after(handshake.seconds_left(connection)) as term:
                await session.run(texts)
            if term.cancelled_caught:
                await connection.close(CloseCode.POLICY_VIOLATION, "its token has ended")
            end = connection.protocol.close_sent
            if end is not None and (limit := _LIMITS.get(end.code)):
                asking.log_refusal(f" was cut off: {end.reason}, the {limit} of [door]", "frame", end.reason)
        finally:
            del self._sessions[connection]
