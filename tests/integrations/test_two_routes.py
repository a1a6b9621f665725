"""A lamp that MQTT and Home Assistant both reach: one of them without effect, or only to observe."""

import asyncio
import json
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import anyio
import pytest
from anyio.abc import TaskGroup
from tests.integrations.homeassistant.simulated.server import SimulatedHomeAssistant
from tests.integrations.test_home_assistant_registry import Entry, RegisteredLamp, lamp_named
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE, until
from tests.ports import reserve_port

from homebot.cli.main import main
from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.names import ONLY_OBSERVES
from homebot.devices.outcomes import Confirmed, Outcome, Refused
from homebot.errors import RefusedError
from homebot.graph import Node
from homebot.house.dialect import DeviceState
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

pytestmark = pytest.mark.slow

CONFIG = {
    "name": None,
    "unique_id": "porch_light",
    "command_topic": "porch/set",
    "state_topic": "porch/state",
    "device": {"identifiers": ["porch"], "name": "Porch"},
}


class TwoWayLamp:
    """The lamp: it obeys the ways in :attr:`obeys`, and reports over MQTT.

    Attributes:
        commands: The ways by which commands came, oldest first.
    """

    def __init__(self, field: MqttConnection, tasks: TaskGroup) -> None:
        self.obeys = {"homeassistant"}
        self.commands: list[str] = []
        self._field = field
        self._tasks = tasks

    def command(self, way: str, state: str) -> None:
        self.commands.append(way)
        if way in self.obeys:
            self._tasks.start_soon(self._field.publish, "porch/state", state.upper().encode())

    async def listen(self) -> None:
        while True:
            for message in await self._field.receive():
                self.command("mqtt", message.payload.decode())


@asynccontextmanager
async def porch(
    tmp_path: Path, observing: Collection[str] = (), **tables: object
) -> AsyncIterator[tuple[Runtime, TwoWayLamp, Light]]:
    home = SimulatedHomeAssistant(port=reserve_port())
    token = tmp_path / "token"
    token.touch(mode=0o600)
    token.write_text(home.token)
    gateways: dict[str, dict[str, object]] = {
        "mqtt": {},
        "homeassistant": {"url": f"http://127.0.0.1:{home.server.port}", "token_file": str(token)},
    }
    for name in observing:
        gateways[name]["act"] = False
    usual = {"gateways": gateways, "door": {"port": 0}, "control": {"timeout": 1.5, "approvals": False}}
    async with alone_on_loopback(), MemoryBroker() as broker, anyio.create_task_group() as tasks:
        options = MqttOptions(host="memory")
        field = await tasks.start(partial(hold, MqttConnection(options, broker.make_client, status_topic=None)))
        lamp = TwoWayLamp(field, tasks)
        await field.subscribe(MqttSubscription("porch/set"))
        tasks.start_soon(lamp.listen)
        await field.publish("homeassistant/light/porch/config", json.dumps(CONFIG).encode(), retain=True)
        await field.publish("porch/state", b"OFF", retain=True)
        await tasks.start(home.serve)
        entity = RegisteredLamp(lamp_named("porch"), partial(lamp.command, "homeassistant"), home)
        entity.registered = Entry((("mqtt", "porch"),), (), "porch_light")
        entity.begin(DeviceState(text="off"), has_power=True)
        await tasks.start(entity.serve)
        config = parse_config({**usual, **tables}, "test")
        async with (
            Runtime(config, services=[HostedBroker.in_memory(broker)]) as runtime,
            Node(runtime.graph, "judge") as node,
        ):
            with anyio.fail_after(PATIENCE):
                while not (found := await two_way_lights(node)):  # noqa: ASYNC110 - the second way may come late
                    await anyio.sleep(0.05)
            yield runtime, lamp, found[0]
        tasks.cancel_scope.cancel()


async def hold(connection: MqttConnection, *, task_status: anyio.abc.TaskStatus[MqttConnection]) -> None:
    async with connection as field:
        await field.wait_connected()
        task_status.started(field)
        await anyio.sleep_forever()


async def two_way_lights(node: Node) -> list[Light]:
    devices = await Devices(node).find()
    has_both = any(len(part.routes) == 2 for one in devices for part in one.parts)
    return list(await Devices(node).find(Light)) if has_both else []


async def said(runtime: Runtime, capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert runtime.rosbridge is not None
    assert await asyncio.to_thread(main, [*words, "--door", f"127.0.0.1:{runtime.rosbridge.port}"]) == 0
    return capsys.readouterr().out


async def obeyed(lamp: TwoWayLamp, outcome: Outcome) -> list[str]:
    """Return the ways by which the last command came."""
    assert isinstance(outcome, Confirmed), outcome
    ways = lamp.commands.copy()
    lamp.commands.clear()
    return ways


async def test_a_route_without_effect_is_tried_last_until_it_works_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    async with porch(tmp_path) as (runtime, lamp, light):
        assert await obeyed(lamp, await light.turn_on()) == ["mqtt", "homeassistant"]
        assert "had no effect" not in await said(runtime, capsys, "show", "Porch")
        assert await obeyed(lamp, await light.turn_off()) == ["mqtt", "homeassistant"]
        assert await obeyed(lamp, await light.turn_on()) == ["homeassistant"]
        shown = await said(runtime, capsys, "show", "Porch")
        assert "via mqtt as homeassistant:light/porch; its last commands had no effect" in shown
        assert "via homeassistant as" in shown
        why = await said(runtime, capsys, "why", "Porch")
        assert "homeassistant accepted it" in why
        assert "The last commands via mqtt/" in why
        lamp.obeys = {"mqtt"}
        assert await obeyed(lamp, await light.turn_off()) == ["homeassistant", "mqtt"]
        assert await obeyed(lamp, await light.turn_on()) == ["mqtt"]
        assert "had no effect" not in await said(runtime, capsys, "why", "Porch")


async def test_a_gateway_that_the_owner_prefers_stays_the_first(tmp_path: Path) -> None:
    async with porch(tmp_path, discovery={"prefer": ["mqtt"], "persist": False}) as (_, lamp, light):
        for number in range(4):
            outcome = await (light.turn_off() if number % 2 else light.turn_on())
            assert await obeyed(lamp, outcome) == ["mqtt", "homeassistant"]


@pytest.mark.parametrize("prefer", [[], ["mqtt"], ["homeassistant"]])
@pytest.mark.parametrize(("observing", "acting"), [("mqtt", "homeassistant"), ("homeassistant", "mqtt")])
async def test_a_command_goes_by_the_gateway_that_may_act(
    tmp_path: Path, observing: str, acting: str, prefer: list[str]
) -> None:
    async with porch(tmp_path, [observing], discovery={"prefer": prefer, "persist": False}) as (runtime, lamp, light):
        lamp.obeys = {acting}
        assert await obeyed(lamp, await light.turn_on()) == [acting]
        async with Node(runtime.graph, "writer") as node:
            devices = Devices(node)
            await devices.tell((await devices.find())[0], "off")
            await until(lambda: lamp.commands == [acting])


async def test_a_command_is_refused_while_both_gateways_only_observe(tmp_path: Path) -> None:
    async with porch(tmp_path, ["mqtt", "homeassistant"]) as (runtime, lamp, light):
        outcome = await light.turn_on()
        assert isinstance(outcome, Refused)
        assert outcome.reason == ONLY_OBSERVES
        async with Node(runtime.graph, "writer") as node:
            devices = Devices(node)
            with pytest.raises(RefusedError, match=ONLY_OBSERVES):
                await devices.tell((await devices.find())[0], "off")
        assert not lamp.commands
