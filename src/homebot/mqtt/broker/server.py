"""The embedded broker: :class:`BrokerState` on a TCP port."""

from __future__ import annotations

import asyncio
import errno
import ipaddress
import socket
import ssl
from collections.abc import Callable, Collection, Mapping
from types import TracebackType
from typing import Self, final

import anyio

from homebot.clock import Clock, LoopClock
from homebot.errors import LinkError, UsageError
from homebot.logger import get_logger
from homebot.mqtt.broker.authentication import Authentication, is_loopback
from homebot.mqtt.broker.connection import BrokerConnection
from homebot.mqtt.broker.connection_handler import ConnectionHandler
from homebot.mqtt.broker.housekeeping import Housekeeping
from homebot.mqtt.broker.limits import BrokerLimits, checked_keep_alive
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.peer import Peer
from homebot.mqtt.broker.policy import BrokerPolicy, policy_of
from homebot.mqtt.broker.sockets import Sockets
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.state_timer import HubTimer
from homebot.mqtt.broker.stats import BrokerStats
from homebot.mqtt.broker.tls_socket import TlsSocket
from homebot.mqtt.broker.transport import Transport
from homebot.mqtt.packets import ReasonCode

__all__ = ["Broker", "PortTakenError"]

_BACKLOG = 512
_ACCEPTED_IN_A_TURN = 16  # asyncio takes as many in one turn of the loop as it is told to let wait
_log = get_logger()


class PortTakenError(LinkError):
    """Another program listens on the port.

    Attributes:
        port: The port that was asked for.
    """

    def __init__(self, host: str, port: int) -> None:
        super().__init__(
            f"port {port} of {host} is taken by another program; stop that one, or choose another port (0: any free)"
        )
        self.port = port


