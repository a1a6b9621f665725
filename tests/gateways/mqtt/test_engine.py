"""What the gateway makes of devices that announce themselves, from the first word to the last."""

import asyncio

import anyio
import pytest
from structlog.testing import capture_logs
from tests.busy_clock import BusyClock
from tests.gateways.mqtt.simple_house import SimpleCodec, simple_house

from homebot.devices import RawCommand
from homebot.devices.gateway_messages import Report
from homebot.devices.names import text_address
from homebot.graph import DurabilityPolicy, QoSProfile
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.testing.gateway_contract.steps import kept

pytestmark = pytest.mark.virtual_time


LAMP = "simple:lamp1"
CONVENTION = "tests.gateways.mqtt.simple_house:SimpleConvention"


async def test_an_announced_device_is_sighted_with_its_parts() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", name="Kitchen lamp", area="kitchen", ids="0x00158d0001abcdef")

        (sighting,) = house.sighted()
        assert (sighting.kind, sighting.key, sighting.confirmed) == ("appeared", LAMP, False)
        assert (sighting.name, sighting.area, sighting.service_type) == ("Kitchen lamp", "kitchen", "light")
        assert sighting.convention == "simple"
        assert sighting.identifiers == ("eui64:00158d0001abcdef",)
        assert sighting.announced_on == "hello/lamp1"
        assert sighting.address == sighting.command_address == text_address(LAMP, "lamp")
        assert [part.id for part in sighting.parts] == ["lamp"]
        assert {fact.key: fact.value for fact in sighting.metadata} == {"model": "simple"}


async def test_an_announcement_that_the_broker_kept_is_found_at_the_start_with_the_state_beside_it() -> None:
    async def past(devices: MqttConnection) -> None:
        await devices.publish("hello/lamp1", b"{}", retain=True, qos=1)
        await devices.publish("lamp1/state", b"on_off=on", retain=True, qos=1)

    async with simple_house(before=past) as house:
        assert [(one.key, one.confirmed) for one in house.sighted()] == [(LAMP, False)]
        assert house.told() == [(LAMP, {"lamp.on_off": True}, True)]


async def test_only_a_device_that_speaks_itself_is_confirmed_and_that_once_a_second() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("lamp1/state", "nothing of it")
        assert [one.confirmed for one in house.sighted()] == [False]

        await house.say("lamp1/state", "on_off=on")
        await house.say("lamp1/state", "on_off=off")
        assert [(one.kind, one.confirmed) for one in house.sighted()] == [("updated", True)]
        await anyio.sleep(1.1)
        await house.say("lamp1/state", "on_off=on")
        assert [one.confirmed for one in house.sighted()] == [True]


async def test_a_live_announcement_of_the_device_itself_is_a_sign_of_life() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", is_live=True)
        assert [one.confirmed for one in house.sighted()] == [True]


async def test_one_message_of_several_parts_is_one_report_and_unknown_is_a_value() -> None:
    async with simple_house() as house:
        await house.announce("strip", parts="left right")
        await house.say("strip/state", "on_off=? level=high")

        ((key, readings, retained),) = house.told()
        assert (key, retained) == ("simple:strip", False)
        assert readings == {
            "left.on_off": None,
            "left.level": "high",
            "right.on_off": None,
            "right.level": "high",
        }


async def test_a_device_says_what_it_said_at_once_in_one_report_on_a_slow_computer_too() -> None:
    """Each slice of the work made a report of its own, and a late joiner got those of all that had ever been."""
    names = [f"lamp{number}" for number in range(80)]
    async with simple_house(clock=BusyClock) as house:
        for key in ("hall", "attic"):
            await house.announce(key, parts=" ".join(names), state=" ".join(["shared"] * 80))
        house.told()
        await house.say("shared", "on_off=on")
        assert [(key, len(values)) for key, values, _ in house.told()] == [("simple:hall", 80), ("simple:attic", 80)]


