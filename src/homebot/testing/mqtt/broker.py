"""Value of the fixtures ``mqtt_broker`` and ``mqtt_broker_session``.

The broker lives on a thread and loop of its own, so it serves whatever loop, or none, a test has, and a test that
blocks its loop does not silence it.
"""

from __future__ import annotations

from typing import final

import anyio

from homebot.mqtt.packets import NO_PROPERTIES, Properties
from homebot.mqtt.topics import validate_filter
from homebot.testing.mqtt.broker_view import BrokerView
from homebot.testing.mqtt.core import BrokerCore
from homebot.testing.mqtt.fault_control import Faults
from homebot.testing.mqtt.recorded_message import Payload, RecordedMessage, Wanted
from homebot.testing.mqtt.thread import BrokerThread

__all__ = ["TestBroker"]

_CALM_ROUNDS = 3  # of both loops without a packet: an answer needs one
_TIMEOUT = 5.0


@final
class TestBroker(BrokerView):
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

    async def expect(self, filter: str, payload: Wanted = None, timeout: float = 1.0) -> RecordedMessage:  # noqa: A002, ASYNC109 - the words that users look for
        """Return the first message of a client that fits and was not returned before; wait for it if need be.

        Args:
            filter: Topic filter.
            payload: None for any; bytes or text to be equal; a dict or list to be equal as JSON; or a function
                that is given the :class:`RecordedMessage`, on the broker's thread, and says whether this is it.
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
        with anyio.move_on_after(_TIMEOUT + quiet):
            await self._come_to_rest()
            if quiet > 0:
                await self._thread.run(self._core.silence, quiet)
            return
        raise AssertionError(f"the clients did not come to rest within {_TIMEOUT:g} s")

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
