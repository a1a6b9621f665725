"""The simulated house on a real broker: its devices speak, obey, and come back with the broker."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio

from homebot.clock import LoopClock
from homebot.house import Lamp, SimulatedHouse, WindowMotor, World
from homebot.mqtt.aiomqtt_client import AiomqttClient
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import Subscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions


@asynccontextmanager
async def house_on(broker: Broker, world: World) -> AsyncIterator[MqttConnection]:
    """The house runs; yields a client that hears what its devices say."""
    async with (
        MqttConnection(MqttOptions.from_url(broker.url), AiomqttClient, status_topic=None) as listener,
        anyio.create_task_group() as tasks,
    ):
        await listener.wait_connected()
        await listener.subscribe(Subscription("villa/+/+/out", qos=1))
        await tasks.start(SimulatedHouse(broker.url, "villa", world, LoopClock()).serve)
        yield listener
        tasks.cancel_scope.cancel()


async def said(listener: MqttConnection, count: int) -> list[str]:
    found: list[str] = []
    with anyio.fail_after(8):
        while len(found) < count:
            messages = await listener.receive()
            found += [f"{message.topic} {message.payload.decode()}" for message in messages]
            listener.ack(messages)
    return found


async def test_devices_say_how_they_are_and_obey() -> None:
    """A lamp at once; what it does not know it ignores."""
    async with Broker() as broker, house_on(broker, World.of(Lamp("lamp", is_on=True))) as listener:
        assert await said(listener, 1) == ["villa/lights/lamp/out on"]
        await listener.publish("villa/lights/lamp/in", b"\xff", qos=1)
        await listener.publish("villa/lights/lamp/in", b"off", qos=1)
        assert await said(listener, 1) == ["villa/lights/lamp/out off"]


async def test_a_heartbeat_repeats_the_last_word_also_on_the_way() -> None:
    """A window that is opening is not open yet."""
    async with Broker() as broker, house_on(broker, World.of(WindowMotor("motor", travel_time=2.5))) as listener:
        assert await said(listener, 1) == ["villa/windows/motor/out closed"]
        await listener.publish("villa/windows/motor/in", b"open", qos=1)
        words = [word.rpartition(" ")[2] for word in await said(listener, 3)]
        assert words == ["opening", "opening", "open"]


async def test_devices_come_back_with_the_broker_and_say_how_they_are() -> None:
    """Whatever they could not say meanwhile."""
    async with Broker() as broker, house_on(broker, World.of(Lamp("lamp"))) as listener:
        await said(listener, 1)
        await broker.restart(keep_sessions=False)
        assert await said(listener, 1) == ["villa/lights/lamp/out off"]
