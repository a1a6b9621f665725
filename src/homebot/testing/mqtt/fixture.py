"""What the fixtures ``mqtt_broker``, ``mqtt_broker_session`` and ``mqtt_broker_thread`` give to a test.

The broker lives on a thread and loop of its own, so it serves whatever loop, or none, a test has, and a test that
blocks its loop does not silence it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import final

import anyio
import anyio.lowlevel

from homebot.mqtt.packets import NO_PROPERTIES, Properties, ReasonCode
from homebot.mqtt.topics import validate_filter
from homebot.testing.mqtt.core import BrokerCore, ClientView
from homebot.testing.mqtt.faults import Fault, FaultRules
from homebot.testing.mqtt.packet_log import PacketLog
from homebot.testing.mqtt.seen import Payload, SeenMessage, Wanted
from homebot.testing.mqtt.thread import BrokerThread

__all__ = ["BlockingFaults", "BlockingTestBroker", "Faults", "TestBroker"]

_CALM_ROUNDS = 3  # of both loops without a packet: an answer needs one
_PATIENCE = 5.0


class _Side:
    """What both ways to use the broker share."""

    def __init__(self, core: BrokerCore, thread: BrokerThread) -> None:
        self._core = core
        self._thread = thread


class _RuleSide(_Side):
    """The faults that are rules."""

    @property
    def _rules(self) -> FaultRules:
        return self._core.rules

    def drop_acks(self, client: str | None = None) -> Fault:
        """Let PUBACK, PUBREC and PUBCOMP vanish on their way to the client (None: to everybody)."""
        return self._rules.drop_acks(client)

    def delay_acks(self, seconds: float, client: str | None = None) -> Fault:
        """Let PUBACK, PUBREC and PUBCOMP come *seconds* late."""
        return self._rules.delay_acks(seconds, client)

    def half_packet(self, client: str | None = None) -> Fault:
        """Cut the next packet to the client in the middle and close its connection."""
        return self._rules.half_packet(client)

    def slow_reader(self, client: str | None = None) -> Fault:
        """Let the client take no bytes until the fault is lifted; then it gets all that waited."""
        return self._rules.slow_reader(client)

    def refuse_subscribe(
        self,
        filter: str,  # noqa: A002 - the protocol's own word
        client: str | None = None,
        reason: ReasonCode = ReasonCode.NOT_AUTHORIZED,
    ) -> Fault:
        """Answer subscriptions to exactly this filter with *reason*."""
        return self._rules.refuse_subscribe(filter, client, reason)

    def refuse_publish(
        self,
        filter: str,  # noqa: A002 - the protocol's own word
        client: str | None = None,
        reason: ReasonCode = ReasonCode.NOT_AUTHORIZED,
    ) -> Fault:
        """Do not forward messages on topics that match; answer with *reason*, before MQTT 5 with success."""
        return self._rules.refuse_publish(filter, client, reason)

    def lift_all(self) -> None:
        """End every fault."""
        self._rules.lift_all()


@final
class Faults(_RuleSide):
    """What can go wrong. Rules hold until lifted, or to the end of their ``with``; the others happen at once."""

    async def drop_connection(self, client: str) -> None:
        """Close the client's connection without a DISCONNECT; its will is published.

        Raises:
            UsageError: It is not connected.
        """
        await self._thread.run(self._core.drop, client)

    async def disconnect(self, client: str, reason: ReasonCode = ReasonCode.ADMINISTRATIVE_ACTION) -> None:
        """Send the client away; one that speaks MQTT 5 is told *reason*.

        Raises:
            UsageError: It is not connected.
        """
        await self._thread.run(self._core.disconnect, client, reason)

    async def take_over(self, client: str) -> None:
        """Send the client away as when another one connects with its id (0x8E).

        Raises:
            UsageError: It is not connected.
        """
        await self.disconnect(client, ReasonCode.SESSION_TAKEN_OVER)


@final
class BlockingFaults(_RuleSide):
    """:class:`Faults` for tests without an event loop."""

    def drop_connection(self, client: str) -> None:
        """As :meth:`Faults.drop_connection`."""
        self._thread.call(self._core.drop, client)

    def disconnect(self, client: str, reason: ReasonCode = ReasonCode.ADMINISTRATIVE_ACTION) -> None:
        """As :meth:`Faults.disconnect`."""
        self._thread.call(self._core.disconnect, client, reason)

    def take_over(self, client: str) -> None:
        """As :meth:`Faults.take_over`."""
        self.disconnect(client, ReasonCode.SESSION_TAKEN_OVER)


class _BrokerSide(_Side):
    """What needs no waiting."""

    __test__ = False  # no collection of tests, whatever the name

    @property
    def host(self) -> str:
        """The loopback address it listens on."""
        return self._core.broker.host

    @property
    def port(self) -> int:
        """The TCP port; stays the same over :meth:`restart`."""
        return self._core.broker.port

    @property
    def url(self) -> str:
        """Such as ``mqtt://127.0.0.1:34567``."""
        return self._core.broker.url

    @property
    def clients(self) -> Mapping[str, ClientView]:
        """The clients the broker knows now by their ids; those away too, while their session is kept."""
        return self._core.clients

    @property
    def packet_log(self) -> PacketLog:
        """The newest packets, which pytest prints when the test fails."""
        return self._core.log

    def forget_messages(self) -> None:
        """Forget what clients have published so far; for a broker that several tests share."""
        self._core.journal.clear()

    def assert_not_published(self, filter: str) -> None:  # noqa: A002 - the protocol's own word
        """Make sure that no client has published on *filter*, messages taken by ``expect`` aside.

        Call ``settle`` first: this looks only at what the broker has got.

        Raises:
            AssertionError: One has; shows the messages.
            InvalidNameError: *filter* is no topic filter.
        """
        validate_filter(filter)
        came = self._core.journal.waiting(filter)
        if came:
            raise AssertionError("\n".join([f"{len(came)} published on {filter}:", *(f"    {each}" for each in came)]))


