"""What homebot offers to a Home Assistant on the same broker."""

import json
from collections.abc import Mapping
from typing import Any

import anyio
import pytest
from tests.gateways.mqtt.simple_house import simple_house

from homebot.devices.exposure import ExposedDevice, ExposedState
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue, Reading, Value
from homebot.graph import DurabilityPolicy, QoSProfile

pytestmark = pytest.mark.virtual_time

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PUBLISHING: dict[str, Any] = {"conventions": ("homeassistant",), "homeassistant": {"publish": True}}
ROBOT = ExposedDevice(
    id="robot1",
    name="Robot",
    parts=(Part(id="", service_type="x_robot", capabilities=(Capability(name="on_off", settable=True),)),),
)


class App:
    """Offers something on the graph."""

    def __init__(self, house: Any) -> None:
        names = house.gateway.names
        self.offers = house.watcher.create_publisher(ExposedDevice, names.offers, LATCHED)
        self.reports = house.watcher.create_publisher(ExposedState, names.offer_reports, LATCHED)
        self.commands = house.watcher.create_subscription(Command, names.offer_commands, qos_profile=10)

    def say(self, *, on: bool) -> None:
        self.tell("robot1", {"on_off": on})

    def tell(self, offer: str, values: Mapping[str, PlainValue]) -> None:
        """Tell *values* of an offer, by capability with its part before it."""
        named = [(name.rpartition("/"), value) for name, value in values.items()]
        readings = tuple(
            Reading(part=part, capability=capability, value=Value.of(value)) for (part, _, capability), value in named
        )
        self.reports.publish(ExposedState(id=offer, readings=readings))


async def test_an_offer_is_published_and_commanded_and_is_no_device_of_ours() -> None:
    async with simple_house(**PUBLISHING) as house:
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        app = App(house)
        app.offers.publish(ROBOT)
        app.say(on=True)
        config, state = await house.heard()
        fields = json.loads(config.payload)
        assert (state.topic, state.payload) == (fields["state_topic"], b"ON")

        await house.say(fields["command_topic"], "OFF")
        command = app.commands.take()
        assert (command.key, command.capability, command.value.plain()) == ("robot1", "on_off", False)
        await house.cut()
        assert house.sighted() == []


async def test_a_sensor_on_the_command_topic_of_an_offer_hears_nothing_and_takes_no_command_from_it() -> None:
    async with simple_house(**PUBLISHING) as house:
        await house.listen("homeassistant/#")
        app = App(house)
        app.offers.publish(ROBOT)
        topic = json.loads((await house.heard())[0].payload)["command_topic"]
        await house.say("homeassistant/sensor/s/config", {"unique_id": "s", "state_topic": topic})
        await house.say(topic, "OFF")
        assert house.told() == []
        command = app.commands.take()
        assert command is not None
        assert command.key == "robot1"


async def test_exposed_devices_are_published_again_on_a_new_link_and_withdrawn_ones_are_not() -> None:
    async with simple_house(**PUBLISHING) as house:
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        app = App(house)
        app.offers.publish(ROBOT)
        app.say(on=False)
        first = {one.topic: one.payload for one in await house.heard()}
        await house.cut()
        assert {one.topic: one.payload for one in await house.heard()} == first

        app.offers.publish(ROBOT.model_copy(update={"is_withdrawn": True}))
        gone = await house.heard()
        assert {one.topic: one.payload for one in gone} == dict.fromkeys(first, b"")
        assert all(one.retain or not one.payload for one in gone)
        await house.cut()
        assert await house.heard() == []


@pytest.mark.parametrize(
    "settings", [{"conventions": ("homeassistant",)}, {**PUBLISHING, "act": False}], ids=["not wanted", "only observes"]
)
async def test_nothing_is_published_unless_it_is_wanted(settings: dict[str, Any]) -> None:
    async with simple_house(**settings) as house:
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        house.watcher.create_publisher(ExposedDevice, house.gateway.names.offers, LATCHED).publish(ROBOT)
        await anyio.sleep(0.01)
        assert await house.heard() == []


LAMP = ExposedDevice(
    id="lamp",
    name="Lamp",
    parts=(
        Part(
            id="",
            service_type="light",
            capabilities=(
                Capability(name="on_off", settable=True),
                Capability(name="level", settable=True),
                Capability(name="effect", settable=True, options=("rainbow",)),
                Capability(name="power"),
            ),
        ),
        Part(id="bolt", service_type="door_lock", capabilities=(Capability(name="lock", settable=True),)),
        Part(id="key", service_type="generic_switch", capabilities=(Capability(name="press", options=("single",)),)),
    ),
)


async def test_withdrawing_leaves_nothing_at_the_broker() -> None:
    async with simple_house(**PUBLISHING) as house:
        app = App(house)
        app.offers.publish(LAMP)
        values: dict[str, PlainValue] = {"on_off": True, "level": 40.0, "effect": "rainbow", "power": 3.0}
        app.tell("lamp", values | {"bolt/lock": "locked", "key/press": "single"})
        await house.heard()
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        assert len(await house.heard()) == 7, "four configs and three states; what was pressed is over"
        app.offers.publish(LAMP.model_copy(update={"is_withdrawn": True}))
        await house.heard()
        await house.listen("homeassistant/+/+/+/config", "homebot/+/offers/+/+/+/state")
        assert await house.heard() == []


async def test_a_press_is_told_each_time_and_never_kept() -> None:
    async with simple_house(**PUBLISHING) as house:
        await house.listen("homebot/+/offers/#")
        app = App(house)
        app.offers.publish(LAMP)
        for _ in range(2):
            app.tell("lamp", {"key/press": "single"})
        heard = await house.heard()
        assert [json.loads(one.payload) for one in heard] == [{"event_type": "single"}] * 2
        await house.cut()
        assert await house.heard() == []


async def test_an_offer_that_becomes_another_leaves_nothing_of_what_it_was() -> None:
    async with simple_house(**PUBLISHING) as house:
        app = App(house)
        app.offers.publish(ROBOT)
        app.say(on=True)
        app.offers.publish(ROBOT.model_copy(update={"parts": LAMP.parts[:1]}))
        app.tell("robot1", {"power": 3.0})
        await house.heard()
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        configs = [json.loads(one.payload) for one in await house.heard() if one.topic.endswith("/config")]
        assert sorted(one["command_topic"].rsplit("/", 2)[1] for one in configs if "command_topic" in one) == ["light"]
