"""The embedded broker without sockets: the same state machines as :class:`homebot.mqtt.broker.Broker`, in memory.

It also runs in virtual time: keep-alive, session expiry and delayed wills are then due as soon as there is nothing else
to do.
"""

from collections.abc import Mapping
from random import Random, SystemRandom
from typing import Final, final

import anyio

from homebot.clock import Clock
from homebot.errors import LinkError, UsageError
from homebot.mqtt.broker import BrokerLimits, BrokerPolicy, BrokerState
from homebot.mqtt.broker.embedded import EmbeddedBroker
from homebot.mqtt.client.memory_transport import MemoryLink, MemorySocket
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.client.transport import TransportUser
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import ReasonCode

_HOST: Final = "memory"
_PORT: Final = 1883
_LINKS_PER_CLIENT = 2  # as many as the broker on TCP has sockets


@final
class MemoryBroker(EmbeddedBroker):
    """A broker for 3.1, 3.1.1 and 5 that is only reached by :meth:`dial`; otherwise used like ``Broker``.

    Args:
        clock: As for :class:`EmbeddedBroker`, like all arguments not listed here.
        random: The source of assigned client ids and of its clients' first packet identifiers; seeded for reproducible
            runs.

    Attributes:
        host: A name for options, which does not exist on any network.

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
        policy: BrokerPolicy | None = None,
        random: Random | None = None,
    ) -> None:
        self._client_random = random or SystemRandom()
        super().__init__(clock, limits, credentials, keep_alive, policy, random=self._client_random)
        self._links: dict[MemoryLink, None] = {}
        self._dialled = 0
        self._empty = anyio.Event()

    @property
    def url(self) -> str:
        """Address for the options: ``mqtt://memory:1883``."""
        return f"mqtt://{self.host}:{self.port}"

    @property
    def links(self) -> tuple[MemoryLink, ...]:
        """The open links, oldest first; tests may cut or freeze them."""
        return tuple(self._links)

    def link_of(self, client_id: str) -> MemoryLink:
        """Return the link of a logged-in client.

        Raises:
            UsageError: No such client is connected; the message names those that are.
        """
        by_name = {link.peer.client_id: link for link in self._links if link.peer.client_id is not None}
        if client_id not in by_name:
            raise UsageError(f"no client {client_id!r} is connected; there are: {', '.join(sorted(by_name)) or 'none'}")
        return by_name[client_id]

    def make_client(self, options: MqttOptions) -> NativeClient:
        """Make a client of this broker for :class:`homebot.mqtt.connection.MqttConnection`.

        Raises:
            UsageError: The options ask for TLS, which does not exist in memory.
        """
        if options.tls:
            raise UsageError("a link in memory has no TLS: write mqtt:// instead of mqtts://")
        return NativeClient(options, self._dial_for, clock=self._clock, random=self._client_random)

    def dial(self, host: str, port: int, user: TransportUser) -> MemorySocket:
        """Open a link, without sending anything.

        Raises:
            LinkError: The address is not this broker's, it is not running, or it has too many links.
        """
        if (host, port) != (self.host, self.port):
            raise LinkError(f"nothing answers at {host} port {port}: only {self.url} can be reached in memory")
        state = self._state
        if state is None or not self.running:
            raise LinkError("the connection was refused: the broker in memory is not running")
        if len(self._links) >= _LINKS_PER_CLIENT * self._limits.max_connections:
            state.counters.connections_refused += 1
            raise LinkError("the broker in memory has too many connections")
        state.counters.connections_accepted += 1
        self._dialled += 1
        link = MemoryLink(state, user, f"memory:{self._dialled}", self._on_closed)
        self._links[link] = None
        return link.socket

    async def _dial_for(self, options: MqttOptions, user: TransportUser) -> MemorySocket:
        return self.dial(options.host, options.port, user)

    async def _open(self, state: BrokerState) -> None:
        """Do nothing: links are made by :meth:`dial`."""

    async def _close(self, *, abrupt: bool) -> None:
        for link in self.links:
            if abrupt:
                link.abort()
            link.peer.end(ReasonCode.SERVER_SHUTTING_DOWN, publish_will=False)
        with anyio.CancelScope(shield=True):  # one turn of the loop
            while self._links:
                self._empty = anyio.Event()
                await self._empty.wait()

    def _on_closed(self, link: MemoryLink) -> None:
        self._links.pop(link, None)
        if not self._links:
            self._empty.set()
