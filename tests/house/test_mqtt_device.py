"""A simulated device on a broker: how it ends."""

import asyncio

import anyio
import pytest

from homebot.clock import LoopClock
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.family import dialects
from homebot.house.mqtt_device import HouseCounters, MqttDevice
from homebot.log import LogLimit
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions


@pytest.mark.virtual_time
async def test_it_may_be_cancelled_at_any_step_of_a_lost_link() -> None:
    """Its connection may be closed before the task that receives is: that is no failure."""
    for steps in range(15):
        async with MemoryBroker() as broker:
            url, clock = f"mqtt://{broker.host}", LoopClock()
            connection = MqttConnection(
                MqttOptions.from_url(url, client_id="lamp"), broker.make_client, status_topic=None, clock=clock
            )
            dialect = dialects()["thesis"]
            info = SimulatedDeviceInfo("home", "lamp", "lamp", "lights", "hall")
            device = MqttDevice(info, dialect, connection, lambda _, __: None, HouseCounters(), LogLimit(clock))
            device.begin(DeviceState(text="on"), has_power=True)
            app = broker.make_client(MqttOptions.from_url(url, client_id="app"))
            async with app.connected(), anyio.create_task_group() as tasks:
                tasks.start_soon(device.live)
                await connection_stands(connection)
                (topic,) = dialect.filters(info)
                await app.publish(topic, b"on")
                connection.drop()
                await app.publish(topic, b"on")
                for _ in range(steps):
                    await asyncio.sleep(0)
                tasks.cancel_scope.cancel()


async def connection_stands(connection: MqttConnection) -> None:
    await anyio.wait_all_tasks_blocked()
    await connection.wait_connected()
    await anyio.wait_all_tasks_blocked()
