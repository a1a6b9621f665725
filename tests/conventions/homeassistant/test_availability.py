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
