"""Responses of MQTT 5 to commands: a device that answers them, over the embedded broker and over Mosquitto."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

import anyio
import pytest
from anyio.abc import TaskStatus
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, MosquittoBroker
from tests.patience import PATIENCE
from tests.sizes import nightly

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Handle
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, NoAnswer
from homebot.graph import Node
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Properties
from homebot.runtime import Runtime

CREDENTIALS = {"anna": "right"}
SWITCH = {"unique_id": "switch", "name": "Switch", "command_topic": "switch/set", "device": {"identifiers": ["switch"]}}
REPORTING = {"state_topic": "switch/state"}
ACCEPTS = b'{"status": "ok"}'
REFUSES = b'{"status": "error", "error": "the fuse is out"}'

SILENCE = 3.0
"""Seconds without an answer: waited for in full, and enough for an answer on a machine that stands still for one."""

AnyBroker = Broker | MemoryBroker | MosquittoBroker


pytestmark = pytest.mark.rooms("homeassistant")


@dataclass
class Responder:
    """A device that answers each command with :attr:`response`; None for not at all."""

    connection: MqttConnection
    response: bytes | None = ACCEPTS
    commands: list[MqttMessage] = field(default_factory=list)

    async def live(self, task_status: TaskStatus[None]) -> None:
        await self.connection.subscribe(MqttSubscription("switch/set", qos=1))
        task_status.started()
        while True:
            for message in await self.connection.receive():
                self.commands.append(message)
                if self.response is not None:
                    await self.answer(self.response, message)

    async def answer(self, response: bytes, message: MqttMessage) -> None:
        assert message.properties.response_topic is not None
        same = Properties(correlation_data=message.properties.correlation_data)
        await self.connection.publish(message.properties.response_topic, response, qos=1, properties=same)


@dataclass
class Home:
    """A homebot with the device on its broker."""

    responder: Responder
    switch: Handle
    node: Node

    async def count(self, name: str) -> int:
        health = await self.node.create_client(GetHealth, "/gateway/mqtt/health").call(
            HealthRequest(), timeout=PATIENCE
        )
        return {one.name: one.count for one in health.counts}[name]


@asynccontextmanager
async def home_on(
    broker: AnyBroker, *, client: str = "native", reports: bool = False, timeout: float = PATIENCE
) -> AsyncIterator[Home]:
    services = [HostedBroker.in_memory(broker)] if isinstance(broker, MemoryBroker) else []
    async with broker, anyio.create_task_group() as tasks:
        url = f"mqtt://anna:right@{broker.host}:{broker.port}"
        gateway = {"url": url, "act": True, "responses": True, "client": client, "client_id": f"homebot {client}"}
        tables = {"gateways": {"mqtt": gateway}, "discovery": {"persist": False}, "control": {"timeout": timeout}}
        options = MqttOptions.from_url(url, client_id="device", protocol="5")
        make = broker.make_client if isinstance(broker, MemoryBroker) else NativeClient
        async with (
            MqttConnection(options, make, status_topic=None) as connection,
            Runtime(parse_config(tables, "test"), with_door=False, services=services) as runtime,
            Node(runtime.graph, "app") as node,
        ):
            responder = Responder(connection)
            await connection.wait_connected()
            await tasks.start(responder.live)
            config = json.dumps(SWITCH | (REPORTING if reports else {})).encode()
            await connection.publish("homeassistant/switch/switch/config", config, retain=True)
            yield Home(responder, await _handle(Devices(node)), node)
            tasks.cancel_scope.cancel()


async def _handle(devices: Devices) -> Handle:
    with anyio.fail_after(PATIENCE):
        while True:
            for found in await devices.find(Handle):
                return found
            await anyio.sleep(0.05)


ON_MOSQUITTO = [pytest.mark.system, pytest.mark.skipif(MOSQUITTO is None, reason="no Mosquitto")]


@pytest.fixture(
    params=[
        ("embedded", "native"),
        pytest.param(("embedded", "aiomqtt"), marks=nightly),
        pytest.param(("mosquitto", "native"), marks=[nightly, *ON_MOSQUITTO]),
        pytest.param(("mosquitto", "aiomqtt"), marks=ON_MOSQUITTO),
    ],
    ids=" ".join,
)
def peers(request: pytest.FixtureRequest) -> tuple[str, str]:
    """The kinds of the broker and of homebot's client."""
    kinds: tuple[str, str] = request.param
    return kinds


@pytest.fixture
def broker(peers: tuple[str, str]) -> AnyBroker:
    if peers[0] == "embedded":
        return Broker(credentials=CREDENTIALS)
    return MosquittoBroker(credentials=CREDENTIALS, policy=None)


@pytest.fixture
def client(peers: tuple[str, str]) -> str:
    return peers[1]


async def test_a_device_that_accepts_and_reports_nothing_is_acknowledged(broker: AnyBroker, client: str) -> None:
    async with home_on(broker, client=client, reports=True, timeout=SILENCE) as home:
        outcome = await home.switch.command("on_off", value=True)
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.ACKNOWLEDGED
        properties = home.responder.commands[0].properties
        assert properties.response_topic == f"homebot/responses/homebot {client}"
        assert properties.message_expiry_interval is not None
        assert len({one.properties.correlation_data for one in home.responder.commands}) == len(home.responder.commands)
        assert await home.count("responses") == len(home.responder.commands)


async def test_an_error_contradicts_at_once_with_its_text(broker: AnyBroker, client: str) -> None:
    async with home_on(broker, client=client, reports=True) as home:
        home.responder.response = REFUSES
        outcome = await home.switch.command("on_off", value=True)
        assert outcome == Contradicted("the fuse is out", command_id=outcome.command_id)
        assert len(home.responder.commands) == 1


@pytest.mark.virtual_time
async def test_a_switch_without_a_state_that_answered_once_has_to_answer() -> None:
    async with home_on(MemoryBroker(credentials=CREDENTIALS), timeout=SILENCE) as home:
        assert isinstance(await home.switch.command("on_off", value=True), Confirmed)
        with anyio.fail_after(PATIENCE):
            while not await home.count("responses"):  # noqa: ASYNC110 - it counts, and tells nobody
                await anyio.sleep(0.01)
        home.responder.response = REFUSES
        assert isinstance(await home.switch.command("on_off", value=True), Contradicted)
        home.responder.response = None
        assert isinstance(await home.switch.command("on_off", value=True), NoAnswer)


async def test_a_switch_without_a_state_that_is_away_did_not_get_the_command(broker: AnyBroker, client: str) -> None:
    async with home_on(broker, client=client) as home:
        await home.responder.connection.unsubscribe("switch/set")
        outcome = await home.switch.command("on_off", value=True)
        assert isinstance(outcome, NoAnswer)
        assert outcome.reason.endswith("no client subscribes to switch/set")


async def test_a_switch_that_reports_may_hear_of_commands_without_subscribing(broker: AnyBroker) -> None:
    """As a plug-in of the broker does: its report counts."""
    async with home_on(broker, reports=True) as home:
        connection = home.responder.connection
        await connection.unsubscribe("switch/set")
        async with anyio.create_task_group() as tasks:

            async def report() -> None:
                while True:
                    await connection.publish("switch/state", b"ON", qos=1)
                    await anyio.sleep(0.1)

            tasks.start_soon(report)
            outcome = await home.switch.command("on_off", value=True)
            tasks.cancel_scope.cancel()
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED
