"""The embedded broker: :class:`BrokerState` on a TCP port."""

from __future__ import annotations

import asyncio
import errno
import socket
import ssl
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final, final

import anyio

from homebot.clock import Clock
from homebot.errors import LinkError, UsageError
from homebot.mqtt.broker.connection import BrokerConnection, Sockets
from homebot.mqtt.broker.deadlines import Deadline
from homebot.mqtt.broker.embedded import EmbeddedBroker
from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.peer import Peer
from homebot.mqtt.broker.ports import BrokerPolicy, ConnectionHandler, Transport
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.stats import LossReport
from homebot.mqtt.packets import ReasonCode
from homebot.support.addresses import ip_version, is_loopback
from homebot.support.listening import stop_accepting

if TYPE_CHECKING:
    from homebot.mqtt.broker.tls_socket import TlsSocket

_BACKLOG = 512
_REPORT_INTERVAL: Final = 10.0  # seconds between reports of losses
_ACCEPTED_IN_A_TURN = 16  # asyncio accepts as many per turn of the loop


class PortTakenError(LinkError):
    """Another program uses the port."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(
            f"port {port} of {host} is taken by another program; stop that one, or choose another port (0: any free)"
        )
        self.port = port


@final
class Broker(EmbeddedBroker):
    """An MQTT broker for 3.1, 3.1.1 and 5 in this process and event loop.

    ``async with broker:`` listens inside the block; after it the port is free and every connection closed. Starting
    raises :class:`PortTakenError` if another program uses the port, and :class:`LinkError` if listening on the address
    fails; stopping waits at most ``limits.stop_timeout`` seconds for the sockets.

    Args:
        host: Address to listen on; other than loopback only with *credentials*.
        port: TCP port; 0 takes any free one and keeps it for later starts.
        clock: As for :class:`EmbeddedBroker`, like all arguments not listed here.
        endpoint: Creates the endpoint of one connection; to wrap each :class:`Peer`.

    Raises:
        UsageError: The address is not loopback and there is no password, or an argument is out of range.
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
        super().__init__(clock, limits, credentials, keep_alive, policy, on_message)
        self._host = host
        self._port = port
        self._tls = tls
        self._endpoint = endpoint
        self._server: asyncio.Server | None = None
        self._sockets = Sockets(self._limits.max_all_unsent_bytes)
        self._losses: LossReport | None = None
        self._next_report: Deadline | None = None

    def __repr__(self) -> str:
        return f"Broker({self.url!r})"

    @property
    def host(self) -> str:
        """The address on which it listens."""
        return self._host

    @property
    def port(self) -> int:
        """The TCP port; 0 before the first start if any was requested."""
        return self._port

    @property
    def url(self) -> str:
        """Address for clients, such as ``mqtt://127.0.0.1:1883``."""
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"{'mqtt' if self._tls is None else 'mqtts'}://{host}:{self._port}"

    @property
    def losses(self) -> str:
        """Messages lost in the last ten minutes, in words; empty if there were none, or while stopped."""
        return "" if self._losses is None else self._losses.recent

    async def _open(self, state: BrokerState) -> None:
        loop = asyncio.get_running_loop()
        try:
            version = ip_version(self._host)
            if version is None:
                infos = await loop.getaddrinfo(self._host, self._port, type=socket.SOCK_STREAM)
                family, address = infos[0][0], infos[0][4]
            else:
                family, address = socket.AF_INET if version == 4 else socket.AF_INET6, (self._host, self._port)
            sock = socket.socket(family, socket.SOCK_STREAM)
            try:
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                sock.setblocking(False)  # noqa: FBT003 - socket's own signature
                sock.bind(address)
            except OSError:
                sock.close()
                raise
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise PortTakenError(self._host, self._port) from error
            raise LinkError(f"cannot listen on {self._host} port {self._port}: {error.strerror}") from error
        self._port = sock.getsockname()[1]
        self._server = await loop.create_server(
            lambda: self._new_connection(state, loop), sock=sock, backlog=_ACCEPTED_IN_A_TURN
        )
        sock.listen(_BACKLOG)
        self._losses = LossReport(state.counters)
        self._plan_report(state)

    async def _close(self, *, abrupt: bool) -> None:
        if self._server is not None:
            await stop_accepting(self._server.sockets)
            self._server.close()
        for connection in self._sockets:
            if abrupt:
                connection.abort()
            connection.end(ReasonCode.SERVER_SHUTTING_DOWN)
        with anyio.move_on_after(self._limits.stop_timeout):
            await self._sockets.wait_until_gone()
        for connection in self._sockets:
            connection.abort()
        await self._sockets.wait_until_gone()
        self._losses = None
        if self._next_report is not None:
            self._next_report.cancel()

    def _plan_report(self, state: BrokerState) -> None:
        when = state.clock.monotonic() + _REPORT_INTERVAL
        self._next_report = state.deadlines.at(when, lambda: self._report_losses(state))

    def _report_losses(self, state: BrokerState) -> None:
        if self._losses is not None and (lost := self._losses.next()):
            state.warn("broker.dropped", f"the broker dropped {lost} in the last {_REPORT_INTERVAL:g} s")
        self._plan_report(state)

    def _new_connection(self, state: BrokerState, loop: asyncio.AbstractEventLoop) -> BrokerConnection | TlsSocket:
        connection = BrokerConnection(state, loop, self._sockets, self._endpoint)
        if self._tls is None:
            return connection
        from homebot.mqtt.broker.tls_socket import TlsSocket  # noqa: PLC0415 - few brokers in a process use TLS

        return TlsSocket(self._tls, connection, connection.report_tls_failure)
