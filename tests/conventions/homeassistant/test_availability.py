from collections.abc import Mapping

import pytest

from homebot.conventions.description import Availability
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.device import MAX_SOURCES, read_availability
from homebot.errors import WireError


def availability(fields: Mapping[str, object]) -> Availability | None:
    return read_availability(DiscoveryConfig("light", "x", fields))


def test_without_topics_there_is_no_availability() -> None:
    assert availability({}) is None
    assert availability({"availability": []}) is None


def test_one_topic_has_two_payloads_and_others_are_ignored() -> None:
    told = availability({"availability_topic": "a/av", "payload_available": True, "payload_not_available": "no"})
    assert told is not None
    (source,) = told.sources
    assert [source.read(word) for word in (b"True", b"no", b"online", b"", b"\xff")] == [True, False, None, None, None]
    assert told.mode == "latest"


def test_a_list_has_a_template_per_topic_and_one_mode() -> None:
    told = availability(
        {
            "availability": [
                {"topic": "z/bridge/state", "value_template": "{{ value_json.state }}"},
                {"topic": "z/lamp/availability"},
            ],
            "availability_mode": "all",
        }
    )
    assert told is not None
    bridge, lamp = told.sources
    assert (told.mode, bridge.topic, lamp.topic) == ("all", "z/bridge/state", "z/lamp/availability")
    assert bridge.read(b'{"state": "online"}') is True
    assert bridge.read(b'{"state": "offline"}') is False
    assert bridge.read(b"online") is True
    assert bridge.read(b"[]") is None
    assert lamp.read(b"offline") is False


def test_one_entry_need_not_be_in_a_list() -> None:
    told = availability({"availability": {"topic": "a"}})
    assert told is not None
    assert told.sources[0].read(b"online") is True


@pytest.mark.parametrize(
    "fields",
    [
        {"availability": "a/av"},
        {"availability": [{}]},
        {"availability": [{"topic": "a+"}]},
        {"availability": [{"topic": ["a"]}]},
        {"availability": [{"topic": "a"}] * (MAX_SOURCES + 1)},
        {"availability": {"topic": "a"}, "availability_topic": "b"},
        {"availability": {"topic": "a"}, "availability_mode": "most"},
        {"availability_topic": "a", "payload_available": {}},
    ],
)
def test_an_invalid_availability_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        availability(fields)


def test_payloads_that_are_equal_in_python_differ() -> None:
    for word, said in ((1, b"1"), (True, b"True"), (1.0, b"1.0")):
        told = availability({"availability": {"topic": "same", "payload_available": word}})
        assert told is not None
        assert told.sources[0].read(said) is True


def test_devices_of_a_bridge_share_its_payloads() -> None:
    """Entries that are alike but for the topic: a house has one for each device."""
    template = "{{ value_json.state }}"
    entries = [{"topic": f"z/{name}/availability", "value_template": template} for name in ("a", "b")]
    one, other = (read_availability(DiscoveryConfig("light", "", {"availability": [entry]})) for entry in entries)

    assert one is not None
    assert other is not None
    assert [source.topic for found in (one, other) for source in found.sources] == [
        "z/a/availability",
        "z/b/availability",
    ]
    assert [found.sources[0].read(b'{"state": "online"}') for found in (one, other)] == [True, True]
    assert one != other
