"""Reserved topics: the same answer for a topic of any length, and no memory for long ones."""

import tracemalloc

import pytest

from homebot.conventions.installed_conventions import default_conventions, find_conventions
from homebot.gateways.mqtt.reserved import ReservedTopics


def reserved_topics() -> ReservedTopics:
    return ReservedTopics(find_conventions(default_conventions(), {}, "home425"))


def test_a_reserved_topic_is_reserved_whatever_its_length() -> None:
    topics = reserved_topics()
    for name in ("x", "x" * 1000):
        assert topics.why(f"homebot/{name}") == "it belongs to homebot"
        assert topics.why(f"$SYS/{name}") == "it belongs to the broker"
        assert topics.why(f"lamps/{name}/set") == ""
        assert topics.why(f"zigbee2mqtt/{name}/set", "zigbee2mqtt") == ""
        assert topics.why(f"gates/bridge/request/{name}") == ""  # of another program


@pytest.mark.rooms("zigbee2mqtt")
@pytest.mark.parametrize("name", ["x", "x" * 1000])
def test_a_request_to_the_bridge_of_a_convention_is_reserved(name: str) -> None:
    assert reserved_topics().why(f"zigbee2mqtt/bridge/request/{name}") == "it belongs to zigbee2mqtt"


def test_nothing_is_kept_of_long_topics() -> None:
    """Devices that never were can announce any number of them, of 65,535 bytes each."""
    topics = reserved_topics()
    topics.why("lamps/hall/set")
    tracemalloc.start()
    try:
        for number in range(500):
            assert topics.why(f"lamps/{number}/{'x' * 20_000}") == ""
        assert tracemalloc.get_traced_memory()[0] < 200_000
    finally:
        tracemalloc.stop()
