"""The door itself: listens, lets clients in, gives each a session, and closes them cleanly.

With :mod:`homebot.bridges.rosbridge.connection` the only file that imports the WebSocket server.
"""

from __future__ import annotations

import errno
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from dataclasses import asdict
from functools import partial
from http import HTTPStatus
from typing import TYPE_CHECKING, Final, TypeAlias, cast
from urllib.parse import quote
from weakref import WeakKeyDictionary

import anyio
from anyio.abc import TaskStatus
from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from homebot.bridges.admission import is_same_origin, refusal, token_of
from homebot.bridges.client_error_log import ClientErrorLog
from homebot.bridges.rosbridge.backlog import DoorBacklog
from homebot.bridges.rosbridge.connection import DoorConnection, client_frames, http_response, is_roslibpy
from homebot.bridges.rosbridge.library_log import LibraryLog
from homebot.bridges.rosbridge.settings import DoorSettings
from homebot.bridges.rosbridge.shared_state import DoorCounters, ExpectedTopics, SharedState
from homebot.bridges.token_check import TokenCheck
from homebot.bridges.turns import ServerTurns
from homebot.devices.client_rights import LOCAL_CLIENT, LOCAL_RIGHTS, ClientRights
from homebot.devices.health import Count, HealthRequest, HealthResponse
from homebot.devices.names import HOME_HEADER
from homebot.devices.network_service import NetworkService
from homebot.errors import ConfigError, UsageError
from homebot.graph import Node
from homebot.support.addresses import is_loopback
from homebot.support.logger import get_logger

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.http_requests import HttpRequests
    from homebot.bridges.rosbridge.session import ClientSession
    from homebot.devices.robot_owners import RobotOwners

__all__ = ["Door"]

SERVICE_TYPE = "_rosbridge._tcp"
"""Service type by DNS-SD that apps look for to find robots; the server of ROS announces nothing."""

_CLOSE_TIMEOUT: Final = 1.0  # seconds that a client has to close its side
_STOP_TIMEOUT: Final = 1.5  # the whole process has 5 s to stop
_MORE_PORTS: Final = 9
"""Ports after the default one to try."""

_API: Final = "/api/"
_FULL: Final = "too many clients are connected"
_GREETING: Final = "this is homebot's rosbridge v2 WebSocket server, not a web page\n"
LOG_IN: Final = Subprotocol("homebot.log_in")
"""The WebSocket subprotocol of homebot's own page, whose first frame is ``{"op": "auth", "token": "…"}``."""

_OWN_SITE: Final = frozenset({"same-origin", "none"})
_PAGE: Final = ""  # the name of a page that has yet to show its token

Site: TypeAlias = "Callable[[str, str], Awaitable[tuple[HTTPStatus, Mapping[str, str], bytes] | None]]"
"""Returns status, headers and body for a path and an ``If-None-Match`` header; None where it has no such page."""


_log = get_logger(node="/rosbridge_websocket")