async def test_one_topic_may_be_read_by_several_devices() -> None:
    async with simple_house() as house:
        await house.announce("one", state="shared/state")
        await house.announce("two", state="shared/state")
        await house.say("shared/state", "on_off=on")
        assert [key for key, _, _ in house.told()] == ["simple:one", "simple:two"]


async def test_a_device_that_is_described_later_than_its_topic_spoke_is_told_what_was_said() -> None:
    """The broker does not send a kept message again to who has the topic already."""
    async with simple_house() as house:
        await house.announce("one", state="shared/state", online="bridge/state")
        await house.say("bridge/state", "online", retain=True)
        await house.say("shared/state", "on_off=on")
        house.told()
        await house.announce("two", state="shared/state", online="bridge/state")
        assert house.told() == [
            ("simple:two", {"lamp.on_off": True}, True),
            ("simple:two", {".reachable": True}, True),
        ]


async def test_a_device_that_speaks_on_a_filter_is_heard_on_each_topic() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", state="lamp1/+/state")
        await house.say("lamp1/a/state", "on_off=on")
        await house.say("lamp1/b/state", "on_off=off")
        assert len(house.told()) == 2


@pytest.mark.parametrize("state", ["#", "+/state", "$share/a/b", "a#", "x" * 1001])
async def test_a_state_topic_for_everything_or_for_nothing_is_not_subscribed_to(state: str) -> None:
    """The device is there all the same."""
    async with simple_house() as house:
        await house.announce("lamp1", state=state)
        assert len(house.sighted()) == 1
        assert house.gateway.counters.topics_refused == 1
        await house.say("lamp1/state", "on_off=on")
        assert house.told() == []


async def test_a_new_description_takes_the_place_of_the_old_one() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", state="old/state")
        await house.announce("lamp1", state="new/state", name="New")
        assert [(one.kind, one.name) for one in house.sighted()] == [("appeared", "lamp1"), ("updated", "New")]
        await house.say("old/state", "on_off=on")
        assert house.told() == []
        await house.say("new/state", "on_off=on")
        assert len(house.told()) == 1


async def test_the_same_description_again_is_no_news() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.announce("lamp1")
        assert len(house.sighted()) == 1


async def test_the_first_word_after_an_announcement_is_a_sign_of_life() -> None:
    """Also within the second in which another one would be passed over, and sighted before it is reported."""
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("lamp1/state", "on_off=on")
        await anyio.sleep(5)
        await house.announce("lamp1")
        house.sighted()
        await house.say("lamp1/state", "on_off=off")
        assert [one.confirmed for one in house.sighted()] == [True]


async def test_a_device_that_is_taken_back_is_gone_ten_seconds_later() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("hello/lamp1", "", retain=True)
        await anyio.sleep(9)
        assert [one.kind for one in house.sighted()] == ["appeared"]
        await anyio.sleep(2)
        (gone,) = house.sighted()
        assert (gone.kind, gone.key, gone.why) == ("removed", LAMP, "it was withdrawn")
        await house.say("lamp1/state", "on_off=on")
        assert house.told() == []


async def test_an_announcement_through_the_gateway_itself_is_heard() -> None:
    """An imported device, and one whose announcement was purged; the broker does not bring back what we publish."""
    async with simple_house() as house:
        out = house.watcher.create_publisher(RawCommand, house.gateway.names.out)
        out.publish(RawCommand(address="hello/lamp1", payload="{}", retain=True))
        await anyio.sleep(0.01)
        assert [(one.kind, one.key) for one in house.sighted()] == [("appeared", LAMP)]
        await house.say("lamp1/state", "on_off=on")
        assert house.told() == [(LAMP, {"lamp.on_off": True}, False)]
        house.sighted()
        out.publish(RawCommand(address="lamp1/state", payload="on_off=off"))
        out.publish(RawCommand(address="hello/lamp1", payload="", retain=True))
        await anyio.sleep(11)
        assert [(one.kind, one.key) for one in house.sighted()] == [("removed", LAMP)]
        assert house.told() == []


