"""What announcements are longer than what they offer explains, held to a simple account of what stands."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.gateways.mqtt.codes_of_real_devices import CODES

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.announced.registry import MAX_EXCESS, MAX_EXCESS_EACH, RegistryLimits, excess_of
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.state_topics import StateTopics

REAL = Path(__file__).parents[2] / "conventions" / "zigbee2mqtt" / "both_announcements.jsonl"
ORIGIN = {"name": "Zigbee2MQTT", "sw": "2.1.1", "url": "https://www.zigbee2mqtt.io"}
CONFIGS_OF_THE_LARGEST_HOUSE = 35_981
MOST, MOST_EACH = 20_000, 9_000


class Silent:
    def topics(self) -> tuple[str, ...]:
        return ()

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        del topic, payload, retained
        return {}

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        del value, transition
        raise RefusedError(capability, "it takes nothing")


def described(key: str, *options: str, parts: int = 1) -> DeviceAnnounced:
    choice = Capability(name="option", options=options)
    made = [Part(id=str(number), service_type="select", capabilities=(choice,)) for number in range(parts)]
    return DeviceAnnounced(key, "test", (), key, tuple(DescribedPart(one, Silent()) for one in made), f"hello/{key}")


def empty() -> AnnouncementRegistry:
    return AnnouncementRegistry("mqtt", (), StateTopics(()), RegistryLimits(excess=MOST, excess_each=MOST_EACH))


def test_what_real_devices_announce_fits_in_the_largest_house() -> None:
    """Their 1,495 configs as they are; as many as one real house had would take a small part of the room."""
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    excess = count = 0
    for line in REAL.read_text(encoding="utf-8").splitlines():
        model = json.loads(line)
        for where, config in model["discovery"].items():
            payload = json.dumps({**config, "device": model["device"], "origin": ORIGIN}).encode()
            for heard in convention.read_message(f"homeassistant/{where}/config", payload, retained=True):
                assert isinstance(heard, DeviceAnnounced) is (where not in CODES)
                if not isinstance(heard, DeviceAnnounced):
                    continue
                excess += excess_of(heard, len(payload))
                count += 1
    assert count > 1_000
    assert excess / count * CONFIGS_OF_THE_LARGEST_HOUSE < MAX_EXCESS / 4


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
    assert excess_of(described("a"), 100_000) > 90_000
    assert excess_of(described("a"), 0) == 0


@pytest.mark.parametrize("parts", [1, 100])
def test_a_part_explains_a_kilobyte(parts: int) -> None:
    assert excess_of(described("a", parts=parts), 1024 * parts) == 0


LENGTHS = st.one_of(st.integers(0, 5_000), st.integers(0, 20_000))
STEPS = st.lists(st.tuples(st.sampled_from("abcdef"), st.none() | LENGTHS), max_size=40)


@given(STEPS)
def test_what_stands_has_room_and_gives_it_back(steps: list[tuple[str, int | None]]) -> None:
    """A newcomer over the limit is refused, what stands stays and may become shorter; what is gone counts no more."""
    registry, standing = empty(), dict[str, int]()
    for key, length in steps:
        if length is None:
            registry.remove(f"test:{key}")
            standing.pop(key, None)
        else:
            one = described(key)
            excess, before = excess_of(one, length), standing.get(key, 0)
            fits = excess <= MOST_EACH and sum(standing.values()) - before + excess <= MOST
            if fits or excess <= before:
                registry.put(one, length)
                standing[key] = excess
            else:
                with pytest.raises(WireError, match="too long for its parts"):
                    registry.put(one, length)
        assert registry.excess == sum(standing.values()) <= MOST
        assert {stored.described.key for stored in registry.all()} == set(standing)


def test_an_honest_newcomer_is_taken_when_long_ones_have_taken_all_room() -> None:
    registry = empty()
    refused = 0
    for number in range(5):
        try:
            registry.put(described(f"long {number}"), MOST_EACH)
        except WireError:
            refused += 1
    assert refused
    registry.put(described("honest"), 2_000)
    assert registry.get("test:honest") is not None
