"""The simulated house: each device is an MQTT client of its own and knows nothing of homebot."""

from __future__ import annotations

from collections.abc import Sequence

import anyio
from anyio.abc import TaskStatus

from homebot.clock import Clock
from homebot.errors import ClosedError, LinkError
from homebot.house.devices import Lamp, SimulatedDevice, WindowMotor
from homebot.mqtt.aiomqtt_client import AiomqttClient
from homebot.mqtt.client import Subscription
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.options import MqttOptions

__all__ = ["SimulatedHouse", "thesis_devices"]

HEARTBEAT = 2.0
"""Seconds after which a device repeats its state, as real ones do."""


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
    """

    def __init__(self, url: str, home: str, devices: Sequence[SimulatedDevice], clock: Clock) -> None:
        self._url = url
        self._home = home
        self._devices = devices
        self._clock = clock

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Let the devices live until cancelled."""
        async with anyio.create_task_group() as tasks:
            for device in self._devices:
                tasks.start_soon(self._live, device)
            task_status.started()

    async def _live(self, device: SimulatedDevice) -> None:
        options = MqttOptions.from_url(self._url, client_id=f"{self._home}-{device.device_id}")
        base = f"{self._home}/{device.service_type}/{device.device_id}"
        async with MqttConnection(options, AiomqttClient, status_topic=None, clock=self._clock) as connection:
            await connection.subscribe(Subscription(f"{base}/in", qos=1))
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._report_on_connect, device, connection, f"{base}/out")
                tasks.start_soon(self._report_steadily, device, connection, f"{base}/out")
                tasks.start_soon(self._obey, device, connection, f"{base}/out")

    async def _report_on_connect(self, device: SimulatedDevice, connection: MqttConnection, topic: str) -> None:
        async for state in connection.states():
            if state.phase is LinkPhase.CONNECTED:
                await _say(connection, topic, device.state())

    async def _report_steadily(self, device: SimulatedDevice, connection: MqttConnection, topic: str) -> None:
        while True:
            await anyio.sleep(HEARTBEAT)
            await _say(connection, topic, device.state())

    async def _obey(self, device: SimulatedDevice, connection: MqttConnection, topic: str) -> None:
        while True:
            try:
                commands = await connection.receive()
            except ClosedError:
                return
            for command in commands:
                for step in device.obey(command.payload.decode(errors="replace")):
                    await anyio.sleep(step.after)
                    await _say(connection, topic, step.report)
            connection.ack(commands)


async def _say(connection: MqttConnection, topic: str, payload: str) -> None:
    try:
        await connection.publish(topic, payload.encode(), qos=1)
    except LinkError:
        return  # said again at the next link, which is how small devices live
