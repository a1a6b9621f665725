"""Devices of the thesis's layout at the gateway: their words as reports, and commands as words."""

from typing import Any, ClassVar

import anyio
import pytest
from pydantic import BaseModel
from tests.gateways.mqtt.simple_house import simple_house

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication, TextEndpoint
from homebot.conventions.text_codec import TextCodec
from homebot.devices import RawCommand, RawMessage
from homebot.devices.gateway_messages import Report
from homebot.devices.part import Capability, Part
from homebot.devices.services import SubscribeToTopic, SubscribeToTopicRequest
from homebot.devices.value import PlainValue
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.mqtt.connection import MqttConnection

pytestmark = pytest.mark.virtual_time


LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
THESIS: dict[str, Any] = {"conventions": ("thesis",)}
LAMP, KEY = "home425/lights/lamp/out", "lights/lamp"


async def test_a_device_of_the_layout_is_sighted_with_its_part_and_its_own_addresses() -> None:
    async with simple_house(**THESIS) as house:
        await house.say(LAMP, "on")
        await house.say("home425/coffee/maker/out", "on")
        lamp, coffee = house.sighted()
        assert (lamp.key, lamp.service_type) == (KEY, "lights")
        assert (lamp.address, lamp.command_address) == (LAMP, "home425/lights/lamp/in")
        assert [(one.id, one.service_type) for one in lamp.parts] == [("", "light")]
        assert (coffee.service_type, coffee.parts) == ("coffee", ())
        assert house.told() == [(KEY, {".on_off": True}, False)]


async def test_a_word_is_reported_when_it_is_another_one() -> None:
    """What says nothing of a lamp is no report, and neither is what is no text or no word."""
    async with simple_house(**THESIS) as house:
        for word in ("on", "on", "0.4", "purple", b"\xff", "2" * 5000, "0.4", "off"):
            await house.say(LAMP, word)
        said = (
            {".on_off": True},
            {".level": 40.0, ".on_off": True},
            {".level": 40.0, ".on_off": True},
            {".on_off": False},
        )
        assert house.told() == [(KEY, one, False) for one in said]
        assert house.gateway.counters.reports == 4
        assert house.gateway.counters.received == 8


async def test_a_retained_state_is_reported_again_when_the_device_publishes_it() -> None:
    """It was, and now it is."""

    async def before(devices: MqttConnection) -> None:
        await devices.publish(LAMP, b"on", qos=1, retain=True)

    async with simple_house(before, **THESIS) as house:
        assert house.told() == [(KEY, {".on_off": True}, True)]
        await house.say(LAMP, "on")
        await house.say(LAMP, "on")
        assert house.told() == [(KEY, {".on_off": True}, False)]


async def test_a_device_that_is_taken_out_leaves_no_report_behind() -> None:
    async with simple_house(**THESIS) as house:
        await house.say(LAMP, "on", retain=True)
        await house.say(LAMP, "", retain=True)
        assert house.told() == [(KEY, {".on_off": True}, False)]
        late = house.watcher.create_subscription(Report, house.gateway.names.readings, qos_profile=LATCHED)
        assert late.take() is None
        response = await house.command(KEY, "", "on_off", value=True)
        assert (response.success, response.problem) == (False, "refused")
        await house.say(LAMP, "on")
        assert house.told() == [(KEY, {".on_off": True}, False)]


@pytest.mark.parametrize(
    ("device", "capability", "value", "word"),
    [
        ("lights/lamp", "on_off", True, "on"),
        ("lights/lamp", "level", 40.0, "0.4"),
        ("lights/lamp", "color_temperature", 2700.0, "2700 K, on"),
        ("windows/motor", "movement", "closed", "close"),
        ("covers/blind", "movement", "stopped", "stop"),
        ("covers/blind", "position", 25.0, "0.25"),
        ("locks/door", "lock", "unlocked", "unlock"),
        ("thermostats/hall", "heating_setpoint", 21.5, "21.5"),
    ],
)
async def test_a_command_goes_out_as_a_word(device: str, capability: str, value: PlainValue, word: str) -> None:
    async with simple_house(**THESIS) as house:
        await house.listen("home425/+/+/in")
        await house.say(f"home425/{device}/out", "hello")
        assert (await house.command(device, "", capability, value)).success
        heard = await house.heard()
        assert {(one.topic, one.retain) for one in heard} == {(f"home425/{device}/in", False)}
        assert ", ".join(one.payload.decode() for one in heard) == word
        assert house.gateway.counters.commands == 1


@pytest.mark.parametrize(
    ("key", "part", "capability", "value", "why"),
    [
        ("lights/lamp", "", "color", (0.0, 100.0), "this part takes on, off, 2700 K, a number from 0 to 1"),
        ("lights/lamp", "", "level", 101.0, "this part takes"),
        ("lights/lamp", "second", "on_off", True, "it has no part 'second'"),
        ("motions/hall", "", "occupancy", True, "this part takes nothing"),
        ("coffee/maker", "", "on_off", True, "this part takes nothing"),
        (
            "lights/nobody",
            "",
            "on_off",
            True,
            "no announcement of it was accepted since this gateway started; restart the device",
        ),
    ],
)
async def test_a_command_without_a_word_is_refused_with_the_reason(
    *, key: str, part: str, capability: str, value: PlainValue, why: str
) -> None:
    async with simple_house(**THESIS) as house:
        for device in ("lights/lamp", "motions/hall", "coffee/maker"):
            await house.say(f"home425/{device}/out", "hello")
        response = await house.command(key, part, capability, value)
        assert (response.success, response.problem) == (False, "refused")
        assert why in response.message
        assert house.gateway.counters.commands_refused == 1


