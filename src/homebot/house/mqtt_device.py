"""One device of a simulated house: a separate MQTT client, which does not know homebot.

Its messages wait in its own queue, so that a slow broker blocks neither the world nor other devices. Without a link
messages are dropped, and the next link publishes the last state, as small devices do.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import anyio

from homebot.errors import ClosedError, LinkError, RefusedError
from homebot.house.connected_device import ConnectedDevice
from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.log import LogLimit
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.support.isolation import run_as
from homebot.support.logger import get_logger

REFUSED = "house.publish_refused"

QUEUED = 100
"""Most messages of one device waiting for the broker; the oldest is dropped, because newer ones are more useful."""

_COMMAND_ID = "command"

_log = get_logger()


@dataclass(slots=True)
class HouseCounters:
    """Counters of the messages between the devices of a house and the broker.

    Attributes:
        published: Messages accepted by the broker.
        unsaid: States and messages without a link.
        overflowed: Messages dropped because of a slow broker.
        refused: Messages refused by the broker.
    """

    published: int = 0
    unsaid: int = 0
    overflowed: int = 0
    refused: int = 0
    commands: int = 0


@final
class MqttDevice(ConnectedDevice):
    """A device on MQTT.

    Args:
        on_command: Receives each command, and its id if the message has the user property ``command``.
        counters: The counters of the house.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        dialect: Dialect,
        connection: MqttConnection,
        on_command: Callable[[str, str], None],
        counters: HouseCounters,
        lines: LogLimit,
    ) -> None:
        super().__init__()
        self._device = device
        self._dialect = dialect
        self._connection = connection
        self._state = DeviceState(text="")
        self._last: tuple[OutgoingMessage, ...] = ()
        self._again: tuple[OutgoingMessage, ...] = ()
        self._on_command = on_command
        self._counters = counters
        self._lines = lines
        self._queue: deque[OutgoingMessage] = deque()
        self._queued = asyncio.Event()  # anyio's cannot be cleared, and a new one for each message costs

    def begin(self, state: DeviceState, *, has_power: bool) -> None:
        """Start in *state*, published at the first link; called before :meth:`live`."""
        self._store(state)
        self._has_power = has_power

    def publish(self, state: DeviceState) -> None:
        """Publish *state*, repeated at heartbeats and new links until the next state; never waits."""
        self._store(state)
        if self._is_online:
            self._enqueue(self._last)
        else:
            self._counters.unsaid += 1

    def repeat(self) -> None:
        """Publish the last state again if there is a link; a lost message comes with the next."""
        if self._is_online:
            self._enqueue(self._again)

    async def live(self) -> None:
        """Be online whenever there is power, until cancelled."""
        for topic_filter in self._dialect.filters(self._device):
            await self._connection.subscribe(MqttSubscription(topic_filter, qos=1))  # kept for every link
        while True:
            while not self._has_power:
                await self._switched.wait()
            async with self._connection, anyio.create_task_group() as tasks:
                for work in (self._on_connected, self._publish_queued, self._receive_commands):
                    tasks.start_soon(run_as, "a simulated device", work)
                while self._has_power:
                    await self._switched.wait()
                self._connection.drop()  # a power failure sends no DISCONNECT
                tasks.cancel_scope.cancel()

    @property
    def _is_online(self) -> bool:
        return self._has_power and self._connection.state.phase is LinkPhase.CONNECTED

    def _store(self, state: DeviceState) -> None:
        self._state = state
        self._last = self._dialect.state_messages(self._device, state)
        self._again = tuple(message._replace(qos=0) for message in self._last)

    def _enqueue(self, messages: tuple[OutgoingMessage, ...]) -> None:
        for message in messages:
            if len(self._queue) == QUEUED:
                self._queue.popleft()
                self._counters.overflowed += 1
            self._queue.append(message)
        self._queued.set()

    async def _on_connected(self) -> None:
        async for link in self._connection.states():
            if link.phase is LinkPhase.CONNECTED:
                self._counters.unsaid += len(self._queue)
                self._queue.clear()
                self._enqueue(self._dialect.birth(self._device))
                self._enqueue(self._last)

    async def _publish_queued(self) -> None:
        while True:
            await self._queued.wait()
            self._queued.clear()
            while self._queue:
                await self._publish(self._queue.popleft())

    async def _publish(self, message: OutgoingMessage) -> None:
        try:
            await self._connection.publish(message.topic, message.payload, qos=message.qos, retain=message.retain)
        except LinkError:
            self._counters.unsaid += 1
        except RefusedError as exc:
            self._counters.refused += 1
            if (held_back := self._lines.allows(message.topic)) is not None:
                _log.warning(REFUSED, message=f"the broker refused {exc}", topic=message.topic, held_back=held_back)
        else:
            self._counters.published += 1

    async def _receive_commands(self) -> None:
        while True:
            try:
                messages = await self._connection.receive()
            except ClosedError:
                return  # closed during the last message
            for message in messages:
                command_id = dict(message.properties.user_properties).get(_COMMAND_ID, "")
                for command in self._dialect.parse_command(self._device, message.topic, message.payload):
                    self._counters.commands += 1
                    self._on_command(command, command_id)
                self._enqueue(self._dialect.replies(self._device, self._state, message.topic, message.payload))
            self._connection.ack(messages)
