"""The handshake of the rosbridge server: refuses requests, and identifies clients by their tokens."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Mapping
from http import HTTPStatus
from math import inf, isinf
from typing import TYPE_CHECKING, Final, Literal, TypeAlias
from weakref import WeakKeyDictionary

import anyio
from pydantic import BaseModel, ConfigDict, SecretStr, ValidationError
from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from homebot.bridges.admission import is_same_origin, refusal, token_of
from homebot.bridges.rosbridge.connection import RosbridgeConnection, http_response
from homebot.bridges.rosbridge.settings import RosbridgeSettings
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.bridges.token_check import TokenCheck
from homebot.devices.access_messages import ListedToken, ListTokensResponse
from homebot.devices.client_rights import LOCAL_CLIENT, OWNER_CLIENT, ClientRights
from homebot.errors import ConfigError
from homebot.messages.builtin_interfaces import Time
from homebot.support.addresses import is_loopback
from homebot.support.owner_token import OWNER_HEADER, OwnerToken, is_owner_proof

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.access import ClientAccess
    from homebot.bridges.rosbridge.first_code import FirstCode

LOG_IN: Final = Subprotocol("homebot.log_in")
"""The WebSocket subprotocol of homebot's own page, whose first frame is ``{"op": "auth", "token": "…"}``."""

_API: Final = "/api/"
_AGENTS: Final = "/mcp"
_OWN_SITE: Final = frozenset({"same-origin", "none"})
_OF_BROWSERS: Final = (
    "User-Agent",
    "Accept-Encoding",
    "Accept-Language",
    "Cache-Control",
    "Pragma",
    "Sec-Fetch-Site",
    "Sec-WebSocket-Extensions",
)
"""Headers that browsers send beside those of RFC 6455 (Fetch, section 4.6), and no page can leave out; programs of
websocket-client send an ``Origin`` without any of them."""
_PAGE: Final = ""  # the name of a page that has not sent its token yet
_FIRST: Final = "the first code"  # no token can have this name

Site: TypeAlias = "Callable[[str, str, str], Awaitable[tuple[HTTPStatus, Mapping[str, str], bytes] | None]]"
"""Returns status, headers and body for a path and the headers ``If-None-Match`` and ``Accept-Encoding``; None if there
is no such page."""