async def test_a_device_that_is_renamed_is_never_gone() -> None:
    """Taken back, and announced again within ten seconds."""
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("hello/lamp1", "", retain=True)
        await anyio.sleep(2)
        await house.announce("lamp1", name="New")
        await anyio.sleep(20)
        assert [one.kind for one in house.sighted()] == ["appeared", "updated"]


async def test_a_device_that_is_known_to_be_gone_is_gone_at_once() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("hello/lamp1", "bye")
        assert [one.kind for one in house.sighted()] == ["appeared", "removed"]


async def test_the_reachability_of_a_device_is_unknown_before_its_first_report() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", online="bridge/state lamp1/online")
        await house.say("bridge/state", "online", retain=True)
        assert house.told() == []
        await house.say("lamp1/online", "online")
        await house.say("lamp1/online", "offline")
        await house.say("lamp1/online", "neither")
        assert house.told() == [(LAMP, {".reachable": True}, False), (LAMP, {".reachable": False}, False)]


async def test_a_further_announcement_of_a_device_has_the_reachability_that_is_known() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", ids="zigbee_17", online="bridge/state lamp1/online")
        await house.say("bridge/state", "online")
        await house.say("lamp1/online", "online")
        assert house.told() == [(LAMP, {".reachable": True}, False)]
        await house.announce("lamp1_update", ids="zigbee_17", online="bridge/state lamp1/online")
        assert house.told() == [(f"{LAMP}_update", {".reachable": True}, True)]
        await house.say("lamp1/online", "offline")
        assert house.told() == [(LAMP, {".reachable": False}, False), (f"{LAMP}_update", {".reachable": False}, False)]


async def test_a_live_word_makes_a_kept_offline_doubtful() -> None:
    async def past(devices: MqttConnection) -> None:
        await devices.publish("lamp1/online", b"offline", retain=True, qos=1)
        await devices.publish("hello/lamp1", b'{"online": "lamp1/online"}', retain=True, qos=1)

    async with simple_house(before=past) as house:
        assert house.told() == [(LAMP, {".reachable": False}, True)]
        await house.say("lamp1/state", "on_off=on")
        assert house.told() == [(LAMP, {"lamp.on_off": True}, False), (LAMP, {".reachable": None}, False)]


async def test_a_value_fades_and_a_new_one_begins_the_time_anew() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", fade=True)
        await house.say("lamp1/state", "on_off=on")
        await anyio.sleep(4)
        await house.say("lamp1/state", "on_off=on")
        await anyio.sleep(4)
        assert len(house.told()) == 2
        await anyio.sleep(2)
        assert house.told() == [(LAMP, {"lamp.on_off": False}, False)]
        await anyio.sleep(60)
        assert house.told() == []


async def test_a_value_that_ended_before_its_time_does_not_fade() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", fade=True)
        await house.say("lamp1/state", "on_off=on")
        await house.say("lamp1/state", "on_off=off")
        await anyio.sleep(60)
        assert len(house.told()) == 2


async def test_a_report_replaces_none_with_other_values_on_its_topic() -> None:
    """Tasmota and Shelly report each relay alone, on one topic for all: a slow reader needs every one."""
    async with simple_house() as house:
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        slow = house.watcher.create_subscription(Report, house.gateway.names.readings, qos_profile=qos)
        await house.announce("lamp1")
        for values in ("on_off=on", "power=off", "on_off=off", "power=off on_off=on", "power=on"):
            await house.say("lamp1/state", values)
        late = house.watcher.create_subscription(Report, house.gateway.names.readings, qos_profile=qos)
        for reports in (kept(slow), kept(late)):
            told = [{one.capability: one.value.plain() for one in report.readings} for report in reports]
            assert told == [{"on_off": False}, {"power": False, "on_off": True}, {"power": True}]


async def test_a_report_of_one_of_many_topics_replaces_none_of_another() -> None:
    """A device of Homie may have 500 properties, each with a topic, and publish them all at once."""
    async with simple_house() as house:
        topics = [f"lamp1/{number}" for number in range(500)]
        await house.announce("lamp1", parts=" ".join(f"p{number}" for number in range(500)), state=" ".join(topics))
        for topic in topics:
            await house.say(topic, "on_off=on")
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        late = house.watcher.create_subscription(Report, house.gateway.names.readings, qos_profile=qos)
        assert len(kept(late)) == 500