class Door:
    """Lets programs outside the process take part in the graph, by rosbridge v2.

    Clients are sent their mistakes as :mod:`homebot.bridges.rosbridge.protocol` describes; they are logged in any case.

    Args:
        node: The node that acts in the clients' stead; it must outlive the door.
        settings: Address and access rules.
        announce: Told of it as a service of the network, when it listens and when it no longer does.
        local_rights: The rights of clients without a token, where the settings have no scope for them.
        owners: Returns the robots of the house, with their topics and frames; by default those that the tokens name.
        home: The name of the home, for clients; empty for none.
        open_timeout: Seconds that a client has for its request, on however slow a computer.
        site: The files that browsers are sent.

    Raises:
        ConfigError: The host is not a loopback one and there is no token.
    """

    def __init__(
        self,
        node: Node,
        settings: DoorSettings,
        announce: Callable[[NetworkService], None] = lambda _: None,
        local_rights: ClientRights = LOCAL_RIGHTS,
        owners: Callable[[], RobotOwners] | None = None,
        home: str = "",
        open_timeout: float = 10.0,
        site: Site | None = None,
    ) -> None:
        self._local_rights = local_rights
        self._rights = settings.rights(local_rights)
        if LOCAL_CLIENT in self._rights and not is_loopback(settings.host):
            raise ConfigError(
                "door",
                "host",
                f"{settings.host} can be reached by others, so it needs a token; set one or listen on 127.0.0.1",
            )
        self._settings = settings
        self._error_log = ClientErrorLog(node)
        self._counters = DoorCounters()
        self._backlog = DoorBacklog(settings.max_waiting_bytes_of_all)
        self._turns = ServerTurns()
        self._expected = ExpectedTopics(node.graph)
        self._tokens = TokenCheck(settings.all_tokens(), node.graph.clock)
        self._shared = SharedState(
            node,
            settings,
            self._turns,
            self._backlog,
            self._expected,
            self._counters,
            self._error_log,
            owners or settings.robot_owners,
        )
        self._sessions: dict[ServerConnection, ClientSession] = {}
        self._names: WeakKeyDictionary[ServerConnection, str] = WeakKeyDictionary()
        self._arriving: dict[DoorConnection, None] = {}
        self._api: HttpRequests | None = None
        self._port = settings.port
        self._announce = announce
        self._home = quote(home)
        self._open_timeout = open_timeout
        self._site = site

    @property
    def port(self) -> int:
        """The TCP port; the real one once the door listens, also where port 0 was asked for."""
        return self._port

    @property
    def client_count(self) -> int:
        """Number of connected clients, requests that are being answered included."""
        return len(self._sessions) + (0 if self._api is None else self._api.count)

    def health(self, _request: HealthRequest) -> HealthResponse:
        """Return the counters and guessing addresses; the answer of the service ``health``."""
        counts = {
            **asdict(self._counters),
            "wrong_tokens": self._tokens.wrong,
            "messages_lost": self._backlog.lost,
            "clients_now": self.client_count,
        }
        return HealthResponse(
            counts=Count.each(counts),
            troubles=self._tokens.problems(),
        )

    def update_tokens(self, settings: DoorSettings) -> None:
        """Use the tokens and rights of *settings*, and disconnect each client whose token or rights changed."""
        rights, tokens = settings.rights(self._local_rights), settings.all_tokens()
        old, old_tokens = self._rights, self._settings.all_tokens()
        self._rights, self._tokens = rights, TokenCheck(tokens, self._shared.node.graph.clock)
        self._settings = self._settings.model_copy(
            update={"token": settings.token, "tokens": settings.tokens, "scope": settings.scope}
        )
        for connection in self._sessions:
            name = self._names[connection]
            if rights.get(name) != old.get(name) or tokens.get(name) != old_tokens.get(name):
                connection.transport.abort()

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled; ``started()`` once it listens. Cancelling closes the clients' connections cleanly.

        Raises:
            ConfigError: The address cannot be listened on: it is taken, reserved, or not of this machine.
        """
        server = await self._listen()
        self._port = next(iter(server.sockets)).getsockname()[1]
        if self._port != (wanted := self._settings.port) and wanted:
            _log.warning(
                "door.other_port",
                message=f"port {wanted} is in use, maybe by another homebot; listening on {self._port}: tools "
                f"here need --door {self._port}, or state a port in [door]",
                port=self._port,
            )
        self._announce(self._service(server))
        try:
            async with anyio.create_task_group() as tasks:
                await tasks.start(self._expected.run)
                task_status.started()
                await anyio.sleep_forever()
        finally:
            self._announce(NetworkService(service_type=SERVICE_TYPE, is_withdrawn=True))
            with anyio.CancelScope(shield=True):
                await self._stop(server)

    def _service(self, server: Server) -> NetworkService:
        addresses = tuple(dict.fromkeys(one.getsockname()[0] for one in server.sockets))
        return NetworkService(service_type=SERVICE_TYPE, addresses=addresses, port=self._port)

    async def _stop(self, server: Server) -> None:
        server.close()
        if self._api is not None:
            self._api.stop()
        with anyio.move_on_after(_STOP_TIMEOUT):
            await server.wait_closed()
            return
        # A client that takes no more bytes, or has sent no request, cannot be sent a close frame.
        for connection in (*self._sessions, *self._arriving):
            connection.transport.abort()
        await server.wait_closed()

    async def _listen(self) -> Server:
        """Listen on the port of the settings, or if that is taken and nobody stated it, on one of the next."""
        settings, port = self._settings, self._settings.port
        last = port if "port" in settings.model_fields_set else port + _MORE_PORTS
        while True:
            try:
                return await self._listen_on(port)
            except OSError as exc:
                if exc.errno != errno.EADDRINUSE or port >= last:
                    raise UsageError(f"door: {settings.listening_problem(exc, '--door or [door] port')}") from exc
            port += 1

    async def _listen_on(self, port: int) -> Server:
        settings = self._settings
        log = logging.Logger("door", logging.ERROR)  # noqa: LOG001  # of this door alone; it leads into our own log
        log.addHandler(LibraryLog(self._error_log))
        return await serve(
            self._serve,
            settings.host,
            port,
            process_request=self._admit,
            process_response=self._name_home,
            select_subprotocol=lambda _, offered: LOG_IN if LOG_IN in offered else None,
            compression=None,  # costs more than a local link saves, and a small frame could grow without limit
            server_header=None,
            max_size=settings.max_frame_bytes,
            open_timeout=None,  # of the connection: a request to the API may take as long as a device does
            close_timeout=_CLOSE_TIMEOUT,
            max_queue=1,  # frames; a frame may be large
            create_connection=cast(
                "type[ServerConnection]", partial(DoorConnection, self._turns, self._arriving, self._open_timeout)
            ),
            logger=log,
        )

    def _name_home(self, _: ServerConnection, __: Request, response: Response) -> None:
        response.headers[HOME_HEADER] = self._home

    async def _admit(self, connection: ServerConnection, request: Request) -> Response | None:
        settings, headers = self._settings, request.headers
        arriving = cast("DoorConnection", connection)
        arriving.has_asked()
        if self.client_count >= settings.max_clients:
            return self._turn_away(connection, HTTPStatus.SERVICE_UNAVAILABLE, _FULL)
        problem = refusal(settings, headers.get_all("Host"), headers.get_all("Origin"))
        if problem is not None:
            return self._turn_away(connection, HTTPStatus.FORBIDDEN, problem)
        is_api = request.path.startswith(_API)
        if arriving.posted is not None and not is_api:
            return self._turn_away(connection, HTTPStatus.METHOD_NOT_ALLOWED, f"there is only GET outside {_API}")
        is_websocket = any("websocket" in value.lower() for value in headers.get_all("Upgrade"))
        if not is_websocket and not is_api and (file := await self._file(request)) is not None:
            return file
        if LOG_IN in headers.get("Sec-WebSocket-Protocol", "") and is_same_origin(
            headers["Host"], headers.get("Origin", "")
        ):
            self._names[connection] = _PAGE
            return None
        shown = token_of("" if is_api else request.path, headers.get_all("Authorization"))
        response = await self._check_token(connection, shown) or self._check_page(connection, request)
        if response is not None:
            return response
        if is_api:
            return await self._answer(arriving, request)
        if not is_websocket:
            response = connection.respond(HTTPStatus.UPGRADE_REQUIRED, _GREETING)
            response.headers["Upgrade"] = "websocket"
            return response
        return None

    def _check_page(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return the response to a web page of another server that may not speak to this one."""
        headers, problem = request.headers, ""
        if (page := self._unnamed_page(request, connection)) and not is_same_origin(headers["Host"], page):
            problem = f"web pages from {page[:100]!r} need a token; or name them in allowed_origins"
        elif request.path.startswith(_API) and not set(headers.get_all("Sec-Fetch-Site")) <= _OWN_SITE:
            problem = "web pages of other servers may not use the HTTP API"
        return self._turn_away(connection, HTTPStatus.FORBIDDEN, problem) if problem else None

    async def _answer(self, connection: DoorConnection, request: Request) -> Response:
        """Answer a request to the HTTP API."""
        from homebot.bridges.rosbridge.http_requests import HttpRequests  # noqa: PLC0415 - loaded with the first

        if self.client_count >= self._settings.max_clients:  # several were let in at the same time
            return self._turn_away(connection, HTTPStatus.SERVICE_UNAVAILABLE, _FULL)
        if self._api is None:
            self._api = HttpRequests(self._shared, self._home)
        name, is_page = self._names[connection], bool(self._unnamed_page(request, connection))
        self._counters.clients += 1
        call = self._api.answer(connection, name, self._rights[name], _address_of(connection), is_page=is_page)
        return http_response(*await call)

    async def _file(self, request: Request) -> Response | None:
        """Return the file of the page that *request* asks for; None where it has no such file."""
        found = self._site and await self._site(request.path, request.headers.get("If-None-Match", ""))
        if not found:
            return None
        status, headers, body = found
        return Response(status.value, status.phrase, Headers(headers), body)

    async def _check_token(self, connection: ServerConnection, token: str) -> Response | None:
        """Check the token of the client; return the response to a refused one."""
        if LOCAL_CLIENT in self._rights and (not token or len(self._rights) == 1):
            self._names[connection] = LOCAL_CLIENT
            return None
        name = await self._tokens.check(_address_of(connection).rpartition(":")[0], token)
        if name is None:
            problem = "too many wrong tokens from this address; try again in a second"
            return self._turn_away(connection, HTTPStatus.TOO_MANY_REQUESTS, problem)
        if not name:
            return self._turn_away(connection, HTTPStatus.UNAUTHORIZED, "a valid token is needed")
        self._names[connection] = name
        return None

    def _unnamed_page(self, request: Request | None, connection: ServerConnection) -> str:
        """Return the origin of a web page without a token that the settings do not name; empty for other clients."""
        origin = request.headers.get("Origin", "") if request is not None else ""
        is_local = self._names[connection] == LOCAL_CLIENT
        return origin if is_local and origin not in self._settings.allowed_origins else ""

    async def _log_in(self, connection: ServerConnection, texts: AsyncIterator[str]) -> bool:
        """Return whether the first frame of homebot's own page shows a token, or needs none; else close it."""
        from homebot.bridges.rosbridge.log_in import token_in  # noqa: PLC0415 - loaded with the first page

        token = None
        with anyio.move_on_after(self._open_timeout):
            token = token_in(await anext(texts, ""))
        problem: Response | None = None
        if token is None or (problem := await self._check_token(connection, token)) is not None:
            reason = "the first frame must be an auth" if problem is None else problem.body.decode().strip()
            await connection.close(CloseCode.POLICY_VIOLATION, reason)
            return False
        return True

    def _turn_away(self, connection: ServerConnection, status: HTTPStatus, problem: str) -> Response:
        client = _address_of(connection)
        self._counters.turned_away += 1
        self._error_log.log(
            f"rejected {client.rpartition(':')[0]}",
            "door.turned_away",
            f"{client} was rejected: {problem}",
            client=client,
            problem=problem,
        )
        if cast("DoorConnection", connection).target.startswith(_API):
            from homebot.bridges.rosbridge.http_requests import problem_body  # noqa: PLC0415 - loaded with the first

            return http_response(*problem_body(status, problem))
        return connection.respond(status, f"{problem}\n")

    async def _serve(self, connection: ServerConnection) -> None:
        if self.client_count >= self._settings.max_clients:  # several were let in at the same time
            await connection.close(CloseCode.TRY_AGAIN_LATER, _FULL)
            return
        from homebot.bridges.rosbridge import session as sessions  # noqa: PLC0415 - loaded with the first client

        def cut() -> None:
            self._counters.clients_cut += 1
            connection.transport.abort()

        texts = client_frames(connection)
        if self._names[connection] == _PAGE and not await self._log_in(connection, texts):
            return
        self._counters.clients += 1
        made, stall = cast("DoorConnection", connection), self._settings.stall_timeout
        made.has_arrived()
        name = self._names[connection]
        rights, is_page = self._rights[name], bool(self._unnamed_page(connection.request, connection))
        address, send = _address_of(connection), partial(made.send_in_time, stall, cut)
        link = sessions.DoorLink(send, cut, made.round_trip, made.is_excused)
        session = sessions.ClientSession(
            self._shared, name, rights, address, link, is_page=is_page, is_roslibpy=is_roslibpy(connection)
        )
        self._sessions[connection] = session
        try:
            await session.run(texts)
        finally:
            del self._sessions[connection]


def _address_of(connection: ServerConnection) -> str:
    host, port = (connection.remote_address or ("unknown", 0))[:2]
    return f"{host}:{port}"