@pytest.mark.parametrize("way", ["command", "word"])
async def test_the_answer_of_a_thermostat_is_its_target_and_not_the_room(way: str) -> None:
    """The room's temperature comes later, and may be the same number then."""
    out, key = "home425/thermostats/hall/out", "thermostats/hall"
    async with simple_house(**THESIS) as house:
        await house.say(out, "18.5")
        if way == "command":
            await house.command(key, "", "heating_setpoint", 21.0)
        else:
            raw = house.watcher.create_publisher(RawCommand, house.gateway.names.out)
            await raw.send(RawCommand(address="home425/thermostats/hall/in", payload="21"))
        for word in ("21", "20.9", "21"):
            await house.say(out, word)
        assert [one[1] for one in house.told()] == [
            {".local_temperature": 18.5},
            {".heating_setpoint": 21.0},
            {".local_temperature": 20.9},
            {".local_temperature": 21.0},
        ]


async def test_the_topic_of_a_device_may_be_the_state_topic_of_an_announced_one_too() -> None:
    """Each understands what it can; the bytes are handed on once."""
    both = ("tests.gateways.mqtt.simple_house:SimpleConvention", "thesis")
    async with simple_house(conventions=both) as house:
        await house.announce("shadow", state=LAMP)
        await house.say(LAMP, "on_off=on")
        client = house.watcher.create_client(SubscribeToTopic, house.gateway.names.subscribe)
        answer = await client.call(SubscribeToTopicRequest(topic=LAMP, listener=house.watcher.full_name))
        inbox = house.watcher.create_subscription(RawMessage, answer.data_topic, qos_profile=10)
        await house.say(LAMP, "off")
        assert {one.key for one in house.sighted()} == {"simple:shadow", KEY}
        assert house.told() == [("simple:shadow", {"lamp.on_off": True}, False), (KEY, {".on_off": False}, False)]
        raw = inbox.take()
        assert raw is not None
        assert (raw.key, raw.payload, inbox.take()) == (KEY, b"off", None)


async def test_no_topic_of_the_layout_is_subscribed_to_by_itself() -> None:
    """The filters of the layout bring everything, at QoS 1, and a second subscription would bring it twice."""
    async with simple_house(**THESIS) as house:
        await house.say(LAMP, "on")
        assert not house.gateway._described._topics.users


async def test_a_publication_of_an_app_on_a_state_topic_is_no_device() -> None:
    async with simple_house(**THESIS) as house:
        raw = house.watcher.create_publisher(RawCommand, house.gateway.names.out)
        await raw.send(RawCommand(address=LAMP, payload="on"))
        await house.say("home425/lights/other/out", "on")
        assert [one.key for one in house.sighted()] == ["lights/other"]


async def test_a_message_that_the_broker_had_kept_is_no_sign_of_life() -> None:
    """Not even when it comes again on a new link, minutes later."""

    async def before(devices: MqttConnection) -> None:
        await devices.publish(LAMP, b"on", qos=1, retain=True)

    async with simple_house(before, **THESIS) as house:
        assert [one.confirmed for one in house.sighted()] == [False]
        await anyio.sleep(100)
        await house.cut()
        assert house.sighted() == []
        await house.say(LAMP, "on")
        assert [(one.kind, one.confirmed) for one in house.sighted()] == [("updated", True)]


class BellSettings(BaseModel):
    """The convention has none."""


class Bells:
    """``bell/NAME/says`` and ``bell/NAME/do``: a convention of somebody else's whose topics announce."""

    Settings: ClassVar[type[BaseModel]] = BellSettings
    name: ClassVar[str] = "bells"

    def __init__(self, settings: BaseModel) -> None:
        del settings
        self.rejected = 0

    def filters(self) -> tuple[str, ...]:
        return ("bell/+/says",)

    def birth_messages(self) -> tuple[Publication, ...]:
        return ()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[DeviceAnnounced, ...]:
        del payload, retained
        device = self.announced(topic)
        return () if device is None else (device,)

    def announced(self, topic: str) -> DeviceAnnounced | None:
        if not topic.endswith("/says"):
            return None
        name = topic.split("/")[1]
        if name == "broken":
            raise RuntimeError("crash")
        capability = Capability(name="on_off", settable=True)
        part = Part(
            id="", service_type="siren", capabilities=(capability,), reads=(topic,), writes=(f"bell/{name}/do",)
        )
        endpoint = TextEndpoint("bells", topic, f"bell/{name}/do")
        return DeviceAnnounced(
            f"bell {name}", self.name, (), name, (DescribedPart(part, TextCodec(part)),), topic, text=endpoint
        )


async def test_devices_of_a_foreign_convention_may_publish_text_too() -> None:
    async with simple_house(conventions=(f"{__name__}:Bells", "thesis")) as house:
        await house.listen("bell/+/do")
        for _ in range(2):
            await house.say("bell/door/says", "on")
        (bell,) = house.sighted()
        assert (bell.key, bell.service_type, bell.address) == ("bell door", "bells", "bell/door/says")
        assert house.told() == [("bell door", {".on_off": True}, False)]
        assert (await house.command("bell door", "", "on_off", value=False)).success
        (heard,) = await house.heard()
        assert (heard.topic, heard.payload) == ("bell/door/do", b"off")


async def test_a_convention_that_fails_on_a_topic_costs_its_message_alone() -> None:
    async with simple_house(conventions=(f"{__name__}:Bells",)) as house:
        await house.say("bell/broken/says", "on")
        await house.say("bell/door/says", "on")
        assert [one.key for one in house.sighted()] == ["bell door"]
        assert house.gateway.counters.failures == 1