async def test_a_late_joiner_gets_the_newest_report_of_each_topic_and_none_of_what_was_removed_or_left() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", parts="a b", state="lamp1/a lamp1/b")
        await house.announce("lamp2")
        await house.say("lamp1/a", "on_off=on")
        await house.say("lamp1/a", "on_off=off")
        await house.say("lamp1/b", "on_off=on")
        await house.say("lamp2/state", "on_off=on")
        await house.say("hello/lamp2", "bye")
        await house.announce("lamp3")
        await house.say("lamp3/state", "on_off=on")
        await house.announce("lamp3", state="lamp3/moved")

        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        late = house.watcher.create_subscription(Report, house.gateway.names.readings, qos_profile=qos)
        told = [{one.part: one.value.plain() for one in report.readings} for report in kept(late)]
        assert told == [{"a": False}, {"b": True}]


async def test_a_device_is_asked_for_its_state_once_its_topics_are_subscribed_to_and_on_each_new_link() -> None:
    async with simple_house() as house:
        await house.listen("+/get")
        await house.announce("lamp1", asks=True, parts="a b")
        assert [one.topic for one in await house.heard()] == ["lamp1/get"]
        await house.announce("lamp1", asks=True, parts="a b")
        assert await house.heard() == []

        await house.cut()
        assert [one.topic for one in await house.heard()] == ["lamp1/get"]


@pytest.mark.parametrize(("seconds", "expiry"), [(0.0, None), (0.2, 1), (2.5, 2), (9.99, 9)])
async def test_a_command_expires_at_the_broker(seconds: float, expiry: int | None) -> None:
    """So that none is obeyed minutes later, by a device that was away."""
    async with simple_house() as house:
        await house.devices.subscribe(MqttSubscription("+/+/set", qos=1))
        await house.announce("lamp1")
        assert (await house.command(LAMP, "lamp", "on_off", True, seconds)).success
        (message,) = await house.heard()
        assert (message.qos, message.properties.message_expiry_interval) == (1, expiry)


async def test_a_thousand_devices_are_not_asked_within_a_second() -> None:
    async with simple_house() as house:
        await house.listen("+/get")
        for number in range(200):
            await house.devices.publish(f"hello/{number}", b'{"asks": 1}', qos=1)
        await anyio.sleep(1)
        assert 40 <= len(await house.heard()) <= 60
        await anyio.sleep(4)
        assert len(await house.heard()) > 130
        assert house.gateway.counters.asks == 200


async def test_a_device_that_identifies_itself_only_on_request_is_asked() -> None:
    async with simple_house() as house:
        await house.listen("ask/#")
        await house.say("hello/lamp1", "who?")
        assert [(one.topic, one.payload) for one in await house.heard()] == [("ask/lamp1", b"who are you")]


async def test_devices_are_asked_to_announce_themselves_on_each_link() -> None:
    async def listen(devices: MqttConnection) -> None:
        await devices.subscribe(MqttSubscription("please"))

    async with simple_house(before=listen, simple={"birth": "please"}) as house:
        assert [one.payload for one in await house.heard()] == [b"who"]
        await house.cut()
        assert [one.payload for one in await house.heard()] == [b"who"]


async def test_a_state_topic_that_an_announcement_filter_covers_is_heard_once() -> None:
    """Its kept message, which came before the description, is asked for all the same."""

    async def past(devices: MqttConnection) -> None:
        await devices.publish("covered/lamp1", b"on_off=on", retain=True, qos=1)

    async with simple_house(before=past) as house:
        await house.announce("lamp1", state="covered/lamp1")
        assert house.told() == [(LAMP, {"lamp.on_off": True}, True)]
        await house.say("covered/lamp1", "on_off=off")
        assert house.told() == [(LAMP, {"lamp.on_off": False}, False)]


