"""The values of the fixtures ``mqtt_broker``, ``mqtt_broker_session`` and ``mqtt_broker_thread``."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TypeVar, final

import anyio

from homebot.mqtt.packets import NO_PROPERTIES, Properties
from homebot.mqtt.topics import validate_filter
from homebot.testing.mqtt.core import BrokerCore, ClientView
from homebot.testing.mqtt.fault_control import BlockingFaults, Faults
from homebot.testing.mqtt.journal import Payload, RecordedMessage, Wanted
from homebot.testing.mqtt.packet_log import ProtocolViolation
from homebot.testing.mqtt.settings import BrokerSettings, TestTls
from homebot.testing.mqtt.thread import BrokerThread


class BrokerView:
    """The base of both kinds of brokers provided by fixtures.

    Attributes:
        host: The loopback address on which it listens.
        port: The TCP port; stays the same over :meth:`restart`.
        url: Such as ``mqtt://127.0.0.1:34567``; ``mqtts`` with TLS.
        ca_file: PEM file of the authority for clients to trust; None without TLS.
        settings: The settings requested by the test.
        packet_log: The newest packets, which pytest prints when the test fails.
    """

    __test__ = False  # not a test class in spite of its name

    def __init__(self, core: BrokerCore, thread: BrokerThread) -> None:
        self.host, self.port, self.url = core.broker.host, core.broker.port, core.broker.url
        self.ca_file, self.settings, self.packet_log = core.ca_file, core.settings, core.log
        self._core = core
        self._thread = thread

    @property
    def clients(self) -> Mapping[str, ClientView]:
        """The known clients by id, including absent ones with a session."""
        return self._core.clients

    @property
    def protocol_errors(self) -> tuple[ProtocolViolation, ...]:
        """The first 20 violations of MQTT by clients, in order, without those caused by faults."""
        return self._core.breaches.kept

    def forget_protocol_errors(self) -> None:
        """Forget the violations, because they were the subject of the test."""
        self._core.breaches.clear()

    def forget_messages(self) -> None:
        """Forget all published messages, for a broker shared by several tests."""
        self._core.journal.clear()

    def assert_not_published(self, filter: str) -> None:  # noqa: A002 - the protocol's own word
        """Assert that no client has published on *filter*, apart from messages returned by ``expect``.

        Call ``settle`` first, as this only checks received messages.

        Raises:
            AssertionError: One has; the message shows it.
            InvalidNameError: *filter* is no topic filter.
        """
        validate_filter(filter)
        came = self._core.journal.waiting(filter)
        if came:
            __tracebackhide__ = True  # pytest then points at the test's line
            raise AssertionError(
                "\n".join([f"{len(came)} published on {filter}:", *(f"    {entry}" for entry in came)])
            )


_CALM_ROUNDS = 3  # of both loops without a packet: an answer needs one
_TIMEOUT = 30.0


@final
class TestBroker(BrokerView):
    """A real MQTT broker for one test, watched and ready to fail on demand."""

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
        """Publish from outside, invisible to ``expect``; return when the broker has forwarded it.

        Args:
            payload: Bytes, text as UTF-8, or a dict or list as JSON.
            qos: 0, 1 or 2.
            properties: MQTT 5 properties.

        Raises:
            UsageError: The topic or *qos* is invalid.
            LinkError: A subscriber's queue is full, or there is no room to retain.
        """
        await self._thread.run(self._core.publish, topic, payload, qos, retain, properties)

    async def expect(self, filter: str, payload: Wanted = None, timeout: float = 5.0) -> RecordedMessage:  # noqa: A002, ASYNC109 - the words that users look for
        """Return the first matching message of a client not returned before, waiting for it if necessary.

        Args:
            payload: None for any; bytes or text; a dict or list to compare as JSON; or a function that gets the
                :class:`RecordedMessage`, on the broker's thread, and returns whether it matches.
            timeout: Seconds to wait.

        Raises:
            AssertionError: None arrived; the message shows the received ones.
            InvalidNameError: *filter* is no topic filter.
        """
        validate_filter(filter)
        journal = self._core.journal
        message = await self._thread.run(journal.pop, filter, payload, timeout)
        if message is None:
            __tracebackhide__ = True  # pytest then points at the test's line
            raise AssertionError(journal.near_misses(filter, payload, timeout))
        return message

    async def settle(self, quiet: float = 0.0) -> None:
        """Return when the broker and everything on the test's own loop are idle.

        It does not wait for timers, and cannot observe clients in other threads or processes: give
        *quiet* for those.

        Args:
            quiet: Return only after so many seconds without any packet.

        Raises:
            AssertionError: There was no rest within 30 seconds.
        """
        with anyio.move_on_after(_TIMEOUT + quiet):
            calm = 0
            while calm < _CALM_ROUNDS:
                before = self._core.log.total
                await self._core.turn()  # the same number of turns on this loop
                await self._thread.run(self._core.turn)
                calm = calm + 1 if self._core.log.total == before else 0
            if quiet > 0:
                await self._thread.run(self._core.silence, quiet)
            return
        raise AssertionError(f"the clients were not idle within {_TIMEOUT:g} s")

    async def restart(self, *, keep_sessions: bool) -> None:
        """Cut all connections, and start again on the same port.

        Args:
            keep_sessions: Whether sessions, their queues and retained messages live on.
        """
        await self._thread.run(self._core.restart, keep_sessions)


@final
class BlockingTestBroker(BrokerView):
    """Like :class:`~homebot.testing.mqtt.TestBroker` with blocking methods, for tests without an event loop."""

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
        """Publish like :meth:`TestBroker.publish`."""
        self._thread.call(self._core.publish, topic, payload, qos, retain, properties)

    def expect(self, filter: str, payload: Wanted = None, timeout: float = 5.0) -> RecordedMessage:  # noqa: A002 - as above
        """Expect like :meth:`TestBroker.expect`."""
        validate_filter(filter)
        journal = self._core.journal
        message = self._thread.call(journal.pop, filter, payload, timeout)
        if message is None:
            __tracebackhide__ = True  # as above
            raise AssertionError(journal.near_misses(filter, payload, timeout))
        return message

    def settle(self, quiet: float = 0.05) -> None:
        """Return after *quiet* seconds without any packet.

        Raises:
            AssertionError: There was no rest within 30 seconds.
        """
        self._thread.call(self._settle, quiet)

    def restart(self, *, keep_sessions: bool) -> None:
        """Restart like :meth:`TestBroker.restart`."""
        self._thread.call(self._core.restart, keep_sessions)

    async def _settle(self, quiet: float) -> None:
        with anyio.move_on_after(_TIMEOUT + quiet):
            await self._core.silence(quiet)
            return
        raise AssertionError(f"the clients were not idle within {_TIMEOUT:g} s")


_DEFAULTS = BrokerSettings()


BrokerT = TypeVar("BrokerT", TestBroker, BlockingTestBroker)


@contextmanager
def serve_broker(
    thread: BrokerThread, kind: type[BrokerT], settings: BrokerSettings = _DEFAULTS, tls: TestTls | None = None
) -> Iterator[BrokerT]:
    """Run a new broker on *thread* inside the block."""
    core = thread.call(_start, settings, tls)
    try:
        yield kind(core, thread)
    finally:
        thread.call(_stop, core)


async def _start(settings: BrokerSettings, tls: TestTls | None) -> BrokerCore:
    core = BrokerCore(settings, tls)
    await core.broker.start()
    return core


async def _stop(core: BrokerCore) -> None:
    core.rules.lift_all()
    await core.turn()  # reads pending bytes of clients, so that breaches are noticed
    await core.broker.stop(abrupt=True)
