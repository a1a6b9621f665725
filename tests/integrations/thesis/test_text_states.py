"""Devices of the thesis's layout at the gateway: their words as reports, and commands as words."""

from itertools import pairwise
from typing import Any, ClassVar

import anyio
import anyio.lowlevel
import pytest
from pydantic import BaseModel
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import simple_house

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication, TextEndpoint
from homebot.conventions.text_codec import TextCodec
from homebot.devices import RawCommand, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.part import Capability, Part
from homebot.devices.services import NEVER
from homebot.devices.value import PlainValue
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.names import escape_token

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


async def test_devices_that_appear_all_at_once_leave_turns_to_others() -> None:
    """Each first text announces a device, which takes as long as another announcement: 78 ms a turn in a flood."""
    async with simple_house(**THESIS) as house, anyio.create_task_group() as tasks:
        known = house.gateway._described._registry.by_key
        tasks.start_soon(
            house.gateway._handle, [MqttMessage(f"home425/lights/l{number}/out", b"on") for number in range(600)]
        )
        counts = [0]
        while counts[-1] < 600:
            await anyio.lowlevel.checkpoint()
            counts.append(len(known))
        assert max(after - before for before, after in pairwise(counts)) <= 30


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
        assert [one.kind for one in house.sighted()] == ["appeared", "removed"]
        assert house.told() == [(KEY, {".on_off": True}, False)]
        sighted = house.watcher.create_subscription(Sighting, house.gateway.names.received_topics, qos_profile=LATCHED)
        assert sighted.take() is None
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
        inbox = house.raw(await house.subscribe(LAMP))
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


async def test_neither_a_publication_of_an_app_nor_a_command_is_a_device() -> None:
    async with simple_house(**THESIS) as house:
        raw = house.watcher.create_publisher(RawCommand, house.gateway.names.out)
        for address in (LAMP, "home425/lights/lamp/in"):
            await raw.send(RawCommand(address=address, payload="on"))
        await house.say("home425/lights/stranger/in", "on")
        await house.say("home425/lights/other/out", "on")
        assert [one.key for one in house.sighted()] == ["lights/other"]
        assert house.gateway.counters.received == 1


async def test_a_message_that_the_broker_had_kept_is_no_sign_of_life() -> None:
    """Not even when it comes again on a new link, minutes later; the log says that it may be a ghost."""

    async def before(devices: MqttConnection) -> None:
        await devices.publish(LAMP, b"on", qos=1, retain=True)

    with capture_logs() as lines:
        async with simple_house(before, **THESIS) as house:
            assert [one.confirmed for one in house.sighted()] == [False]
            await anyio.sleep(100)
            await house.cut()
            assert house.sighted() == []
            await house.say(LAMP, "on")
            assert [(one.kind, one.confirmed) for one in house.sighted()] == [("updated", True)]
    (told,) = (line for line in lines if line["event"] == "gateway.retained_only")
    assert f"{KEY} is known only from a retained message" in told["message"]


BROKEN = ("home425/lights", "home425//lamp/out", "home425/lights/lamp/out/deep", "home425/lights//out")


async def test_each_topic_that_breaks_the_layout_is_counted_and_named_once_with_the_reason() -> None:
    """The rest goes on."""
    async with simple_house(**THESIS) as house:
        with capture_logs() as lines:
            for topic in (*BROKEN, *BROKEN, LAMP):
                await house.say(topic, "on")
        assert [one.key for one in house.sighted()] == [KEY]
        assert house.gateway.counters.rejected == 2 * len(BROKEN)
    told = [line for line in lines if line["event"] == "gateway.message_rejected"]
    assert [line["topic"] for line in told] == list(BROKEN)
    assert all(repr(line["topic"]) in line["message"] for line in told)


@pytest.mark.parametrize("device_id", ["Küche 1", "0x00158d"])
async def test_an_odd_device_id_is_a_device_and_its_mirror_topic_is_escaped(device_id: str) -> None:
    """The escape is legal, visible and reversible; see homebot.names."""
    async with simple_house(**THESIS) as house:
        await house.say(f"home425/lights/{device_id}/out", "on")
        assert [one.name for one in house.sighted()] == [device_id]
        answer = await house.subscribe(f"home425/lights/{device_id}/out", listener="")
        assert answer.data_topic == f"/gateway/mqtt/received_data/{escape_token(device_id)}"


@pytest.mark.parametrize(
    ("topic", "reason"),
    [
        ("home425/+/lamp/out", "wildcard"),
        ("home425/lights/lamp/in", "no device publishes on topic"),
        ("home426/lights/lamp/out", "no device publishes on topic"),
        ("home425/lights", "1 levels"),
        ("", "is empty"),
    ],
)
async def test_a_topic_that_no_device_has_cannot_be_subscribed_to(topic: str, reason: str) -> None:
    async with simple_house(**THESIS) as house:
        answer = await house.subscribe(topic)
        assert not answer.success
        assert reason in answer.message


async def test_a_node_that_is_not_there_cannot_subscribe() -> None:
    async with simple_house(**THESIS) as house:
        assert "no such node" in (await house.subscribe(LAMP, listener="/nobody")).message


async def test_what_was_missed_comes_once() -> None:
    async with simple_house(**THESIS) as house:
        await house.say(LAMP, "on")
        assert [len((await house.subscribe(LAMP)).missed) for _ in range(2)] == [1, 0]


async def test_commands_to_illegal_addresses_are_refused_counted_and_told() -> None:
    """And the next good one goes through."""
    async with simple_house(**THESIS) as house:
        await house.listen("home425/lights/lamp/in")
        raw = house.watcher.create_publisher(RawCommand, house.gateway.names.out)
        with capture_logs() as lines:
            for address in ("home425/+/in", "", "a\0b", "home425/lights/lamp/in"):
                raw.publish(RawCommand(address=address, payload="off"))
            assert [one.payload for one in await house.heard()] == [b"off"]
        assert house.gateway.counters.commands_refused == 3
    assert any(line["event"] == "gateway.command_refused" and "wildcard" in line["message"] for line in lines)


async def test_clearing_a_topic_that_this_gateway_never_heard_removes_the_device_too() -> None:
    """The directory may know it from before the gateway's restart."""
    async with simple_house(**THESIS) as house:
        await house.say(LAMP, "", retain=True)
        assert [(one.key, one.kind) for one in house.sighted()] == [(KEY, "removed")]


async def test_devices_that_come_and_go_leave_nothing_behind() -> None:
    """However many names somebody invents."""
    async with simple_house(**THESIS) as house:
        for number in range(50):
            await house.say(f"home425/lights/{number}/out", "on")
            await house.say(f"home425/lights/{number}/out", "")
        assert len(house.sighted()) == 100
        assert house.gateway._described._listeners.by_address == {}


async def test_a_device_that_never_becomes_stale_has_the_last_time_there_is() -> None:
    """A time of ROS ends in 2038; a larger number must not crash the gateway with every message."""
    async with simple_house(stale_after=1e12, **THESIS) as house:
        await house.say(LAMP, "on")
        assert [one.expires_at for one in house.sighted()] == [NEVER]


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