async def test_a_device_that_speaks_where_others_announce_leaves_that_subscription_when_it_goes() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", state="hello/+")
        await house.announce("lamp2", state="hello/lamp1")
        await house.say("hello/lamp2", "bye")
        await house.say("hello/lamp1", "bye")
        house.sighted()
        await house.announce("lamp3")
        assert [one.key for one in house.sighted()] == ["simple:lamp3"]


async def test_the_bytes_of_a_state_topic_can_be_subscribed_to() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("lamp1/state", "on_off=on")
        answer = await house.subscribe("lamp1/state")
        assert [(one.key, one.payload) for one in answer.missed] == [(LAMP, b"on_off=on")]
        inbox = house.raw(answer)
        await house.say("lamp1/state", b"\xff")
        message = inbox.take()
        assert message is not None
        assert message.payload == b"\xff"
        assert not (await house.subscribe("nobody/state")).success


async def test_plain_words_may_be_listened_to_before_the_device_is_there() -> None:
    """An application that was there before the gateway asks for them as soon as that is back."""
    async with simple_house() as house:
        answer = await house.subscribe(text_address(LAMP, "lamp"))
        assert answer.success
        inbox = house.raw(answer)
        await house.announce("lamp1")
        await house.say("lamp1/state", "on_off=on level=7")
        message = inbox.take()
        assert message is not None
        assert (message.key, message.address, message.payload) == (LAMP, text_address(LAMP, "lamp"), b"on")
        assert inbox.take() is None


@pytest.mark.parametrize(
    ("key", "part", "capability", "why"),
    [
        (
            "simple:nobody",
            "lamp",
            "on_off",
            "no announcement of it was accepted since this gateway started; restart the device",
        ),
        (LAMP, "nothing", "on_off", "it has no part 'nothing'; it has 'lamp'"),
        (LAMP, "lamp", "level", "this part takes on_off"),
        (LAMP, "lamp", "crash", "its convention failed"),
    ],
)
async def test_a_command_that_cannot_be_is_refused_with_the_reason(
    key: str, part: str, capability: str, why: str
) -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        answer = await house.command(key, part, capability, True)
        assert (answer.success, answer.problem, answer.unable) == (False, "refused", True)
        assert why in answer.message
        assert house.gateway.counters.commands_refused == 1


async def test_a_gateway_that_only_observes_refuses_every_command_and_still_asks() -> None:
    async with simple_house(act=False) as house:
        await house.listen("lamp1/#")
        await house.announce("lamp1", asks=True)
        answer = await house.command(LAMP, "lamp", "on_off", True)
        assert (answer.problem, answer.unable, "only observes" in answer.message) == ("refused", True, True)
        assert [one.topic for one in await house.heard()] == ["lamp1/get"]


async def test_a_broken_announcement_costs_itself_alone() -> None:
    async with simple_house() as house:
        await house.say("hello/lamp1", "{broken")
        await house.say("hello/lamp2", "crash")
        await house.announce("lamp3")
        assert [one.key for one in house.sighted()] == ["simple:lamp3"]
        assert house.gateway.counters.announcements_rejected == 1
        assert house.gateway.counters.failures == 1


async def test_a_part_that_fails_costs_itself_alone() -> None:
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("lamp1/state", "crash")
        await house.say("lamp1/state", "on_off=on")
        assert len(house.told()) == 1
        assert house.gateway.counters.failures == 1


