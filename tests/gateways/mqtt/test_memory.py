"""What a house takes in memory, in bytes that Python counts: the gateway's share and the directory's together."""

import gc
import json
import tracemalloc
from collections.abc import Callable

import pytest
from tests.sizes import size

from homebot.conventions.description import DeviceAnnounced
from homebot.discovery.index import DeviceIndex
from homebot.gateways.mqtt.registry import AnnouncementRegistry
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.messages import Time

pytestmark = pytest.mark.slow

DEVICES, PARTS = size(150, 400), 300


def many_devices(number: int) -> tuple[str, dict[str, object]]:
    """One of one part."""
    device = {"identifiers": [f"d{number}"], "name": f"D{number}"}
    config = {"unique_id": f"d{number}", "name": "T", "state_topic": f"s/{number}", "unit_of_measurement": "W"}
    return f"homeassistant/sensor/d{number}/config", {**config, "device": device}


def many_parts(number: int) -> tuple[str, dict[str, object]]:
    """One of 300 parts."""
    parts = {
        f"p{part}": {
            "p": "sensor",
            "unique_id": f"d{number}p{part}",
            "name": f"Part {part}",
            "state_topic": f"s/{number}",
            "value_template": f"{{{{ value_json.p{part} }}}}",
            "unit_of_measurement": "W",
        }
        for part in range(PARTS)
    }
    device = {"identifiers": [f"d{number}"], "name": f"D{number}"}
    return f"homeassistant/device/d{number}/config", {"device": device, "origin": {"name": "x"}, "components": parts}


def known(make: Callable[[int], tuple[str, dict[str, object]]], count: int) -> float:
    """Return what each of *count* devices takes, in bytes."""
    convention = HomeAssistantDiscovery(HomeAssistantSettings())
    registry, index = (
        AnnouncementRegistry("mqtt", (convention,), StateTopics(())),
        DeviceIndex(forget_after=1e6),
    )
    at, until = Time.from_seconds(1e9), Time.from_seconds(2e9)

    def take(number: int) -> None:
        topic, config = make(number)
        for heard in convention.read_message(topic, json.dumps(config).encode(), retained=False):
            assert isinstance(heard, DeviceAnnounced)
            change = registry.put(heard)
            seen = {"seen_at": at, "expires_at": until, "heard_at": 1.0, "confirmed": True}
            index.observe(change.stored.template.model_copy(update=seen), 1.0)
        index.pop_changes()

    for number in range(10):
        take(number)
    gc.collect()
    tracemalloc.start()
    try:
        for number in range(10, 10 + count):
            take(number)
        index.sort()
        gc.collect()
        return tracemalloc.get_traced_memory()[0] / count
    finally:
        tracemalloc.stop()


@pytest.mark.no_cover
@pytest.mark.parametrize(
    ("make", "count", "most"),
    [(many_devices, DEVICES, 14_500), (many_parts, size(4, 10), 2_400 * PARTS)],
    ids=["devices", "parts"],
)
def test_a_device_and_a_part_take_little(
    make: Callable[[int], tuple[str, dict[str, object]]], count: int, most: int
) -> None:
    known(make, count)  # fills caches that are bounded, with what other tests may have filled them with before
    assert known(make, count) < most
