"""The memory and the excess length of announcements, compared with simple accounts."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.gateways.mqtt.codes_of_real_devices import CODES
from tests.gateways.mqtt.simple_house import simple_house

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.announced.registry import MAX_EXCESS, MAX_EXCESS_EACH, MAX_MEMORY, RegistryLimits, excess_of
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings
from homebot.mqtt.broker import BrokerLimits

REAL = Path(__file__).parents[2] / "integrations" / "zigbee2mqtt" / "formats" / "both_announcements.jsonl"
ALL_MODELS = 4_478
KB = 1024
MOST = 100 * KB


class Silent:
    def topics(self) -> tuple[str, ...]:
        return ()

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        del topic, payload, retained
        return {}

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        del value, transition
        raise RefusedError(capability, "it takes nothing")


def described(key: str, parts: int = 1, *identifiers: str) -> DeviceAnnounced:
    made = (DescribedPart(Part(id=str(number), service_type="light"), Silent()) for number in range(parts))
    return DeviceAnnounced(key, "test", identifiers, key, tuple(made), f"hello/{key}")


def taken(standing: Mapping[str, DeviceAnnounced]) -> int:
    """What the docs say."""
    devices = len({one.identifiers or one.key for one in standing.values()})
    return sum(5 * KB + 3 * KB * len(one.parts) for one in standing.values()) + 8 * KB * devices


WHO = st.sampled_from([(), ("mac:1",), ("mac:2",)])
STEPS = st.lists(st.tuples(st.sampled_from("abcdef"), st.none() | st.tuples(st.integers(1, 12), WHO)), max_size=40)


@given(STEPS)
def test_registered_announcements_take_room_and_give_it_back(
    steps: list[tuple[str, tuple[int, tuple[str, ...]] | None]],
) -> None:
    """What is one too many is refused and leaves all as it was; what is gone counts no more."""
    registry = AnnouncementRegistry("mqtt", (), StateTopics(()), RegistryLimits(memory=MOST))
    standing: dict[str, DeviceAnnounced] = {}
    for key, wanted in steps:
        if wanted is None:
            registry.remove(f"test:{key}")
            standing.pop(key, None)
        else:
            one = described(key, wanted[0], *wanted[1])
            try:
                registry.put(one)
            except WireError:
                assert taken({**standing, f"{key} as well": one}) > MOST
            else:
                standing[key] = one
        assert registry.memory == taken(standing) <= MOST
        assert {stored.described.key for stored in registry.by_key.values()} == set(standing)
    for key in tuple(standing):
        registry.remove(f"test:{key}")
    assert registry.memory == 0


def test_the_refusal_says_what_to_do() -> None:
    registry = AnnouncementRegistry("mqtt", (), StateTopics(()), RegistryLimits(memory=MOST))
    registry.put(described("one", 20))
    with pytest.raises(WireError, match=re.escape("'two' does not fit: announcements take 74,752 bytes")) as no:
        registry.put(described("two", 20))
    assert "raise max_memory of the gateway" in str(no.value)


def announced_by_real_devices() -> Iterator[DeviceAnnounced]:
    """The 196 models of the test data, by both of their ways."""
    configs = HomeAssistantDiscovery(HomeAssistantSettings())
    bridge = Zigbee2Mqtt(Zigbee2MqttSettings())
    for line in REAL.read_text(encoding="utf-8").splitlines():
        model = json.loads(line)
        for where, config in model["discovery"].items():
            payload = json.dumps({**config, "device": model["device"]}).encode()
            for heard in configs.read_message(f"homeassistant/{where}/config", payload, retained=True):
                assert isinstance(heard, DeviceAnnounced) is (where not in CODES)
                if not isinstance(heard, DeviceAnnounced):
                    continue
                yield heard
        entries = [{"type": "EndDevice", "supported": True, **model["entry"]}]
        for one in bridge.read_message("zigbee2mqtt/bridge/devices", json.dumps(entries).encode(), retained=True):
            if isinstance(one, DeviceAnnounced):
                yield one


def test_all_real_models_fit_by_both_of_their_ways() -> None:
    registry = AnnouncementRegistry("mqtt", (), StateTopics(()))
    for one in announced_by_real_devices():
        registry.put(one)
    models = len(REAL.read_text(encoding="utf-8").splitlines())
    assert models > 100
    assert registry.memory / models * ALL_MODELS < MAX_MEMORY


@pytest.mark.parametrize(("devices", "parts"), [(500, 30), (10_000, 1), (10_000, 3)])
def test_large_houses_fit_with_room(devices: int, parts: int) -> None:
    registry = AnnouncementRegistry("mqtt", (), StateTopics(()))
    for number in range(devices):
        registry.put(described(str(number), parts, f"mac:{number}"))
    assert registry.memory < MAX_MEMORY / 2


@pytest.mark.virtual_time
async def test_an_announcement_too_many_is_counted_and_reported() -> None:
    async with simple_house(max_memory=1024 * KB) as house:
        for number in range(80):
            await house.announce(f"lamp{number}")
        assert len(house.sighted()) == 64
        assert house.gateway.counters.devices_refused == 80 - 64


def test_at_our_own_broker_every_device_that_fits_is_heard() -> None:
    """Each tells its state on a topic of its own, and the gateway is one session there."""
    one = taken({"a": described("a")})
    assert MAX_MEMORY // one <= BrokerLimits().max_subscriptions < BrokerLimits().max_all_subscriptions


ORIGIN = {"name": "Zigbee2MQTT", "sw": "2.1.1", "url": "https://www.zigbee2mqtt.io"}
CONFIGS_OF_THE_LARGEST_HOUSE = 35_981
MOST_EXCESS, MOST_EACH = 20_000, 9_000


def choosing(key: str, *options: str, parts: int = 1) -> DeviceAnnounced:
    choice = Capability(name="option", options=options)
    made = [Part(id=str(number), service_type="select", capabilities=(choice,)) for number in range(parts)]
    return DeviceAnnounced(key, "test", (), key, tuple(DescribedPart(one, Silent()) for one in made), f"hello/{key}")


def empty() -> AnnouncementRegistry:
    return AnnouncementRegistry("mqtt", (), StateTopics(()), RegistryLimits(excess=MOST_EXCESS, excess_each=MOST_EACH))


def test_announcements_of_real_devices_fit_in_the_largest_house() -> None:
    """Their 1,495 configs as they are; as many as one real house had would take a small part of the room."""
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    sizes = []
    for line in REAL.read_text(encoding="utf-8").splitlines():
        model = json.loads(line)
        for where, config in model["discovery"].items():
            payload = json.dumps({**config, "device": model["device"], "origin": ORIGIN}).encode()
            for heard in convention.read_message(f"homeassistant/{where}/config", payload, retained=True):
                if isinstance(heard, DeviceAnnounced):
                    sizes.append(excess_of(heard, len(payload)))  # noqa: PERF401  # four loops in one line
    assert len(sizes) > 1_000
    assert sum(sizes) / len(sizes) * CONFIGS_OF_THE_LARGEST_HOUSE < MAX_EXCESS / 4


def test_a_list_of_two_thousand_long_options_is_excess() -> None:
    options = [f"{number:080}" for number in range(2000)]
    config = {"command_topic": "c", "state_topic": "s", "unique_id": "u", "options": options}
    payload = json.dumps(config).encode()
    (heard,) = HomeAssistantDiscovery(HomeAssistantSettings()).read_message(
        "homeassistant/select/d/config", payload, retained=True
    )
    assert isinstance(heard, DeviceAnnounced)
    assert 160_000 < excess_of(heard, len(payload)) < MAX_EXCESS_EACH


def test_the_length_of_a_message_counts_where_its_texts_are_not_seen() -> None:
    """Templates are inside the codecs."""
    assert excess_of(choosing("a"), 100_000) > 90_000
    assert excess_of(choosing("a"), 0) == 0


@pytest.mark.parametrize("parts", [1, 100])
def test_a_part_explains_a_kilobyte(parts: int) -> None:
    assert excess_of(choosing("a", parts=parts), 1024 * parts) == 0


LENGTHS = st.one_of(st.integers(0, 5_000), st.integers(0, 20_000))
EXCESS_STEPS = st.lists(st.tuples(st.sampled_from("abcdef"), st.none() | LENGTHS), max_size=40)


@given(EXCESS_STEPS)
def test_long_announcements_have_an_account_of_their_own(steps: list[tuple[str, int | None]]) -> None:
    """A newcomer over the limit is refused, what stands stays and may become shorter; what is gone counts no more."""
    registry, standing = empty(), dict[str, int]()
    for key, length in steps:
        if length is None:
            registry.remove(f"test:{key}")
            standing.pop(key, None)
        else:
            one = choosing(key)
            excess, before = excess_of(one, length), standing.get(key, 0)
            fits = excess <= MOST_EACH and sum(standing.values()) - before + excess <= MOST_EXCESS
            if fits or excess <= before:
                registry.put(one, length)
                standing[key] = excess
            else:
                with pytest.raises(WireError, match="too long for its parts"):
                    registry.put(one, length)
        assert registry.excess == sum(standing.values()) <= MOST_EXCESS
        assert {stored.described.key for stored in registry.by_key.values()} == set(standing)


def test_an_honest_newcomer_is_taken_when_long_ones_have_taken_all_room() -> None:
    registry = empty()
    refused = 0
    for number in range(5):
        try:
            registry.put(choosing(f"long {number}"), MOST_EACH)
        except WireError:
            refused += 1
    assert refused
    registry.put(choosing("honest"), 2_000)
    assert registry.by_key.get("test:honest") is not None