@final
class Broker:
    """A real MQTT broker for 3.1, 3.1.1 and 5 in this process and on this event loop.

    ``async with broker:`` listens inside the block; after it the port is free and every connection closed.
    Nothing is written to disk.

    Args:
        host: Address to listen on; other than loopback only with *credentials*.
        port: TCP port; 0 takes any free one and keeps it for later starts.
        clock: The time to go by; the loop's by default.
        limits: All bounds.
        credentials: Passwords by user name; None lets everybody in.
        tls: Speak TLS with this server-side context.
        keep_alive: The longest keep-alive interval an MQTT 5 client may have, in seconds; a longer one, or none,
            is replaced.
        refuse_filters: Filters whose subscription is answered with 0x80; only without *policy*.
        policy: Who may publish and subscribe what.
        endpoint: Makes what understands the bytes of one connection; to put something around each :class:`Peer`.
        on_message: Told of each message that is forwarded, wills included; must not raise.

    Raises:
        UsageError: The address is not loopback and there is no password, or an argument is out of its range.
    """

    def __init__(
        self,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        clock: Clock | None = None,
        limits: BrokerLimits | None = None,
        credentials: Mapping[str, str] | None = None,
        tls: ssl.SSLContext | None = None,
        keep_alive: int | None = None,
        refuse_filters: Collection[str] = (),
        policy: BrokerPolicy | None = None,
        endpoint: Callable[[BrokerState, Transport], ConnectionHandler] = Peer,
        on_message: Callable[[BrokerMessage], None] | None = None,
    ) -> None:
        if not credentials and not is_loopback(host):
            raise UsageError(
                f"a broker on {host} can be reached by others: give it user and password, or listen on 127.0.0.1"
            )
        if not 0 <= port <= 65_535:
            raise UsageError(f"{port} is not a TCP port")
        self._host = host
        self._port = port
        self._clock = clock
        self._limits = limits or BrokerLimits()
        self._authentication = Authentication(credentials)
        self._tls = tls
        self._keep_alive = checked_keep_alive(keep_alive)
        self._policy = policy_of(policy, refuse_filters)
        self._endpoint = endpoint
        self._on_message = on_message
        self._hub: BrokerState | None = None
        self._server: asyncio.Server | None = None
        self._sockets = Sockets()
        self._timer: HubTimer | None = None
        self._housekeeping: Housekeeping | None = None

    def __repr__(self) -> str:
        return f"Broker({self.url!r})"

    @property
    def host(self) -> str:
        """The address it listens on."""
        return self._host

    @property
    def port(self) -> int:
        """The TCP port; 0 before the first start where any was asked for."""
        return self._port

    @property
    def url(self) -> str:
        """Address for clients, such as ``mqtt://127.0.0.1:1883``."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"{'mqtt' if self._tls is None else 'mqtts'}://{host}:{self._port}"

    @property
    def running(self) -> bool:
        """True while it listens."""
        return self._server is not None

    @property
    def stats(self) -> BrokerStats:
        """A snapshot of all counts; they go on over restarts.

        Raises:
            UsageError: The broker was never started.
        """
        return self.hub.stats

    @property
    def losses(self) -> str:
        """Messages that were lost in the last ten minutes, as text; empty where none was, or it does not run."""
        return "" if self._housekeeping is None else self._housekeeping.losses

    @property
    def hub(self) -> BrokerState:
        """The broker's state; it stays over restarts.

        Raises:
            UsageError: The broker was never started.
        """
        if self._hub is None:
            raise UsageError("the broker was never started")
        return self._hub

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.stop()

    async def start(self) -> None:
        """Listen, with the sessions and retained messages that :meth:`stop` left; nothing where it listens already.

        Raises:
            PortTakenError: Another program has the port.
            LinkError: The address cannot be listened on.
        """
        if self._server is not None:
            return
        loop = asyncio.get_running_loop()
        if self._hub is None:
            clock = self._clock or LoopClock()
            self._hub = BrokerState(
                clock, self._limits, self._authentication, self._policy, self._keep_alive, self._on_message
            )
        hub = self._hub
        try:
            sock = await self._bind(loop)
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise PortTakenError(self._host, self._port) from error
            raise LinkError(f"cannot listen on {self._host} port {self._port}: {error.strerror}") from error
        self._port = sock.getsockname()[1]
        self._server = await loop.create_server(
            lambda: self._new_connection(hub, loop), sock=sock, backlog=_ACCEPTED_IN_A_TURN
        )
        sock.listen(_BACKLOG)
        self._timer = HubTimer(hub)
        self._timer.start()
        self._housekeeping = Housekeeping(hub)
        self._housekeeping.start()
        _log.debug("broker.listening", url=self.url)

    async def stop(self, *, abrupt: bool = False) -> None:
        """Close all connections and free the port; sessions and retained messages stay for the next start.

        Wills of the clients cut off are not published: there is nobody to hear them.

        Args:
            abrupt: As if the process were killed: no DISCONNECT, buffers thrown away. Otherwise MQTT 5 clients
                get a DISCONNECT with 0x8B, and at most ``limits.stop_timeout`` seconds are waited for the sockets.
        """
        server, self._server = self._server, None
        if server is None or self._hub is None:
            return
        server.close()
        for connection in self._sockets:
            if abrupt:
                connection.abort()
            connection.end(ReasonCode.SERVER_SHUTTING_DOWN)
        with anyio.move_on_after(self._limits.stop_timeout):
            await self._sockets.wait_until_gone()
        for connection in self._sockets:
            connection.abort()
        await self._sockets.wait_until_gone()
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        if self._housekeeping is not None:
            self._housekeeping.stop()
            self._housekeeping = None
        _log.debug("broker.stopped", url=self.url)

    async def restart(self, *, keep_sessions: bool, abrupt: bool = False) -> None:
        """Stop, and start again on the same port.

        Args:
            keep_sessions: Whether sessions, their queues and the retained messages live on.
            abrupt: As in :meth:`stop`.
        """
        await self.stop(abrupt=abrupt)
        if not keep_sessions and self._hub is not None:
            self._hub.forget()
        await self.start()

    def tick(self) -> None:
        """Do what is due by the clock; needed only by those who move a clock of their own by hand."""
        if self._timer is not None:
            self._timer.tick()

    def _new_connection(self, hub: BrokerState, loop: asyncio.AbstractEventLoop) -> BrokerConnection | TlsSocket:
        connection = BrokerConnection(hub, loop, self._sockets, self._endpoint)
        return connection if self._tls is None else TlsSocket(self._tls, connection, connection.note_bad_tls)

    async def _bind(self, loop: asyncio.AbstractEventLoop) -> socket.socket:
        family, address = await self._resolve(loop)
        sock = socket.socket(family, socket.SOCK_STREAM)
        try:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            sock.setblocking(False)  # noqa: FBT003 - socket's own signature
            sock.bind(address)
        except OSError:
            sock.close()
            raise
        return sock

    async def _resolve(self, loop: asyncio.AbstractEventLoop) -> tuple[int, tuple[object, ...]]:
        try:
            literal = ipaddress.ip_address(self._host)
        except ValueError:
            infos = await loop.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)
            return infos[0][0], infos[0][4]
        family = socket.AF_INET if literal.version == 4 else socket.AF_INET6
        return family, (self._host, self._port)