@final
class TestBroker(_BrokerSide):
    """A real MQTT broker for one test, watched and ready to fail on demand.

    Attributes:
        faults: What can go wrong.
    """

    def __init__(self, core: BrokerCore, thread: BrokerThread) -> None:
        super().__init__(core, thread)
        self.faults = Faults(core, thread)

    async def publish(
        self,
        topic: str,
        payload: Payload = b"",
        qos: int = 0,
        retain: bool = False,  # noqa: FBT001, FBT002 - as every MQTT library has it
        properties: Properties = NO_PROPERTIES,
    ) -> None:
        """Publish from outside; returns when the broker has forwarded it. ``expect`` does not see it.

        Args:
            topic: Topic name.
            payload: Bytes as they are, text as UTF-8, a dict or list as JSON.
            qos: 0, 1 or 2.
            retain: Whether the broker keeps it for later subscribers.
            properties: MQTT 5 properties.

        Raises:
            UsageError: The topic or *qos* is not valid.
            LinkError: A subscriber's queue is full, or there is no room to retain.
        """
        await self._thread.run(self._core.publish, topic, payload, qos, retain, properties)

    async def expect(self, filter: str, payload: Wanted = None, timeout: float = 1.0) -> SeenMessage:  # noqa: A002, ASYNC109 - the words that users look for
        """Return the first message of a client that fits and was not returned before; wait for it if need be.

        Args:
            filter: Topic filter.
            payload: None for any; bytes or text to be equal; a dict or list to be equal as JSON; or a function
                that is given the :class:`SeenMessage`, on the broker's thread, and says whether this is it.
            timeout: Seconds to wait.

        Raises:
            AssertionError: None came; shows what came instead.
            InvalidNameError: *filter* is no topic filter.
        """
        validate_filter(filter)
        journal = self._core.journal
        found = await self._thread.run(journal.take, filter, payload, timeout)
        if found is None:
            __tracebackhide__ = True  # pytest then points at the test's line
            raise AssertionError(journal.near_misses(filter, payload, timeout))
        return found

    async def settle(self, quiet: float = 0.0) -> None:
        """Return when the broker and everything on the test's own loop have come to rest.

        Timers are not waited for, and of clients on other threads or in other processes nothing is known: give
        *quiet* for those.

        Args:
            quiet: Return only after so many seconds without any packet.

        Raises:
            AssertionError: There was no rest within 5 seconds.
        """
        with anyio.move_on_after(_PATIENCE + quiet):
            await self._come_to_rest()
            if quiet > 0:
                await self._thread.run(self._core.silence, quiet)
            return
        raise AssertionError(f"the clients did not come to rest within {_PATIENCE:g} s")

    async def restart(self, *, keep_sessions: bool) -> None:
        """Cut all connections and start again on the same port.

        Args:
            keep_sessions: Whether sessions, their queues and retained messages live on.
        """
        await self._thread.run(self._core.restart, keep_sessions)

    async def _come_to_rest(self) -> None:
        calm = 0
        while calm < _CALM_ROUNDS:
            before = self._core.log.total
            await self._core.turn()  # the same number of turns on this loop
            await self._thread.run(self._core.turn)
            calm = calm + 1 if self._core.log.total == before else 0


@final
class BlockingTestBroker(_BrokerSide):
    """:class:`TestBroker` for tests without an event loop; every method blocks instead of being awaited.

    Attributes:
        faults: What can go wrong.
    """

    def __init__(self, core: BrokerCore, thread: BrokerThread) -> None:
        super().__init__(core, thread)
        self.faults = BlockingFaults(core, thread)

    def publish(
        self,
        topic: str,
        payload: Payload = b"",
        qos: int = 0,
        retain: bool = False,  # noqa: FBT001, FBT002 - as every MQTT library has it
        properties: Properties = NO_PROPERTIES,
    ) -> None:
        """As :meth:`TestBroker.publish`."""
        self._thread.call(self._core.publish, topic, payload, qos, retain, properties)

    def expect(self, filter: str, payload: Wanted = None, timeout: float = 1.0) -> SeenMessage:  # noqa: A002 - as above
        """As :meth:`TestBroker.expect`."""
        validate_filter(filter)
        journal = self._core.journal
        found = self._thread.call(journal.take, filter, payload, timeout)
        if found is None:
            __tracebackhide__ = True  # as above
            raise AssertionError(journal.near_misses(filter, payload, timeout))
        return found

    def settle(self, quiet: float = 0.05) -> None:
        """Return after *quiet* seconds without any packet.

        Raises:
            AssertionError: There was no rest within 5 seconds.
        """
        self._thread.call(self._settle, quiet)

    def restart(self, *, keep_sessions: bool) -> None:
        """As :meth:`TestBroker.restart`."""
        self._thread.call(self._core.restart, keep_sessions)

    async def _settle(self, quiet: float) -> None:
        with anyio.move_on_after(_PATIENCE + quiet):
            await self._core.silence(quiet)
            return
        raise AssertionError(f"the clients did not come to rest within {_PATIENCE:g} s")
