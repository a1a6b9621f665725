"""How much memory announcements may take, held to a simple account of what stands."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.gateways.mqtt.codes_of_real_devices import CODES

from homebot.conventions.description import DescribedPart, DeviceAnnounced, Publication
from homebot.conventions.homeassistant import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.conventions.zigbee2mqtt import Zigbee2Mqtt, Zigbee2MqttSettings
from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.announced.registry import MAX_MEMORY, MemoryAccount, RegistryLimits
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.mqtt.broker import BrokerLimits

REAL = Path(__file__).parents[2] / "conventions" / "zigbee2mqtt" / "both_announcements.jsonl"
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
def test_what_stands_has_room_and_gives_it_back(steps: list[tuple[str, tuple[int, tuple[str, ...]] | None]]) -> None:
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
        assert {stored.described.key for stored in registry.all()} == set(standing)
    for key in tuple(standing):
        registry.remove(f"test:{key}")
    assert registry.memory == 0


def test_the_refusal_says_what_to_do() -> None:
    account = MemoryAccount(MOST)
    account.put(described("one", 20))
    with pytest.raises(WireError, match=re.escape("'two' does not fit: announcements take 74,752 bytes")) as no:
        account.check(described("two", 20), None)
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
    account = MemoryAccount()
    for one in announced_by_real_devices():
        account.put(one)
    models = len(REAL.read_text(encoding="utf-8").splitlines())
    assert models > 100
    assert account.total / models * ALL_MODELS < MAX_MEMORY


@pytest.mark.parametrize(("devices", "parts"), [(500, 30), (10_000, 1), (10_000, 3)])
def test_large_houses_fit_with_room(devices: int, parts: int) -> None:
    account = MemoryAccount()
    for number in range(devices):
        one = described(str(number), parts, f"mac:{number}")
        account.check(one, None)
        account.put(one)
    assert account.total < MAX_MEMORY / 2


@pytest.mark.virtual_time
async def test_what_is_one_too_many_is_counted_and_told(
    make_house: Callable[..., AbstractAsyncContextManager[Any]],
) -> None:
    async with make_house(max_memory=1024 * KB) as house:
        for number in range(80):
            await house.announce(f"lamp{number}")
        assert len(house.sighted()) == 64
        assert house.gateway.counters.devices_refused == 80 - 64


def test_at_our_own_broker_every_device_that_fits_is_heard() -> None:
    """Each tells its state on a topic of its own, and the gateway is one session there."""
    one = taken({"a": described("a")})
    assert MAX_MEMORY // one <= BrokerLimits().max_subscriptions < BrokerLimits().max_all_subscriptions
