"""What an app offers to the other systems of the house."""

import json
import re
import sys
from pathlib import Path
from types import ModuleType

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices.devices import Devices
from homebot.devices.exposure import ExposedDevice, ExposedState
from homebot.devices.gateway_messages import Command
from homebot.devices.names import GatewayNames
from homebot.devices.part import Capability, Part
from homebot.devices.value import Value
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.mqtt.client import MqttSubscription
from homebot.testing import house_of

GUIDE = Path(__file__).parents[2] / "docs" / "devices.md"

ROBOT = ExposedDevice(
    id="robot",
    name="Robot",
    parts=(Part(id="", service_type="x_robot", capabilities=(Capability(name="on_off", settable=True),)),),
)
NAMES = GatewayNames("mqtt")


@pytest.mark.rooms("homeassistant")
async def test_the_app_of_the_guide_is_a_switch_for_a_home_assistant(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a real broker: announced, switched on, and told to be on."""
    section = GUIDE.read_text(encoding="utf-8").split("## Expose a device yourself")[1]
    module = ModuleType("patrol_app")
    exec(section.split("```python\n")[1].split("```")[0], module.__dict__)  # noqa: S102 - our own guide
    monkeypatch.setitem(sys.modules, "patrol_app", module)
    config = {"gateways": {"mqtt": {"homeassistant": {"publish": True}}}}
    async with (
        house_of("patrol_app:Patrol", config=parse_config(config, "test")) as house,
        house.client("home-assistant") as hass,
    ):
        await hass.subscribe(MqttSubscription("homeassistant/#"), MqttSubscription("homebot/#"))
        said: dict[str, str] = {}
        with anyio.fail_after(PATIENCE):
            while not (configs := [one for one in said if re.fullmatch("homeassistant/.*/config", one)]):
                said.update({one.topic: one.payload.decode() for one in await hass.receive()})
            fields = json.loads(said[configs[0]])
            await hass.publish(fields["command_topic"], b"ON", qos=1)
            while said.get(fields["state_topic"]) != "ON":
                said.update({one.topic: one.payload.decode() for one in await hass.receive()})
    assert configs[0].startswith("homeassistant/switch/")


@pytest.mark.virtual_time
async def test_an_exposed_device_has_its_state_and_is_withdrawn_after_the_block() -> None:
    """Also by a gateway that comes late."""
    graph = Graph()
    async with Node(graph, "app") as app, Node(graph, "gateway") as gateway:
        with Devices(app).offer(ROBOT) as offering:
            offering.set_state("on_off", value=True)
            offers = gateway.create_subscription(ExposedDevice, NAMES.offers, qos_profile=qos_profile_latched)
            reports = gateway.create_subscription(ExposedState, NAMES.offer_reports, qos_profile=qos_profile_latched)
            assert offers.take() == ROBOT
            report = reports.take()
            assert report is not None
            assert [(one.capability, one.value.plain()) for one in report.readings] == [("on_off", True)]
        withdrawn = offers.take()
        assert withdrawn is not None
        assert withdrawn.is_withdrawn


@pytest.mark.virtual_time
async def test_it_hears_the_commands_for_itself_alone_until_the_block_ends() -> None:
    graph = Graph()
    heard: list[Command] = []
    async with Node(graph, "app") as app, Node(graph, "gateway") as gateway, anyio.create_task_group() as tasks:
        commands = gateway.create_publisher(Command, NAMES.offer_commands, 100)
        with Devices(app).offer(ROBOT) as offering:

            async def obey() -> None:
                heard.extend([command async for command in offering.commands()])

            tasks.start_soon(obey)
            for key in ("another", "robot"):
                commands.publish(Command(key=key, part="", capability="on_off", value=Value.of(plain=False)))
            await anyio.wait_all_tasks_blocked()
    assert [command.key for command in heard] == ["robot"]


@pytest.mark.virtual_time
async def test_a_node_that_is_closed_first_takes_its_offer_along() -> None:
    graph = Graph()
    async with Node(graph, "app") as app:
        offering = Devices(app).offer(ROBOT)
        offering.__enter__()
    offering.__exit__(None, None, None)
    assert graph.get_node_names() == ()
