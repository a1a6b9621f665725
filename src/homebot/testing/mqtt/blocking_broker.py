"""Value of the fixture ``mqtt_broker_thread``."""

from __future__ import annotations

from typing import final

import anyio

from homebot.mqtt.packets import NO_PROPERTIES, Properties
from homebot.mqtt.topics import validate_filter
from homebot.testing.mqtt.broker_view import BrokerView
from homebot.testing.mqtt.core import BrokerCore
from homebot.testing.mqtt.fault_control import BlockingFaults
from homebot.testing.mqtt.recorded_message import Payload, RecordedMessage, Wanted
from homebot.testing.mqtt.thread import BrokerThread

__all__ = ["BlockingTestBroker"]

_TIMEOUT = 5.0


@final
class BlockingTestBroker(BrokerView):
    """As :class:`~homebot.testing.mqtt.TestBroker`, but every method blocks: for tests without an event loop.

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

    def expect(self, filter: str, payload: Wanted = None, timeout: float = 1.0) -> RecordedMessage:  # noqa: A002 - as above
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
        with anyio.move_on_after(_TIMEOUT + quiet):
            await self._core.silence(quiet)
            return
        raise AssertionError(f"the clients did not come to rest within {_TIMEOUT:g} s")