class Handshake:
    """Checks Host, Origin and token of each request, and serves the files of the page.

    Args:
        local_rights: The rights of clients without a token, unless the settings have a scope for them.
        open_timeout: Seconds within which a page must log in.
        owner: The owner's token, which the command line finds in the data folder; None for none.
        first_code: The code by which a page logs in that has no token yet, as long as there is none; None for none.

    Raises:
        ConfigError: The host is not a loopback address and there is no token.
    """

    def __init__(
        self,
        settings: RosbridgeSettings,
        local_rights: ClientRights,
        shared: SharedState,
        site: Site | None,
        open_timeout: float,
        owner: OwnerToken | None = None,
        first_code: FirstCode | None = None,
    ) -> None:
        self._owner = owner
        self._first_code = first_code
        self._rights = settings.rights(local_rights, has_owner=owner is not None)
        if LOCAL_CLIENT in self._rights and not is_loopback(settings.host):
            raise ConfigError(
                "door",
                "host",
                f"{settings.host} can be reached by others, so it needs a token; set one or listen on 127.0.0.1",
            )
        self._clock = shared.node.graph.clock
        self.tokens = self._token_check(settings)
        self._settings = settings
        self._local_rights = local_rights
        self._shared = shared
        self._site = site
        self._open_timeout = open_timeout
        self._names: WeakKeyDictionary[RosbridgeConnection, str] = WeakKeyDictionary()
        self._used: dict[str, float] = {}
        """When each token was last shown, by name; in seconds since 1970."""

    def update_tokens(self, settings: RosbridgeSettings) -> frozenset[str]:
        """Use the tokens and rights of *settings*; return the names with changes."""
        before = self._clients
        self._rights = settings.rights(self._local_rights, has_owner=self._owner is not None)
        self._settings = self._settings.model_copy(
            update={"token": settings.token, "tokens": settings.tokens, "scope": settings.scope}
        )
        if settings.tokens:
            self._first_code = None
        self.tokens = self._token_check(settings)
        after = self._clients
        return frozenset(name for name, token in before.items() if after.get(name) != token)

    def list_tokens(self, connected: Collection[str], since: float) -> ListTokensResponse:
        """Return all tokens with their rights, and their uses *since*; *connected* are the names of clients."""
        named = self._settings.tokens
        tokens = [
            ListedToken(
                name=name,
                scope=named[name].scope if name in named else (),
                until=0.0 if isinf(end := self._end_of(name)) else end,
                used_at=Time.from_seconds(self._used.get(name, 0.0)),
                is_connected=name in connected,
            )
            for name in self._tokens_of(self._settings)
        ]
        return ListTokensResponse(since=Time.from_seconds(since), tokens=tuple(tokens))

    def seconds_left(self, connection: RosbridgeConnection) -> float:
        """Return the seconds until the token of an admitted client ends; infinite without an end."""
        return self._end_of(self._names[connection]) - self._clock.now()

    def access_of(self, connection: RosbridgeConnection) -> ClientAccess:
        """Return the name and the rights of an admitted client."""
        from homebot.bridges.rosbridge.access import ClientAccess  # noqa: PLC0415 - loaded with the first

        name, request = self._names[connection], connection.request
        is_browser = request is not None and any(header in request.headers for header in _OF_BROWSERS)
        is_page = is_browser and bool(self._unnamed_page(connection, request))
        is_person = request is not None and (
            is_page or (not is_for_api(request) and (name == OWNER_CLIENT or _is_of_own_page(request.headers)))
        )
        owner_file = "" if self._owner is None else str(self._owner.file)
        owners = self._shared.owners()
        return ClientAccess.of(
            name, self._rights[name], owners, is_page=is_page, is_program=not is_person, owner_file=owner_file
        )

    def knows(self, connection: RosbridgeConnection) -> bool:
        """Return whether an admitted client has a name, unlike a page that sends its token later."""
        return self._names[connection] != _PAGE

    async def admit(self, connection: RosbridgeConnection, request: Request) -> Response | None:
        """Return the answer to *request*: a refusal or a file of the page; None to admit the client."""
        headers, is_api, is_web_socket = request.headers, is_for_api(request), is_for_websocket(request)
        if (problem := refusal(self._settings, headers.get_all("Host"), headers.get_all("Origin"))) is not None:
            return self.turn_away(connection, HTTPStatus.FORBIDDEN, problem)
        if not is_api and connection.posted is not None and not connection.posted.is_reading:
            return self.turn_away(
                connection, HTTPStatus.METHOD_NOT_ALLOWED, f"there are only GET and HEAD outside {_API}"
            )
        if not (is_api or is_web_socket) and (file := await self._file(request)) is not None:
            return file
        return await self._admit_client(connection, request, may_be_page=is_web_socket and not is_api)

    async def _admit_client(
        self, connection: RosbridgeConnection, request: Request, *, may_be_page: bool
    ) -> Response | None:
        headers = request.headers
        if may_be_page and _is_of_own_page(headers):
            self._names[connection] = _PAGE
            return None
        token = token_of(headers.get_all("Authorization"), request.path if may_be_page else "")
        if not token and self._is_owner(connection, headers):
            self._names[connection] = OWNER_CLIENT
            self._used[OWNER_CLIENT] = self._clock.now()
            return None
        return await self._check_token(connection, token) or self._check_page(connection, request)

    async def log_in(self, connection: RosbridgeConnection, texts: AsyncIterator[str]) -> bool:
        """Return whether a client may continue; homebot's own page must first send a token, if one is required."""
        if self.knows(connection):
            return True
        token = None
        with anyio.move_on_after(self._open_timeout):
            token = token_in(await anext(texts, ""))
        problem: Response | None = None
        if token is None or (problem := await self._check_token(connection, token, is_page=True)) is not None:
            reason = "the first frame must be an auth" if problem is None else problem.body.decode().strip()
            await connection.close(CloseCode.POLICY_VIOLATION, reason)
            return False
        return True

    def turn_away(self, connection: RosbridgeConnection, status: HTTPStatus, problem: str) -> Response:
        """Count and log a refusal, and return its response."""
        client = address_of(connection)
        self._shared.counters.turned_away += 1
        self._shared.error_log.log(
            f"rejected {client.rpartition(':')[0]}",
            "door.turned_away",
            f"{client} was rejected: {problem}",
            client=client,
            problem=problem,
        )
        if connection.request is not None and is_for_api(connection.request):
            from homebot.bridges.rosbridge.http_requests import problem_body  # noqa: PLC0415 - loaded with the first

            return http_response(*problem_body(status, problem))
        return connection.respond(status, f"{problem}\n")

    def _tokens_of(self, settings: RosbridgeSettings) -> Mapping[str, SecretStr]:
        return settings.all_tokens(None if self._owner is None else SecretStr(self._owner.secret))

    def _token_check(self, settings: RosbridgeSettings) -> TokenCheck:
        code = {} if self._first_code is None else {_FIRST: self._first_code.secret}
        return TokenCheck({**self._tokens_of(settings), **code}, self._clock)

    @property
    def _clients(self) -> Mapping[str, tuple[object, ...]]:
        """Each client's rights, token and end, by name."""
        tokens = self._tokens_of(self._settings)
        return {name: (rights, tokens.get(name), self._end_of(name)) for name, rights in self._rights.items()}

    def _end_of(self, name: str) -> float:
        token = self._settings.tokens.get(name)
        return inf if token is None else token.until

    def _is_owner(self, connection: RosbridgeConnection, headers: Headers) -> bool:
        """Return whether the client proves that it can read the owner's token."""
        if self._owner is None or not (proof := headers.get(OWNER_HEADER)):
            return False
        key, port = headers.get("Sec-WebSocket-Key", ""), connection.local_address[1]
        return is_owner_proof(proof, self._owner.secret, key, port, self._clock.now())

    async def _file(self, request: Request) -> Response | None:
        """Return the file of the page for *request*, or None."""
        etag, encodings = (
            ", ".join(request.headers.get_all(header)) for header in ("If-None-Match", "Accept-Encoding")
        )
        site = self._site and await self._site(request.path, etag, encodings)
        if not site:
            return None
        status, headers, body = site
        return Response(status.value, status.phrase, Headers(headers), body)

    async def _check_token(
        self, connection: RosbridgeConnection, token: str, *, is_page: bool = False
    ) -> Response | None:
        if LOCAL_CLIENT in self._rights and (not token or len(self._rights) == 1):
            self._names[connection] = LOCAL_CLIENT
            return None
        name = await self.tokens.check(address_of(connection).rpartition(":")[0], token)
        if name is None:
            problem = "too many wrong tokens from this address; try again in a second"
            return self.turn_away(connection, HTTPStatus.TOO_MANY_REQUESTS, problem)
        if name == _FIRST:
            name = OWNER_CLIENT if is_page and self._first_code is not None and self._first_code.use() else ""
        elif not name and self._first_code is not None:
            self._first_code.count_wrong()
        if not name:
            return self.turn_away(connection, HTTPStatus.UNAUTHORIZED, "a valid token is needed")
        self._names[connection] = name
        if self.seconds_left(connection) <= 0:
            problem = f"the token has ended; change until in [door.tokens.{name}], or make another"
            return self.turn_away(connection, HTTPStatus.UNAUTHORIZED, problem)
        self._used[name] = self._clock.now()
        return None

    def _check_page(self, connection: RosbridgeConnection, request: Request) -> Response | None:
        """Return the refusal of a web page of another server, or None."""
        headers, problem = request.headers, ""
        if (page := self._unnamed_page(connection, request)) and not is_same_origin(headers["Host"], page):
            problem = f"web pages from {page[:100]!r} need a token; or name them in allowed_origins"
        elif is_for_api(request) and not set(headers.get_all("Sec-Fetch-Site")) <= _OWN_SITE:
            problem = "web pages of other servers may not use the HTTP API"
        return self.turn_away(connection, HTTPStatus.FORBIDDEN, problem) if problem else None

    def _unnamed_page(self, connection: RosbridgeConnection, request: Request | None) -> str:
        """Return the origin of a page without a token that the settings do not allow; empty for other clients."""
        origin = request.headers.get("Origin", "") if request is not None else ""
        is_local = self._names[connection] == LOCAL_CLIENT
        return origin if is_local and origin not in self._settings.allowed_origins else ""


