"""A house in a test: the embedded broker, a homebot with the app under test, and the devices' side of the wire."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import anyio

from homebot.config import Config, parse_config
from homebot.errors import ClosedError
from homebot.mqtt.aiomqtt_client import AiomqttClient
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import Subscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime
from homebot.testing.background import in_background

__all__ = ["TestHouse", "house_config", "house_of"]

PATIENCE = 5.0

KEPT = 1000
"""Payloads of one topic that wait to be asked for; the oldest goes."""


class TestHouse:
    """What a test can do to a house and see of it.

    Attributes:
        runtime: The homebot under test.
    """

    __test__ = False  # no collection of tests, whatever its name

    def __init__(self, runtime: Runtime, field: MqttConnection) -> None:
        self.runtime = runtime
        self._field = field
        self._heard: defaultdict[str, deque[str]] = defaultdict(lambda: deque(maxlen=KEPT))
        self._came = anyio.Event()

    async def says(self, topic: str, payload: str) -> None:
        """Let a device publish *payload* on *topic*; returns when the broker has it."""
        await self._field.publish(topic, payload.encode(), qos=1)

    async def hears(self, topic: str, within: float = PATIENCE) -> str:
        """Return the next payload that homebot sends to *topic*.

        Args:
            topic: The MQTT topic.
            within: Seconds to wait for it.

        Raises:
            TimeoutError: Nothing came; says what came elsewhere, and which apps crashed.
        """
        with anyio.move_on_after(within):
            while not self._heard[topic]:
                await self._came.wait()
        if not self._heard[topic]:
            raise TimeoutError(self._silence(topic, within))
        return self._heard[topic].popleft()

    async def listen(self) -> None:
        """Take in what homebot sends, until cancelled."""
        while True:
            try:
                messages = await self._field.receive()
            except ClosedError:
                return
            for message in messages:
                self._heard[message.topic].append(message.payload.decode(errors="replace"))
            self._field.ack(messages)
            self._came.set()
            self._came = anyio.Event()

    def _silence(self, topic: str, within: float) -> str:
        elsewhere = {name: list(payloads) for name, payloads in self._heard.items() if payloads}
        supervisor = self.runtime.supervisor
        crashed = sorted({*supervisor.restarts, *supervisor.given_up})
        return (
            f"nothing came on {topic} within {within:g} s; "
            f"came elsewhere: {elsewhere or 'nothing'}; crashed: {', '.join(crashed) or 'nothing'}"
        )


def house_config(apps: Sequence[str], root: str, url: str) -> Config:
    """A configuration with *apps* and one MQTT gateway, which acts."""
    tables = {
        "gateways": {"mqtt": {"url": url, "root": root, "act": True}},
        "apps": {f"app_{number}": {"class": app} for number, app in enumerate(apps, 1)},
        "door": {"port": 0},
    }
    return parse_config(tables, "test")


@asynccontextmanager
async def house_of(*apps: str, root: str = "home425") -> AsyncIterator[TestHouse]:
    """Run *apps*, each a plug-in's name or ``module:Class``, in a homebot on a broker of its own.

    Topics follow the thesis: devices say things on ``<root>/SERVICE_TYPE/DEVICE_ID/out`` and are told on ``…/in``.
    """
    async with (
        Broker() as broker,
        Runtime(house_config(apps, root, broker.url)) as runtime,
        MqttConnection(MqttOptions.from_url(broker.url), AiomqttClient, status_topic=None) as field,
    ):
        await field.subscribe(Subscription(f"{root}/+/+/in", qos=1))
        await field.wait_connected()
        house = TestHouse(runtime, field)
        async with in_background(house.listen):
            yield house
