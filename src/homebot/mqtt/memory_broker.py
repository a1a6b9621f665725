"""The embedded broker without sockets: the same state machines as :class:`homebot.mqtt.broker.Broker`, in memory.

It runs wherever an event loop does, also where time is virtual: then keep-alive, session expiry and delayed wills
come due as soon as nothing else is to be done.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from random import Random, SystemRandom
from types import TracebackType
from typing import Final, Self, final

import anyio

from homebot.clock import Clock, LoopClock
from homebot.errors import LinkError, UsageError
from homebot.logger import get_logger
from homebot.mqtt.broker import BrokerLimits, BrokerPolicy, BrokerState, BrokerStats
from homebot.mqtt.broker.authentication import Authentication
from homebot.mqtt.broker.limits import checked_keep_alive
from homebot.mqtt.broker.policy import policy_of
from homebot.mqtt.broker.state_timer import HubTimer
from homebot.mqtt.client.memory_transport import MemoryLink, MemorySocket
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.client.transport import TransportUser
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import ReasonCode

__all__ = ["MemoryBroker"]

_HOST: Final = "memory"
_PORT: Final = 1883
_LINKS_PER_CLIENT = 2  # as many as the broker on TCP has sockets
_log = get_logger()


@final
class MemoryBroker:
    """A broker for 3.1, 3.1.1 and 5 that is reached by :meth:`dial` alone; used like ``Broker``.

    Args:
        clock: The time to go by; the loop's by default.
        limits: All bounds.
        credentials: Passwords by user name; None lets everybody in.
        keep_alive: The longest keep-alive interval an MQTT 5 client may have, in seconds.
        refuse_filters: Filters whose subscription is answered with 0x80; only without *policy*.
        policy: Who may publish and subscribe what.
        random: Where assigned client ids and its clients' first packet identifiers come from; a seeded one makes every
            run the same.

    Attributes:
        host: A name to put into options, which nothing on a network answers to.
        port: The usual one.

    Raises:
        UsageError: An argument is out of its range.
    """

    host: Final = _HOST
    port: Final = _PORT

    def __init__(
        self,
        *,
        clock: Clock | None = None,
        limits: BrokerLimits | None = None,
        credentials: Mapping[str, str] | None = None,
        keep_alive: int | None = None,
        refuse_filters: Collection[str] = (),
        policy: BrokerPolicy | None = None,
        random: Random | None = None,
    ) -> None:
        self._clock = clock
        self._limits = limits or BrokerLimits()
        self._authentication = Authentication(credentials)
        self._keep_alive = checked_keep_alive(keep_alive)
        self._policy = policy_of(policy, refuse_filters)
        self._random = random or SystemRandom()
        self._hub: BrokerState | None = None
        self._running = False
        self._links: dict[MemoryLink, None] = {}
        self._dialled = 0
        self._empty = anyio.Event()
        self._timer: HubTimer | None = None

    @property
    def url(self) -> str:
        """Address for the options: ``mqtt://memory:1883``."""
        return f"mqtt://{self.host}:{self.port}"

    @property
    def running(self) -> bool:
        """True if it can be dialled."""
        return self._running

    @property
    def stats(self) -> BrokerStats:
        """A snapshot of all counts; they go on over restarts.

        Raises:
            UsageError: The broker was never started.
        """
        if self._hub is None:
            raise UsageError("the broker was never started")
        return self._hub.stats

    @property
    def links(self) -> tuple[MemoryLink, ...]:
        """The open links, oldest first; a test may cut or freeze them."""
        return tuple(self._links)

    def link_of(self, client_id: str) -> MemoryLink:
        """The link of a logged-in client.

        Raises:
            UsageError: No such client is connected; names those that are.
        """
        by_name = {link.peer.client_id: link for link in self._links if link.peer.client_id is not None}
        if client_id not in by_name:
            raise UsageError(f"no client {client_id!r} is connected; there are: {', '.join(sorted(by_name)) or 'none'}")
        return by_name[client_id]

    def make_client(self, options: MqttOptions) -> NativeClient:
        """Make a client of this broker, as :class:`homebot.mqtt.connection.MqttConnection` asks for it.

        Raises:
            UsageError: The options ask for TLS, which there is not in memory.
        """
        if options.tls:
            raise UsageError("a link in memory has no TLS: write mqtt:// instead of mqtts://")
        return NativeClient(options, self._dial_for, clock=self._clock, random=self._random)

    def dial(self, host: str, port: int, user: TransportUser) -> MemorySocket:
        """Open a link; nothing is said on it yet.

        Raises:
            LinkError: The address is not this broker's, it is not running, or it has too many links.
        """
        if (host, port) != (self.host, self.port):
            raise LinkError(f"nothing answers at {host} port {port}: only {self.url} can be reached in memory")
        hub = self._hub
        if hub is None or not self._running:
            raise LinkError("the connection was refused: the broker in memory is not running")
        if len(self._links) >= _LINKS_PER_CLIENT * self._limits.max_connections:
            hub.counters.connections_refused += 1
            raise LinkError("the broker in memory has too many links")
        hub.counters.connections_accepted += 1
        self._dialled += 1
        link = MemoryLink(hub, user, f"memory:{self._dialled}", self._closed)
        self._links[link] = None
        return link.socket

    async def _dial_for(self, options: MqttOptions, user: TransportUser) -> MemorySocket:
        return self.dial(options.host, options.port, user)

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.stop()

    async def start(self) -> None:
        """Take links, with the sessions and retained messages that :meth:`stop` left."""
        if self._running:
            return
        if self._hub is None:
            clock = self._clock or LoopClock()
            self._hub = BrokerState(
                clock, self._limits, self._authentication, self._policy, self._keep_alive, random=self._random
            )
        self._running = True
        self._timer = HubTimer(self._hub)
        self._timer.start()
        _log.debug("broker.listening", url=self.url)

    async def stop(self, *, abrupt: bool = False) -> None:
        """Close all links; sessions and retained messages stay for the next start.

        Wills of the clients cut off are not published: there is nobody to hear them.

        Args:
            abrupt: As if the process were killed: no DISCONNECT, what is under way is lost.
        """
        hub = self._hub
        if hub is None or not self._running:
            return
        self._running = False
        for link in self.links:
            if abrupt:
                link.abort()
            link.peer.end(ReasonCode.SERVER_SHUTTING_DOWN, publish_will=False)
        with anyio.CancelScope(shield=True):  # one turn of the loop
            while self._links:
                self._empty = anyio.Event()
                await self._empty.wait()
        if self._timer is not None:
            self._timer.stop()
            self._timer = None
        _log.debug("broker.stopped", url=self.url)

    async def restart(self, *, keep_sessions: bool, abrupt: bool = False) -> None:
        """Stop, and start again.

        Args:
            keep_sessions: Whether sessions, their queues and the retained messages live on.
            abrupt: As in :meth:`stop`.
        """
        await self.stop(abrupt=abrupt)
        if not keep_sessions and self._hub is not None:
            self._hub.forget()
        await self.start()

    def _closed(self, link: MemoryLink) -> None:
        self._links.pop(link, None)
        if not self._links:
            self._empty.set()
