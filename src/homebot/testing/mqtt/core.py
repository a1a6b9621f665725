"""The broker of a test with its observers; everything here runs on the broker's own loop."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Self, final

import anyio
import anyio.lowlevel

from homebot.errors import LinkError, UsageError
from homebot.mqtt.broker import Broker, BrokerState, RefusedFilters, Transport
from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.session import BrokerSession
from homebot.mqtt.packets import Packet, Properties, ReasonCode
from homebot.mqtt.topics import validate_topic
from homebot.testing.mqtt.faults import Fault, FaultPolicy, FaultRules
from homebot.testing.mqtt.journal import Journal, Payload, PulseEvent, encode_payload
from homebot.testing.mqtt.packet_log import PROTOCOL_NAMES, PacketLog, ViolationLog
from homebot.testing.mqtt.settings import BrokerSettings, TestTls
from homebot.testing.mqtt.tap import Tap, TapDuties

_TURNS = 10  # of a loop: reading, handling and writing take four; a client may hand a message on a few times


@dataclass(frozen=True, slots=True)
class ClientView:
    """A snapshot of a client of the broker.

    Attributes:
        protocol: ``3.1``, ``3.1.1`` or ``5``; None while it is away.
    """

    client_id: str
    connected: bool
    subscriptions: frozenset[str]
    protocol: str | None
    queued: int

    @classmethod
    def of(cls, session: BrokerSession) -> Self:
        """Take a snapshot of a session."""
        outbound = session.outbound
        return cls(
            session.client_id,
            outbound is not None,
            frozenset(session.subscriptions.copy()),
            None if outbound is None else PROTOCOL_NAMES[outbound.version],
            session.queued,
        )


@final
class BrokerCore:
    """A broker with journal, packet log and faults. Create it on its own loop.

    Attributes:
        ca_file: The authority for clients to trust; None without TLS.

    Raises:
        UsageError: The settings ask for TLS without *tls*.
    """

    def __init__(self, settings: BrokerSettings, tls: TestTls | None = None) -> None:
        if settings.tls and tls is None:
            raise UsageError("a broker with TLS needs a certificate: give it a TestTls")
        loop = asyncio.get_running_loop()
        self.settings = settings
        self.ca_file = tls.ca_file if tls is not None and settings.tls else None
        self.breaches = ViolationLog()
        self.journal = Journal()
        self.log = PacketLog(loop.time)
        self.rules = FaultRules(self._fault_lifted)
        self._loop = loop
        self._stir = PulseEvent()
        self._taps: set[Tap] = set()
        duties = TapDuties(self.rules, self._record, self.breaches.record, self._taps)

        def endpoint(state: BrokerState, link: Transport) -> Tap:
            return Tap(duties, state, link)

        self.broker = Broker(
            limits=settings.limits,
            credentials=settings.credentials,
            tls=tls.context if tls is not None and settings.tls else None,
            keep_alive=settings.keep_alive,
            policy=FaultPolicy(self.rules, RefusedFilters(settings.refused_filters)),
            endpoint=endpoint,
            on_message=self.journal.record,
        )

    @property
    def clients(self) -> dict[str, ClientView]:
        """All sessions; readable from any thread."""
        return {session.client_id: ClientView.of(session) for session in tuple(self.broker.state.sessions)}

    async def publish(self, topic: str, payload: Payload, qos: int, retain: bool, properties: Properties) -> None:  # noqa: FBT001 - handed on by position
        """Send a message to all subscribers of *topic*, as from an invisible client.

        Raises:
            InvalidNameError: *topic* is no topic name.
            UsageError: *qos* is not 0, 1 or 2.
            LinkError: A subscriber's queue is full, or there is no room for one more retained message.
        """
        validate_topic(topic)
        if qos not in (0, 1, 2):
            raise UsageError(f"QoS is 0, 1 or 2, not {qos}")
        state = self.broker.state
        interval = properties.message_expiry_interval
        expires_at = None if interval is None else state.clock.monotonic() + interval
        message = BrokerMessage(topic, encode_payload(payload), qos, retain, properties, "", expires_at)
        self._record("note", "the test", f"publishes {len(message.payload)} bytes on {topic}, QoS {qos}")
        receipt = state.exchange.publish(message)
        if receipt.reason.failed:
            raise LinkError(f"the broker had no room for the message on {topic}: {receipt.reason.text}")

    async def turn(self) -> None:
        """Run the loop until all bytes in the sockets are handled."""
        for _ in range(_TURNS):
            await anyio.lowlevel.checkpoint()

    async def silence(self, seconds: float) -> None:
        """Return when there has been no packet for *seconds*."""
        while True:
            with anyio.move_on_after(seconds) as scope:
                await self._stir.wait()
            if scope.cancelled_caught:
                return

    async def restart(self, keep_sessions: bool) -> None:  # noqa: FBT001 - handed on by position
        """Stop and start on the same port."""
        self._record("note", "the broker", f"restarts, sessions {'kept' if keep_sessions else 'forgotten'}")
        await self.broker.restart(keep_sessions=keep_sessions)

    async def drop(self, client: str) -> None:
        """Close a client's connection without a DISCONNECT."""
        self._each(client, Tap.drop)

    async def disconnect(self, client: str, reason: ReasonCode) -> None:
        """Disconnect a client with *reason*."""
        self._each(client, lambda tap: tap.end(reason))

    def _each(self, client: str, act: Callable[[Tap], None]) -> None:
        if client not in self.broker.state.peers:
            known = ", ".join(sorted(self.broker.state.peers)) or "nobody"
            raise UsageError(f"no client {client!r} is connected; connected: {known}")
        for tap in [own_tap for own_tap in self._taps if own_tap.client_id == client]:
            act(tap)

    def _record(self, direction: Literal["in", "out", "note"], client: str, what: Packet | str) -> None:
        self.log.add(direction, client, what)
        self._stir.ring()

    def _fault_lifted(self, _fault: Fault) -> None:
        self._loop.call_soon_threadsafe(self._unstall)

    def _unstall(self) -> None:
        for tap in list(self._taps):
            tap.unstall()
