"""The experiment of the thesis, chapter 8: the example's programs, and homebot's gateway."""

import sys
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from runpy import run_path
from typing import Literal

import anyio
import pytest
from tests.guide import guide
from tests.patience import PATIENCE

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

SAID = {
    "home425/lights/philips165": ["off"] * 10,
    "home425/lights/roomlights405": ["on"] * 9 + ["off"],
    "home425/window/firstlevel1": ["open"] * 10,
}
EXAMPLES = Path(__file__).parents[1] / "examples"
APPS = guide("apps")
SERVICE = EXAMPLES / "07_thesis_light_service" / "thesis_light_service.py"
THESIS = run_path(str(SERVICE))

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

    async def publish(self, messages: range) -> None:
        """Each device says its words with these numbers; they are its state, so the broker retains them."""
        for number in messages:
            for base, words in SAID.items():
                await self.field.publish(f"{base}/out", words[number].encode(), qos=1, retain=True)

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
        for base in SAID:
            answer = await ask.call(SubscribeToTopic.Request(topic=f"{base}/out", listener="/witness"))
            if delivery == "mirror":
                witness.create_subscription(RawMessage, answer.data_topic, received.mailbox.put, 1000)
        yield Experiment(runtime, witness, field, received, Counter())


@pytest.mark.parametrize("is_there_first", [False, True])
@pytest.mark.parametrize("delivery", ["inbox", "mirror"])
async def test_chapter_8(broker_url: str, delivery: Delivery, *, is_there_first: bool) -> None:
    """Thirty messages are received; one lamp is told off: for each ``on``, and if it is on when the service comes."""
    async with experiment(broker_url, delivery) as run, anyio.create_task_group() as tasks, AsyncExitStack() as stack:

        async def start_service() -> None:
            node = await stack.enter_async_context(Node(run.runtime.graph, "light_service"))
            tasks.start_soon(THESIS["ThesisLightService"](node, NoSettings()).run)
            await anyio.wait_all_tasks_blocked()

        if is_there_first:
            await start_service()
        await run.publish(range(5))
        before = await run.count_received(15)
        assert before == {f"{base}/out": 5 for base in SAID}
        await run.collect_answers(5 if is_there_first else 0)
        answered = run.answers.copy()
        if not is_there_first:
            assert not answered
            await start_service()
        await run.publish(range(5, 10))
        after = await run.count_received(15)
        assert before + after == {f"{base}/out": 10 for base in SAID}  # and nothing that homebot sent itself
        await run.collect_answers(answered.total() + (4 if is_there_first else 5))
        run.answers.subtract(answered)
        assert run.answers == {"home425/lights/roomlights405/in off": 4 if is_there_first else 5}
        topics = await listed_topics(run.runtime)
        tasks.cancel_scope.cancel()

        index = run.witness.create_client(GetIndexData, GET_INDEX_DATA)
        lights = await index.call(GetIndexData.Request(service_type="lights"))
        assert [(entry.gateway, entry.topic) for entry in lights.entries] == [("mqtt", f"{lamp}/out") for lamp in LAMPS]
        window = await index.call(GetIndexData.Request(service_type="window"))
        assert window.topics == ("home425/window/firstlevel1/out",)
        if delivery == "mirror":
            assert topics >= LISTING_8_4


def test_the_guide_of_apps_shows_the_light_service_in_both_forms() -> None:
    product = (EXAMPLES.parent / "src/homebot/apps/light_service.py").read_text("utf-8").splitlines()
    shown = [line for line in product[product.index("class LightService(App):") :] if line and '"""' not in line]
    assert [line for line in shown if line not in APPS] == []
    assert SERVICE.read_text("utf-8").partition('"""\n\n')[2] in APPS


@pytest.mark.slow
@pytest.mark.parametrize("words", [(), ("--service-first",)])
async def test_the_example_prints_facts_of_the_thesis_with_their_places_beside_what_came_here(
    broker_url: str, words: tuple[str, ...]
) -> None:
    done = await anyio.run_process(
        [sys.executable, str(EXAMPLES / "12_thesis" / "chapter8.py"), "--mqtt", broker_url, *words], stderr=None
    )
    head, *lines = done.stdout.decode()[done.stdout.decode().index("place  ") :].splitlines()
    table, topics = lines[:6], lines[6:]
    assert [(line[:13].strip(), *line[67:].split()) for line in table] == [
        ("8", "30", "30"),
        ("8.1, 8.3", "4", "4" if words else "5"),
        ("8", "0", "0"),
        ("8.2", "yes", "no"),
        ("listing 8.2", "lights", "window"),
        ("listing 8.4", "6", "6"),
    ]
    assert set(topics) == LISTING_8_4
    assert words or "\n".join([head, *table]) in guide("thesis")


async def listed_topics(runtime: Runtime) -> set[str]:
    """What ``homebot topic list`` prints, as a process of its own."""
    assert runtime.rosbridge is not None
    command = [sys.executable, "-m", "homebot", "topic", "list", "--door", f"127.0.0.1:{runtime.rosbridge.port}"]
    done = await anyio.run_process(command)
    return set(done.stdout.decode().split())
