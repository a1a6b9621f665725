"""One test's dealings with a broker, by four clients: connect, subscribe, publish, receive that, leave."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable, Coroutine

import aiomqtt
import paho.mqtt.client as paho
from paho.mqtt.enums import CallbackAPIVersion

from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.options import MqttOptions

__all__ = ["ANSWER", "CLIENTS", "PAYLOAD", "TOPIC", "TestSteps"]

TOPIC = "lamp"
PAYLOAD = b"on"
PATIENCE = 5.0

# MQTT 3.1.1, as a client that does nothing else would write it.
CONNECT = bytes.fromhex("100d 0004 4d515454 04 02 003c 0001 61")
SUBSCRIBE = bytes.fromhex("8209 0001 0004 6c616d70 00")
ANSWER = bytes.fromhex("3008 0004 6c616d70 6f6e")

TestSteps = Callable[[int, Callable[[], Awaitable[None]]], Coroutine[None, None, None]]
"""Port, and what the test itself does once its message has come back."""


async def raw(port: int, check: Callable[[], Awaitable[None]]) -> None:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    for packet, answer in ((CONNECT, 4), (SUBSCRIBE, 5), (ANSWER, len(ANSWER))):
        writer.write(packet)
        await reader.readexactly(answer)
    await check()
    writer.close()
    await writer.wait_closed()


async def homebot(port: int, check: Callable[[], Awaitable[None]]) -> None:
    client = AiomqttClient(MqttOptions(host="127.0.0.1", port=port))
    async with client.connected():
        await client.subscribe(MqttSubscription(TOPIC))
        await client.publish(TOPIC, PAYLOAD)
        await client.receive()
        await check()


async def with_aiomqtt(port: int, check: Callable[[], Awaitable[None]]) -> None:
    async with aiomqtt.Client("127.0.0.1", port) as client:
        await client.subscribe(TOPIC)
        await client.publish(TOPIC, PAYLOAD)
        await anext(aiter(client.messages))
        await check()


async def with_paho(port: int, check: Callable[[], Awaitable[None]]) -> None:
    """As in its own examples: a thread of its own, which tells the test what came."""
    client = paho.Client(CallbackAPIVersion.VERSION2)
    up, subscribed, came = threading.Event(), threading.Event(), threading.Event()
    client.on_connect = lambda *_: up.set()
    client.on_subscribe = lambda *_: subscribed.set()
    client.on_message = lambda *_: came.set()
    client.connect("127.0.0.1", port)
    client.loop_start()
    assert up.wait(PATIENCE)
    client.subscribe(TOPIC)
    assert subscribed.wait(PATIENCE)
    client.publish(TOPIC, PAYLOAD)
    assert came.wait(PATIENCE)
    await check()
    client.disconnect()
    client.loop_stop()


CLIENTS: dict[str, TestSteps] = {
    "raw asyncio client": raw,
    "homebot's client": homebot,
    "aiomqtt": with_aiomqtt,
    "paho": with_paho,
}