@pytest.mark.parametrize(
    "error", [asyncio.CancelledError(), SystemExit(1), GeneratorExit(), BaseExceptionGroup("", [SystemExit(1)])]
)
async def test_an_exception_of_a_convention_leaves_the_gateway_listening(
    error: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    """None of it ends the task that reads, which nobody would notice."""
    monkeypatch.setattr(SimpleCodec, "crash", error)
    async with simple_house() as house:
        await house.announce("lamp1")
        await house.say("hello/lamp2", "crash")
        await house.say("lamp1/state", "crash")
        assert (await house.command(LAMP, "lamp", "crash", True)).problem == "refused"
        await house.say("lamp1/state", "on_off=on")
        await house.announce("lamp3")
        assert len(house.told()) == 1
        assert {one.key for one in house.sighted()} == {LAMP, "simple:lamp3"}
        assert house.gateway.counters.failures == 3


async def test_an_announcement_with_half_a_surrogate_in_its_name_is_rejected() -> None:
    async with simple_house() as house:
        await house.say("hello/lamp1", '{"model": "\\ud800"}')
        assert house.sighted() == []
        await house.announce("lamp1")
        assert len(house.sighted()) == 1


async def test_a_flood_of_broken_announcements_is_counted_and_does_not_flood_the_log() -> None:
    """At most 20 culprits are named in ten seconds."""
    async with simple_house() as house:
        with capture_logs() as lines:
            for number in range(1000):
                await house.devices.publish(f"hello/{number}", b"{broken", qos=1)
            await house.announce("lamp1")
        assert house.gateway.counters.announcements_rejected == 1000
        assert sum(line["event"] == "gateway.announcement_rejected" for line in lines) == 20
        assert [one.key for one in house.sighted()] == [LAMP]
        assert (await house.health()).quarantined == ()


async def test_a_message_of_state_that_is_too_long_is_not_looked_at() -> None:
    async with simple_house(max_payload=2048, conventions=("thesis", CONVENTION)) as house:
        await house.announce("lamp1")
        await house.say("lamp1/state", b"on_off=on " * 300)
        await house.say("home425/lights/lamp2/out", b"on" * 2000)
        assert house.told() == []
        assert [one.key for one in house.sighted()] == [LAMP]
        assert house.gateway.counters.oversize == 2


async def test_a_long_announcement_is_read_as_nothing_else() -> None:
    async with simple_house(max_payload=2048) as house:
        await house.announce("lamp1", state="hello/lamp1")
        before = house.gateway.counters.announcements
        await house.announce("lamp1", state="hello/lamp1", name="x on_off=on " * 90_000)
        assert house.gateway.counters.announcements == before + 1
        assert house.told() == []
        assert house.gateway.counters.oversize == 1


async def test_an_announcement_may_also_be_a_state_and_as_long() -> None:
    async with simple_house(max_payload=2048) as house:
        await house.announce("lamp1", state="hello/lamp1")
        await house.announce("lamp1", state="hello/lamp1", name="x on_off=on x" * 300)
        assert len(house.told()) == 1
        assert house.gateway.counters.oversize == 0


async def test_the_message_that_makes_a_device_known_is_read_as_its_state_once() -> None:
    async with simple_house() as house:
        await house.announce("lamp1", retain=False, state="hello/lamp1", name="x on_off=on x")
        assert house.told() == [(LAMP, {"lamp.on_off": True}, False)]
        await house.announce("lamp1", retain=False, state="hello/lamp1", name="y on_off=off y")
        assert house.told() == [(LAMP, {"lamp.on_off": False}, False)]


async def test_dropped_messages_are_among_the_counts_of_health() -> None:
    """A link of MQTT 3.1.1 brings what is too large, and its client drops it."""
    async with simple_house(protocol="3.1.1", max_payload=1024, max_announcement=4096) as house:
        await house.announce("lamp1", name="x" * 5000)
        assert house.sighted() == []
        counts = {one.name: one.count for one in (await house.health()).counts}
        assert (counts["dropped_oversize"], counts["dropped_overflow"], counts["dropped_malformed"]) == (1, 0, 0)


async def test_an_announcement_is_no_broken_topic_to_the_layout_of_every_home() -> None:
    async with simple_house(conventions=("thesis", CONVENTION), root="") as house:
        await house.announce("lamp1", state="a/b/c/d/e")
        await house.say("a/b/c/d/e", "on_off=on")
        await house.say("home/lights/lamp2/out", "on")
        assert house.gateway.counters.rejected == 0
        assert house.gateway.counters.received == 2
        assert {one.key for one in house.sighted()} == {LAMP, "home/lights/lamp2"}
