"""The experiment of the thesis, chapter 8, on the embedded broker and on Mosquitto, in both ways of delivery."""

import sys
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Literal

import anyio
import pytest
from tests.patience import PATIENCE
from tests.thesis_light_service import ThesisLightService

from homebot.apps import NoSettings
from homebot.config import parse_config
from homebot.devices import GET_INDEX_DATA, GetIndexData, RawMessage, SubscribeToTopic
from homebot.graph import Node, Subscription
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

LAMPS = ("home425/lights/philips165", "home425/lights/roomlights405")
"""Sorted, as the index is."""

DEVICES = (*LAMPS, "home425/windows/firstlevel1")
PAYLOADS = {"lights": b"on", "windows": b"open"}

LISTING_8_4 = {
    "/gateway/mqtt/out",
    "/gateway/mqtt/received_data/roomlights405",
    "/gateway/mqtt/received_data/philips165",
    "/gateway/mqtt/received_topics",
    "/parameter_events",
    "/rosout",
}

Delivery = Literal["inbox", "mirror"]


@pytest.fixture(params=["embedded_broker_url", pytest.param("mosquitto_url", marks=pytest.mark.system)])
def broker_url(request: pytest.FixtureRequest) -> str:
    url: str = request.getfixturevalue(request.param)
    return url


@dataclass
class Experiment:
    """A homebot without apps, the devices' side of the broker, and a node that reads everything the gateway hears."""

    runtime: Runtime
    witness: Node
    field: MqttConnection
    received: Subscription[RawMessage]
    answers: Counter[str]

    async def publish(self, times: int) -> None:
        """Each device says its word *times* times."""
        for _ in range(times):
            for base in DEVICES:
                await self.field.publish(f"{base}/out", PAYLOADS[base.split("/")[1]], qos=1)

    async def count_received(self, expected: int) -> Counter[str]:
        """What the gateway handed on, by address; waits for *expected* messages."""
        counts: Counter[str] = Counter()
        with anyio.fail_after(PATIENCE):
            while counts.total() < expected:
                counts[(await self.received.receive()).address] += 1
        return counts

    async def collect_answers(self, expected: int) -> None:
        """Read what arrives on the ``in`` channels until *expected* messages are there."""
        with anyio.fail_after(PATIENCE):
            while self.answers.total() < expected:
                messages: list[MqttMessage] = await self.field.receive()
                self.answers.update(f"{message.topic} {message.payload.decode()}" for message in messages)
                self.field.ack(messages)


@asynccontextmanager
async def experiment(broker_url: str, delivery: Delivery) -> AsyncIterator[Experiment]:
    gateway = {"url": broker_url, "root": "home425", "delivery": delivery, "act": True}
    config = parse_config({"gateways": {"mqtt": gateway}, "door": {"port": 0}}, "test")
    options = MqttOptions.from_url(broker_url)
    async with (
        Runtime(config) as runtime,
        Node(runtime.graph, "witness") as witness,
        MqttConnection(options, AiomqttClient, status_topic=None) as field,
    ):
        await field.subscribe(MqttSubscription("home425/+/+/in", qos=1))
        await field.wait_connected()
        received = witness.create_subscription(RawMessage, "~/inbox", qos_profile=1000)
        ask = witness.create_client(SubscribeToTopic, "/subscribe_to_mqtt_topic")
        for base in DEVICES:
            answer = await ask.call(SubscribeToTopic.Request(topic=f"{base}/out", listener="/witness"))
            if delivery == "mirror":
                witness.create_subscription(RawMessage, answer.data_topic, received.mailbox.put, 1000)
        yield Experiment(runtime, witness, field, received, Counter())


@pytest.mark.parametrize("delivery", ["inbox", "mirror"])
async def test_chapter_8(broker_url: str, delivery: Delivery) -> None:
    """15 of 15 before the light service, 30 in all; it answers each of the 10 that come after its start."""
    async with experiment(broker_url, delivery) as run:
        await run.publish(5)
        before = await run.count_received(15)
        assert before == {f"{base}/out": 5 for base in DEVICES}

        async with Node(run.runtime.graph, "light_service") as node, anyio.create_task_group() as tasks:
            tasks.start_soon(ThesisLightService(node, NoSettings()).run)
            await anyio.wait_all_tasks_blocked()
            await run.publish(5)
            after = await run.count_received(15)
            assert before + after == {f"{base}/out": 10 for base in DEVICES}
            await run.collect_answers(10)
            assert run.answers == {f"{lamp}/in off": 5 for lamp in LAMPS}
            topics = await listed_topics(run.runtime)
            tasks.cancel_scope.cancel()

        index = run.witness.create_client(GetIndexData, GET_INDEX_DATA)
        lights = await index.call(GetIndexData.Request(service_type="lights"))
        assert lights.topics == tuple(f"{lamp}/out" for lamp in LAMPS)
        assert [(one.gateway, one.topic) for one in lights.entries] == [("mqtt", f"{lamp}/out") for lamp in LAMPS]
        everything = await index.call(GetIndexData.Request(service_type=""))
        assert everything.topics == tuple(f"{base}/out" for base in DEVICES)
        if delivery == "mirror":
            assert topics >= LISTING_8_4


async def listed_topics(runtime: Runtime) -> set[str]:
    """What ``homebot topic list`` prints, as a process of its own."""
    assert runtime.door is not None
    command = [sys.executable, "-m", "homebot", "topic", "list", "--door", f"127.0.0.1:{runtime.door.port}"]
    done = await anyio.run_process(command)
    return set(done.stdout.decode().split())
