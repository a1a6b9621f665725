"""homebot's directory for other programs: lets them in, answers their requests, and announces itself."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from http import HTTPStatus
from secrets import token_hex
from typing import Final, NoReturn

import anyio
from anyio.abc import TaskStatus

from homebot.bridges.admission import refusal, token_of
from homebot.bridges.client_error_log import ClientErrorLog
from homebot.bridges.thing_directory.catalog import ThingCatalog
from homebot.bridges.thing_directory.documents import (
    BEARER,
    PREFLIGHT,
    RequestError,
    directory_description,
    sharing_headers,
)
from homebot.bridges.thing_directory.event_feed import EventFeed
from homebot.bridges.thing_directory.http_server import BoundedServer, HttpExchange
from homebot.bridges.thing_directory.listed_devices import ListedDevices
from homebot.bridges.thing_directory.requests import DirectoryRequests
from homebot.bridges.thing_directory.settings import DirectoryBridgeSettings
from homebot.bridges.token_check import TokenCheck
from homebot.bridges.turns import ServerTurns
from homebot.conventions.payload import compact_json
from homebot.devices.device import KeyValue
from homebot.devices.exposure import NetworkService
from homebot.devices.health import Count, HealthRequest, HealthResponse
from homebot.errors import ConfigError
from homebot.graph import Node
from homebot.support.addresses import is_loopback
from homebot.wot.thing import NO_SECURITY, THING_CHANGES

__all__ = ["ThingDirectoryBridge"]

SERVICE_TYPE: Final = "_wot._tcp"
"""By DNS-SD; W3C Recommendation "Web of Things (WoT) Discovery", section 6.3."""

WELL_KNOWN: Final = "/.well-known/wot"


class ThingDirectoryBridge:
    """A W3C Thing Description Directory of the devices of the house, read only, and the devices themselves over HTTP.

    Each device is a thing with properties that are read and set here, for any protocol.

    Args:
        node: The node that acts in the clients' stead; it must outlive the directory.
        owner: The id of this homebot, which the ids of its things begin with.
        announce: Told of it as a service of the network, when it listens and when it no longer does.

    Raises:
        ConfigError: The host is not a loopback one and there is no token.
    """

    def __init__(
        self,
        node: Node,
        settings: DirectoryBridgeSettings,
        home: str,
        owner: str,
        announce: Callable[[NetworkService], None] = lambda _: None,
    ) -> None:
        if settings.token is None and not is_loopback(settings.host):
            problem = f"{settings.host} can be reached by others, so it needs a token; set one or listen on 127.0.0.1"
            raise ConfigError("thing_directory", "host", problem)
        needs_token = settings.token is not None
        self._settings = settings
        self._announce = announce
        self._error_log = ClientErrorLog(node)
        self._token = {} if settings.token is None else {"token": settings.token}
        self._tokens = TokenCheck(self._token, node.graph.clock)
        self._turns = ServerTurns()
        self._server = BoundedServer(settings, self._handle, node.graph.clock, self._error_log)
        version = token_hex(4)
        catalog = ThingCatalog()
        self._feed = EventFeed(catalog, version)
        self._devices = ListedDevices(
            node,
            catalog,
            owner,
            needs_token=needs_token,
            allows_commands=settings.allows_commands,
            max_devices=settings.max_devices,
            on_change=self._feed.notify,
        )
        described = directory_description(
            f"homebot, {home}", f"urn:homebot:{owner}:", BEARER if needs_token else NO_SECURITY
        )
        self._requests = DirectoryRequests(compact_json(described), self._devices, version)

    @property
    def port(self) -> int:
        """The TCP port; the real one once it listens, also where port 0 was asked for."""
        return self._server.port

    def health(self, _request: HealthRequest) -> HealthResponse:
        """Return the counters and guessing addresses; the answer of the service ``health``."""
        counts = {
            **asdict(self._server.counters),
            "things_listed": len(self._devices.catalog),
            "devices_refused": self._devices.refused,
            "wrong_tokens": self._tokens.wrong,
            "event_clients_overtaken": self._feed.overtaken,
            "event_clients_now": self._feed.clients,
            "clients_now": len(self._server.connections),
        }
        return HealthResponse(counts=Count.each(counts), troubles=self._tokens.problems())

    def update_token(self, settings: DirectoryBridgeSettings) -> None:
        """Use the token of *settings* in place of another, and end the streams of clients with that."""
        token = {} if settings.token is None else {"token": settings.token}
        if token != self._token and token.keys() == self._token.keys():
            self._token.update(token)
            self._feed.close()

    async def run(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled, ``started()`` once it listens; raise UsageError if it cannot listen."""
        async with self._server.listening():
            facts = (KeyValue(key="td", value=WELL_KNOWN), KeyValue(key="type", value="Directory"))
            addresses, port = self._server.addresses, self._server.port
            self._announce(NetworkService(service_type=SERVICE_TYPE, addresses=addresses, port=port, facts=facts))
            try:
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(self._devices.run)
                    task_status.started()
                    await anyio.sleep_forever()
            finally:
                self._announce(NetworkService(service_type=SERVICE_TYPE, is_withdrawn=True))
                self._feed.close()

    async def _handle(self, exchange: HttpExchange) -> None:
        await self._turns.turn()
        shared: Mapping[str, str] = {}
        try:
            self._check_origin(exchange)
            shared = sharing_headers(exchange.headers("Origin"))
            if exchange.method == "OPTIONS" and exchange.headers("Access-Control-Request-Method"):
                answer = PREFLIGHT
            else:
                await self._check_token(exchange)
                if exchange.path[:1] == ("events",):
                    await self._send_events(exchange, shared)
                    return
                answer = await self._requests.answer(exchange)
        except RequestError as exc:
            answer = exc.answer
        headers = {"Cache-Control": "no-cache", "Server": "homebot", **shared, **answer.headers}
        if answer.content_type:
            headers["Content-Type"] = answer.content_type
        await exchange.answer(answer.status, headers, answer.body)

    def _check_origin(self, exchange: HttpExchange) -> None:
        problem = refusal(self._settings, exchange.headers("Host"), exchange.headers("Origin"))
        if problem is not None:
            self._turn_away(exchange, HTTPStatus.FORBIDDEN, problem)

    async def _check_token(self, exchange: HttpExchange) -> None:
        if self._settings.token is None:
            return
        token = token_of(exchange.headers("Authorization"))
        name = await self._tokens.check(exchange.address, token)
        if name is None:
            problem = "too many wrong tokens from this address"
            self._turn_away(exchange, HTTPStatus.TOO_MANY_REQUESTS, problem, Retry_After="1")
        if not name:
            problem = "a valid token is needed"
            self._turn_away(exchange, HTTPStatus.UNAUTHORIZED, problem, WWW_Authenticate="Bearer")

    def _turn_away(self, exchange: HttpExchange, status: HTTPStatus, problem: str, **headers: str) -> NoReturn:
        self._server.counters.turned_away += 1
        self._error_log.log(
            f"rejected {exchange.address}",
            "thing_directory.turned_away",
            f"{exchange.address} was rejected: {problem}",
            client=exchange.address,
            problem=problem,
        )
        raise RequestError(status, problem, **headers)

    async def _send_events(self, exchange: HttpExchange, shared: Mapping[str, str]) -> None:
        if exchange.method != "GET":
            raise RequestError(HTTPStatus.METHOD_NOT_ALLOWED, "events are read", Allow="GET")
        names = THING_CHANGES if len(exchange.path) == 1 else exchange.path[1:]
        if len(exchange.path) > 2 or names[0] not in THING_CHANGES:
            raise RequestError(HTTPStatus.NOT_FOUND, "there are no such events")
        last_id = exchange.headers("Last-Event-ID")
        await exchange.open_stream(
            {"Content-Type": "text/event-stream", "Cache-Control": "no-store", "Server": "homebot", **shared}
        )
        base = exchange.base if exchange.query.get("diff", "").lower() == "true" else ""
        await self._feed.run(exchange, names, last_id[-1] if last_id else "", base)
