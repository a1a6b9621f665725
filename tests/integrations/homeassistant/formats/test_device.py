from collections.abc import Mapping

import pytest

from homebot.conventions.description import Availability
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.device import MAX_SOURCES, cached_device, read_availability, read_device


def test_a_device_has_identifiers_area_and_facts() -> None:
    device = read_device(
        {
            "identifiers": ["zigbee2mqtt_0x00158d0001abcdef"],
            "connections": [["mac", "AA:BB:CC:DD:EE:FF"], ["ip", "10.0.0.3"]],
            "name": "Lamp\x00 by the <b>door</b>",
            "suggested_area": " Hall ",
            "manufacturer": "Maker",
            "model": "M",
            "model_id": 3,
            "sw_version": 1.5,
            "hw_version": "",
            "via_device": "bridge",
            "unheard_of": "x",
        },
        {"name": "Zigbee2MQTT", "sw_version": "2.1"},
    )
    assert device.identifiers == (
        "eui64:00158d0001abcdef",
        "mac:aabbccddeeff",
        "id:zigbee2mqtt_0x00158d0001abcdef",
        "id:ip:10.0.0.3",
    )
    assert (device.name, device.area) == ("Lamp by the <b>door</b>", "Hall")
    assert device.facts == {
        "manufacturer": "Maker",
        "model": "M",
        "model_id": "3",
        "sw_version": "1.5",
        "via_device": "bridge",
        "origin": "Zigbee2MQTT",
        "origin_sw_version": "2.1",
    }


def test_a_device_and_its_program_may_have_short_keys() -> None:
    device = {"ids": "x", "mf": "Maker", "sa": "Kitchen", "cmd_t": "no topic here"}
    origin = {"name": "bridge", "sw": "2.1", "url": "https://example.org"}

    found = cached_device(device, origin)

    assert (found.identifiers, found.area) == (("id:x",), "Kitchen")
    assert found.facts == {
        "manufacturer": "Maker",
        "origin": "bridge",
        "origin_sw_version": "2.1",
        "origin_url": "https://example.org",
    }


@pytest.mark.parametrize(("told", "problem"), [((3, None), "device is 3"), ((None, "me"), "origin is 'me'")])
def test_what_is_no_object_is_refused(told: tuple[object, object], problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        cached_device(*told)


@pytest.mark.parametrize("address", ["349454123456", "34:94:54:12:34:56"])
def test_a_connection_of_decimal_digits_is_a_hardware_address(address: str) -> None:
    assert read_device({"connections": [["mac", address]]}, {}).identifiers == ("mac:349454123456",)
    assert read_device({"identifiers": ["349454123456"]}, {}).identifiers == ("id:349454123456",)


@pytest.mark.parametrize(("version", "count"), [(1, 2), (2, 2), (3, 1), (4, 1), (5, 1), (6, 2), (7, 1), (8, 1)])
def test_only_a_uuid_that_is_made_of_a_hardware_address_ends_with_one(version: int, count: int) -> None:
    """RFC 9562, 5.1 to 5.8."""
    uuid = f"0192a3b4-c5d6-{version}abc-8def-b827eba1b2c3"
    assert len(read_device({"identifiers": [uuid]}, {}).identifiers) == count


def test_an_empty_identifier_is_left_out() -> None:
    """As in Home Assistant: firmware announces itself before it knows its hardware address."""
    fields = {"identifiers": ["", "relay-7"], "connections": [["mac", ""], ["mac", "a8:03:2a:be:54:dc"]]}
    assert read_device(fields, {}).identifiers == ("mac:a8032abe54dc", "id:relay-7")


def test_facts_that_are_equal_in_python_differ() -> None:
    """Devices of one model share their facts, and a version ``1`` is not one that is ``true``."""
    told = [read_device({"identifiers": "a", "hw_version": version}, {}).facts for version in (1, True, 1.0, "1")]

    assert told == [{"hw_version": "1"}, {"hw_version": "True"}, {"hw_version": "1.0"}, {"hw_version": "1"}]
    assert told[0] is told[3]


def test_facts_stand_in_the_order_of_their_device() -> None:
    """Another order is another device's, although the facts are equal."""
    one, other = ({"identifiers": "a", "model": "m", "sw_version": "1"}, {"sw_version": "1", "model": "m", "ids": 0})

    assert list(read_device(one, {"name": "b"}).facts) == ["model", "sw_version", "origin"]
    assert list(read_device({**other, "identifiers": "b"}, {"name": "b"}).facts) == ["sw_version", "model", "origin"]


def test_a_child_device_is_itself_and_not_its_parent() -> None:
    device = read_device(
        {
            "identifiers": "parent",
            "name": "Strip",
            "manufacturer": "Maker",
            "child_device": {"identifiers": "c1", "name": "One"},
        },
        {},
    )
    assert (device.identifiers, device.name) == (("id:c1",), "One")
    assert device.facts == {"manufacturer": "Maker", "via_device": "parent"}


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"name": "nameless"}, "neither"),
        ({"identifiers": []}, "neither"),
        ({"identifiers": [{}]}, "identifier"),
        ({"identifiers": [""]}, "identifier"),
        ({"identifiers": ["\x00"]}, "identifier"),
        ({"identifiers": [str(n) for n in range(10_000)]}, "64 is the limit"),
        ({"connections": [["mac"]]}, "a type and a value"),
        ({"connections": "mac"}, "a type and a value"),
    ],
)
def test_a_device_without_proper_identity_is_refused(fields: dict[str, object], problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        read_device(fields, {})


@pytest.mark.parametrize(
    ("address", "shown"),
    [
        ("http://admin:secret@192.168.1.9/setup", "http://192.168.1.9/setup"),
        ("http://192.168.1.9/@home", "http://192.168.1.9/@home"),
    ],
)
def test_the_password_in_the_address_of_a_device_is_not_shown(address: str, shown: str) -> None:
    assert read_device({"identifiers": "x", "configuration_url": address}, {}).facts == {"configuration_url": shown}


def availability(fields: Mapping[str, object]) -> Availability | None:
    return read_availability(DiscoveryConfig("light", "x", fields))


def test_without_topics_there_is_no_availability() -> None:
    assert availability({}) is None
    assert availability({"availability": []}) is None


def test_an_entry_of_the_availability_may_have_short_keys() -> None:
    found = availability({"availability": [{"t": "a/av", "pl_avail": "yes"}]})
    assert found is not None
    (source,) = found.sources
    assert (source.topic, source.read(b"yes"), source.read(b"online")) == ("a/av", True, None)


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