def is_for_api(request: Request) -> bool:
    """Return whether *request* is for the HTTP API, or of an agent."""
    return request.path.startswith(_API) or is_for_agents(request)


def is_for_agents(request: Request) -> bool:
    """Return whether *request* is of an agent, over the Model Context Protocol."""
    return request.path.partition("?")[0] == _AGENTS


def is_for_websocket(request: Request) -> bool:
    """Return whether *request* asks for a WebSocket."""
    return any("websocket" in value.lower() for value in request.headers.get_all("Upgrade"))


def address_of(connection: RosbridgeConnection) -> str:
    """Return the host and the port of a client."""
    host, port = (connection.remote_address or ("unknown", 0))[:2]
    return f"{host}:{port}"


def token_in(frame: str) -> str | None:
    """Return the token in the first *frame* of a page; None if it is no such frame.

    Browsers cannot set headers, and a token in a URL ends in logs and histories.
    """
    try:
        return _LogIn.model_validate_json(frame).token.get_secret_value()
    except ValidationError:
        return None


class _LogIn(BaseModel):
    model_config = ConfigDict(extra="forbid", defer_build=True)

    op: Literal["auth"]
    token: SecretStr


def _is_of_own_page(headers: Headers) -> bool:
    is_same = is_same_origin(headers["Host"], headers.get("Origin", ""))
    return LOG_IN in headers.get("Sec-WebSocket-Protocol", "") and is_same
