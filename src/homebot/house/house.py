"""The simulated house: each device is an MQTT client of its own and knows nothing of homebot."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from random import Random

import anyio
from anyio.abc import TaskStatus

from homebot.clock import Clock
from homebot.errors import LinkError, UsageError
from homebot.house.devices import Lamp, SimulatedDevice, WindowMotor
from homebot.mqtt.aiomqtt_client import AiomqttClient
from homebot.mqtt.client import MqttClient, Subscription
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.options import MqttOptions

__all__ = ["SimulatedHouse", "thesis_devices"]

HEARTBEAT = 2.0
"""Seconds between two reports where nothing else is said: short, so that one who looks on sees life."""

SHORTEST_KEEP_ALIVE = 30


def thesis_devices() -> tuple[SimulatedDevice, ...]:
    """Return the devices of the thesis's experiment: two lamps, of which one is on, and a window motor."""
    return (Lamp("roomlights405", is_on=True), Lamp("roomlights406"), WindowMotor("windowmotor405"))


class SimulatedHouse:
    """Simulated devices on a real broker.

    Args:
        url: The broker, ``mqtt://host:port``.
        home: First level of the devices' topics.
        devices: The devices.
        clock: The time they live by.
        make_client: Makes their MQTT clients.
        random: Source of their reconnects' jitter; a seeded one makes every run the same.
        heartbeat: Seconds after which a device repeats its state, as real ones do.

    Raises:
        UsageError: The heartbeat is not above 0.
    """

    def __init__(
        self,
        url: str,
        home: str,
        devices: Sequence[SimulatedDevice],
        clock: Clock,
        *,
        make_client: Callable[[MqttOptions], MqttClient] = AiomqttClient,
        random: Random | None = None,
        heartbeat: float = HEARTBEAT,
    ) -> None:
        if heartbeat <= 0:
            raise UsageError(f"a heartbeat of {heartbeat:g} s is not above 0")
        self._url = url
        self._home = home
        self._devices = devices
        self._clock = clock
        self._make_client = make_client
        self._random = Random() if random is None else random  # noqa: S311 - jitter is no secret
        self._heartbeat = heartbeat

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Let the devices live until cancelled."""
        async with anyio.create_task_group() as tasks:
            for device in self._devices:
                tasks.start_soon(self._live, device)
            task_status.started()

    async def _live(self, device: SimulatedDevice) -> None:
        # Whoever speaks this often needs no pings in between.
        keep_alive = max(SHORTEST_KEEP_ALIVE, min(math.ceil(2 * self._heartbeat), 65_535))
        name = f"{self._home}-{device.device_id}"
        options = MqttOptions.from_url(self._url, client_id=name, keep_alive=keep_alive)
        base = f"{self._home}/{device.service_type}/{device.device_id}"
        async with MqttConnection(
            options, self._make_client, status_topic=None, clock=self._clock, random=self._random
        ) as connection:
            await connection.subscribe(Subscription(f"{base}/in", qos=1))
            voice = _Voice(connection, f"{base}/out", device.state())
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(_report_on_connect, connection, voice)
                tasks.start_soon(_report_steadily, voice, self._heartbeat)
                tasks.start_soon(_obey, device, connection, voice)


class _Voice:
    """What a device says, and says again: its last word, which on the way from one state to the next is neither."""

    def __init__(self, connection: MqttConnection, topic: str, word: str) -> None:
        self._connection = connection
        self._topic = topic
        self._word = word

    async def say(self, word: str) -> None:
        self._word = word
        await self.repeat()

    async def repeat(self) -> None:
        try:
            await self._connection.publish(self._topic, self._word.encode(), qos=1)
        except LinkError:
            return  # said again at the next link, which is how small devices live


async def _report_on_connect(connection: MqttConnection, voice: _Voice) -> None:
    async for state in connection.states():
        if state.phase is LinkPhase.CONNECTED:
            await voice.repeat()


async def _report_steadily(voice: _Voice, heartbeat: float) -> None:
    while True:
        await anyio.sleep(heartbeat)
        await voice.repeat()


async def _obey(device: SimulatedDevice, connection: MqttConnection, voice: _Voice) -> None:
    while True:
        commands = await connection.receive()
        for command in commands:
            for step in device.obey(command.payload.decode(errors="replace")):
                await anyio.sleep(step.after)
                await voice.say(step.report)
        connection.ack(commands)
