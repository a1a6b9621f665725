"""A message that tells of hundreds of devices: taken in slices, bounded, and with the same result."""

import json
from collections.abc import Iterator
from itertools import repeat
from pathlib import Path

import anyio
import anyio.lowlevel
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.gateways.mqtt.known_house import known_house
from tests.gateways.mqtt.simple_house import SimpleConvention, simple_house
from tests.turns import Turns, longest_turn

from homebot.conventions.description import AnnouncementEvent, DeviceRequest, Publication
from homebot.conventions.long_json import parse_list
from homebot.conventions.payload import parse_json
from homebot.errors import WireError
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

pytestmark = pytest.mark.slow

TOPIC = "zigbee2mqtt/bridge/devices"
FIXTURE = Path(__file__).with_name("real_devices.jsonl")
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=20,
)


def house_of(count: int) -> bytes:
    """Return the list of a bridge with *count* devices of real models."""
    rows = [json.loads(line) for line in FIXTURE.read_text(encoding="utf-8").splitlines()]
    entries = [one for row in rows for topic, text in row["messages"] if topic == TOPIC for one in json.loads(text)]
    devices = [
        {**entries[number % len(entries)], "ieee_address": f"0x{number:016x}", "friendly_name": f"device {number}"}
        for number in range(count)
    ]
    return json.dumps(devices).encode()


def taken(text: bytes) -> object:
    try:
        return list(parse_list(text, 1_000_000))
    except WireError:
        return "no list"


@given(JSON, st.sampled_from([None, 1]))
def test_a_list_is_read_item_by_item_as_in_one_go(value: object, indent: int | None) -> None:
    text = json.dumps(value, indent=indent).encode()
    try:
        whole = parse_json(text, 1_000_000)
    except WireError:
        whole = None
    assert taken(text) == (whole if isinstance(whole, list) else "no list")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (b" [ ] ", []),
        (b"[1,2]", [1, 2]),
        (b"[1,]", "no list"),
        (b"[1 2]", "no list"),
        (b"[1]x", "no list"),
        (b"[", "no list"),
        (b"[1", "no list"),
        (b"[NaN]", "no list"),
        (b"\xff[", "no list"),
        (b"[" * 100_000, "no list"),
        (b'["\\ud800"]', "no list"),
        (b"[" + b"[" * 70 + b"]" * 71, "no list"),
        (b"", "no list"),
    ],
)
def test_an_invalid_list_is_refused(text: bytes, found: object) -> None:
    assert taken(text) == found


def test_a_broken_end_costs_the_whole_list_and_nothing_changes() -> None:
    """It was cut somewhere, and what is missing is not gone."""
    convention = Zigbee2Mqtt(Zigbee2MqttSettings())
    whole = house_of(20)
    assert len(convention.read_message(TOPIC, whole, retained=True)) == 20
    with pytest.raises(WireError):
        convention.read_message(TOPIC, house_of(10)[:-1], retained=True)
    assert convention.rejected == 1
    assert len(convention.read_message(TOPIC, whole, retained=True)) == 20


def test_a_long_list_is_taken_in_many_steps() -> None:
    convention = Zigbee2Mqtt(Zigbee2MqttSettings())
    steps = list(convention.read_message_in_slices(TOPIC, house_of(100), retained=True))
    assert steps.count(None) >= 200
    assert len(steps) - steps.count(None) == 100


@pytest.mark.no_cover
async def test_others_get_their_turns_while_a_large_bridge_is_taken() -> None:
    """Nobody waits longer than 50 ms, from the message until all are known."""
    assert 0 < await longest_turn(take_large_bridge, limit=0.05) < 0.05


async def take_large_bridge(turns: Turns) -> None:
    count = 200
    async with known_house() as house:
        directory = house.directory
        await house.wire.publish(TOPIC, house_of(count), qos=1, retain=True)  # the gateway may still be on its way
        while not len(directory.index):
            await anyio.lowlevel.checkpoint()
        while len(directory.index) < count:
            await anyio.lowlevel.checkpoint()
            turns.take()


class Endless(SimpleConvention):
    """Never stops telling."""

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> Iterator[AnnouncementEvent]:  # type: ignore[override]  # that is its fault
        if payload == b"endless":
            return repeat(DeviceRequest("lamp", (Publication("ask/lamp", b""),)))
        return iter(super().read_message(topic, payload, retained=retained))


@pytest.mark.virtual_time
async def test_a_convention_that_never_ends_costs_its_message_alone() -> None:
    async with simple_house(conventions=(f"{__name__}:Endless",)) as house:
        await house.say("hello/lamp", "endless")
        assert house.gateway.counters.announcements_rejected == 1
        await house.announce("other")
        assert [one.key for one in house.sighted()] == ["simple:other"]


@pytest.mark.virtual_time
async def test_a_list_that_the_broker_drops_for_its_length_is_a_trouble() -> None:
    """A link of MQTT 5: nobody is told."""
    async with simple_house(conventions=("zigbee2mqtt",), max_payload=1024, max_announcement=4096) as house:
        await house.say("zigbee2mqtt/bridge/info", {"version": "2.14.1"}, retain=True)
        await house.say("zigbee2mqtt/bridge/devices", b"[" + b" " * 5000 + b"]", retain=True)
        (trouble,) = (await house.health()).troubles
        assert "larger than max_announcement" in trouble
        await house.say("zigbee2mqtt/bridge/devices", "[]", retain=True)
        assert (await house.health()).troubles == ()
