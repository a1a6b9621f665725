import json
from typing import Literal

import pytest
from pydantic import ValidationError
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import simple_house

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn, Publication
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homeassistant.formats.components import BUILDERS, COMPONENTS
from homebot.integrations.homeassistant.formats.reader import DEVICE

LAMP = {
    "unique_id": "0x1_light",
    "name": None,
    "schema": "json",
    "brightness": True,
    "brightness_scale": 254,
    "command_topic": "zigbee2mqtt/lamp/set",
    "state_topic": "zigbee2mqtt/lamp",
    "availability": [{"topic": "zigbee2mqtt/bridge/state", "value_template": "{{ value_json.state }}"}],
    "device": {
        "identifiers": ["zigbee2mqtt_0x00158d0001abcdef"],
        "name": "Kitchen lamp",
        "suggested_area": "Kitchen",
        "model": "LED1545G12",
    },
    "origin": {"name": "Zigbee2MQTT", "sw": "2.14.1"},
}
SWITCH = {"unique_id": "s", "name": "Relay", "command_topic": "relay/set"}
WHOLE = {
    "dev": {"ids": "0AFFD2", "name": "Kitchen"},
    "o": {"name": "bridge"},
    "avty_t": "kitchen/status",
    "cmps": {
        "lamp": {"p": "light", "uniq_id": "a", "cmd_t": "k/lamp/set"},
        "relay": {"p": "switch", "uniq_id": "b", "cmd_t": "k/relay/set"},
    },
}


@pytest.fixture
def convention() -> HomeAssistantDiscovery:
    return HomeAssistantDiscovery(HomeAssistantSettings())


def take(convention: HomeAssistantDiscovery, topic: str, fields: object) -> AnnouncementEvent:
    payload = fields.encode() if isinstance(fields, str) else json.dumps(fields).encode()
    (heard,) = convention.read_message(f"homeassistant/{topic}/config", payload, retained=True)
    return heard


def test_a_config_describes_a_device(convention: HomeAssistantDiscovery) -> None:
    device = take(convention, "light/0x1/light", LAMP)
    assert isinstance(device, DeviceAnnounced)
    assert (device.key, device.convention, device.topic) == (
        "light/0x1/light",
        "homeassistant",
        "homeassistant/light/0x1/light/config",
    )
    assert device.identifiers[0] == "eui64:00158d0001abcdef"
    assert (device.name, device.area, device.implies_alive) == ("Kitchen lamp", "Kitchen", False)
    assert device.facts == {"model": "LED1545G12", "origin": "Zigbee2MQTT", "origin_sw_version": "2.14.1"}
    assert device.availability is not None
    (part,) = device.parts
    assert (part.part.id, part.part.name, part.part.service_type, part.part.advertised) == (
        "0x1_light",
        "",
        "light",
        "light",
    )
    assert [one.name for one in part.part.capabilities] == ["on_off", "level"]
    assert (part.part.reads, part.part.writes) == (("zigbee2mqtt/lamp",), ("zigbee2mqtt/lamp/set",))
    assert part.codec.topics() == part.part.reads


def test_without_a_device_the_part_names_it(convention: HomeAssistantDiscovery) -> None:
    device = take(convention, "switch/relay1", SWITCH)
    assert isinstance(device, DeviceAnnounced)
    assert (device.name, device.identifiers, device.availability) == ("Relay", (), None)


def test_another_config_may_name_a_device_with_identifiers(convention: HomeAssistantDiscovery) -> None:
    """As the example of Home Assistant's documentation, whose second config has the identifiers alone."""
    device = take(convention, "switch/relay1", {**SWITCH, "device": {"identifiers": ["bedroom01ae"]}})
    assert isinstance(device, DeviceAnnounced)
    assert device.name == ""


def test_a_whole_device_is_one_description(convention: HomeAssistantDiscovery) -> None:
    device = take(convention, "device/0AFFD2", WHOLE)
    assert isinstance(device, DeviceAnnounced)
    assert (device.key, device.name) == ("device/0AFFD2", "Kitchen")
    assert [(one.part.id, one.part.service_type) for one in device.parts] == [("a", "light"), ("b", "switch")]
    assert device.availability is not None
    assert device.availability.sources[0].topic == "kitchen/status"


def test_a_device_without_components_left_is_withdrawn(convention: HomeAssistantDiscovery) -> None:
    gone = take(convention, "device/0AFFD2", {**WHOLE, "cmps": {"lamp": {"p": "light"}}})
    assert gone == DeviceWithdrawn("device/0AFFD2", "it has no components left")


def test_in_a_whole_device_a_broken_component_costs_itself_alone(convention: HomeAssistantDiscovery) -> None:
    cmps = {
        "bad": {"p": "light", "uniq_id": "x", "cmd_t": "a/#"},
        "good": {"p": "switch", "uniq_id": "b", "cmd_t": "s"},
    }
    payload = json.dumps({**WHOLE, "cmps": cmps}).encode()
    device, problem = convention.read_message("homeassistant/device/0AFFD2/config", payload, retained=True)
    assert isinstance(device, DeviceAnnounced)
    assert [one.part.id for one in device.parts] == ["b"]
    assert str(problem) == "device/0AFFD2/bad: light: command_topic 'a/#' has a wildcard, which only filters may have"
    assert convention.rejected == 1


@pytest.mark.parametrize(
    ("bad", "problem"),
    [
        ("light", "component 'bad': it is 'light', not an object"),
        ({"cmd_t": "b"}, "component 'bad': platform is None, not a text"),
        ({"p": ["light"], "cmd_t": "b"}, "component 'bad': platform is list of 1, not a text"),
        ({"p": "light", "~": 7, "cmd_t": "b"}, "component 'bad': ~ is 7, not a topic"),
        ({"p": "light", "cmd_t": []}, "device/0AFFD2/bad: light: command_topic is list of 0, not a text"),
        ({"p": "light", "cmd_t": "b", "qos": 7}, "component 'bad': light: qos is 7"),
    ],
)
def test_any_mistake_in_a_component_costs_it_alone(
    convention: HomeAssistantDiscovery, bad: object, problem: str
) -> None:
    cmps = {"bad": bad, "good": {"p": "switch", "uniq_id": "b", "cmd_t": "s"}}
    payload = json.dumps({**WHOLE, "cmps": cmps}).encode()
    device, left_out = convention.read_message("homeassistant/device/0AFFD2/config", payload, retained=True)
    assert isinstance(device, DeviceAnnounced)
    assert [one.part.id for one in device.parts] == ["b"]
    assert str(left_out).startswith(problem)
    assert convention.rejected == 1


@pytest.mark.virtual_time
async def test_a_component_that_is_left_out_is_counted_and_the_log_says_which_and_why() -> None:
    with capture_logs() as lines:
        async with simple_house(conventions=("homeassistant",)) as house:
            cmps = {"bad": {"p": "light", "uniq_id": "x"}, "good": {"p": "switch", "uniq_id": "b", "cmd_t": "s"}}
            await house.say("homeassistant/device/0AFFD2/config", json.dumps({**WHOLE, "cmps": cmps}))
            assert [one.key for one in house.sighted()] == ["homeassistant:device/0AFFD2"]
            assert house.gateway.counters.announcements_rejected == 1
    (line,) = [line for line in lines if line["event"] == "gateway.announcement_rejected"]
    assert "device/0AFFD2/bad: light: command_topic is None" in line["message"]


def test_a_whole_device_of_broken_components_is_refused_once(convention: HomeAssistantDiscovery) -> None:
    cmps = {"bad": {"p": "light", "uniq_id": "x"}, "worse": {"p": "light", "uniq_id": "y"}}
    with pytest.raises(WireError, match="command_topic"):
        take(convention, "device/0AFFD2", {**WHOLE, "cmps": cmps})
    assert convention.rejected == 2


def test_two_components_with_one_unique_id_are_two_parts(convention: HomeAssistantDiscovery) -> None:
    cmps = {one: {"p": "switch", "uniq_id": "same", "cmd_t": one} for one in ("left", "right")}
    device = take(convention, "device/0AFFD2", {**WHOLE, "cmps": cmps})
    assert isinstance(device, DeviceAnnounced)
    assert [one.part.id for one in device.parts] == ["same", "device/0AFFD2/right"]


def test_an_empty_config_withdraws(convention: HomeAssistantDiscovery) -> None:
    assert take(convention, "light/0x1/light", "") == DeviceWithdrawn("light/0x1/light", "its config was removed")


@pytest.mark.parametrize("topic", ["light/0x1/light", "device/0AFFD2"])
def test_a_move_to_another_form_withdraws_for_a_moment(convention: HomeAssistantDiscovery, topic: str) -> None:
    moved = take(convention, topic, {"migrate_discovery": True})
    assert isinstance(moved, DeviceWithdrawn)
    assert not moved.is_final


@pytest.mark.parametrize("topic", ["homeassistant/media_player/x/config", "homeassistant/status", "ha/light/x/config"])
def test_an_unknown_topic_is_ignored(convention: HomeAssistantDiscovery, topic: str) -> None:
    assert convention.read_message(topic, b"online", retained=False) == ()
    assert convention.rejected == 0


def test_unknown_components_and_keys_in_a_whole_device_are_ignored(convention: HomeAssistantDiscovery) -> None:
    cmps = {
        "x": {"p": "teleporter", "uniq_id": "t"},
        "relay": {"p": "switch", "uniq_id": "b", "cmd_t": "r", "cmd_t ": 3},
    }
    device = take(convention, "device/0AFFD2", {**WHOLE, "cmps": cmps})
    assert isinstance(device, DeviceAnnounced)
    assert len(device.parts) == 1
    assert convention.rejected == 0


def test_a_refused_config_is_counted(convention: HomeAssistantDiscovery) -> None:
    for broken in ("{", "[]", '{"command_topic": ""}'):
        with pytest.raises(WireError):
            take(convention, "switch/x", broken)
    assert convention.rejected == 3


@pytest.mark.parametrize("shown", [False, "false"])  # the text is of tesla_ble_mqtt_docker
def test_a_hidden_part_is_a_fact_and_a_group_has_members(convention: HomeAssistantDiscovery, shown: object) -> None:
    device = take(convention, "switch/x", {**SWITCH, "enabled_by_default": shown, "group": ["0x1_light", "0x2_light"]})
    assert isinstance(device, DeviceAnnounced)
    assert device.facts == {"hidden s": "by default"}
    assert device.parts[0].part.members == ("#0x1_light", "#0x2_light")


def test_there_are_two_filters_per_component_and_prefix() -> None:
    settings = HomeAssistantSettings(prefixes=("homeassistant", "ha/two"))
    filters = HomeAssistantDiscovery(settings).filters()
    assert len(filters) == len(set(filters)) == 4 * (len(BUILDERS) + 1)
    assert set(COMPONENTS) == {*BUILDERS, DEVICE}
    assert {"homeassistant/light/+/config", "ha/two/device/+/+/config"} <= set(filters)


def test_the_lock_that_has_the_name_of_its_device_is_read_before_the_rest_of_it() -> None:
    """The id of a device is made of its name when it is found; other configs of Nuki Hub have only its identifiers."""
    lock, *others = map(COMPONENTS.index, ("lock", "binary_sensor", "button", "number", "select", "sensor"))
    assert lock < min(others)


def test_every_prefix_is_understood() -> None:
    convention = HomeAssistantDiscovery(HomeAssistantSettings(prefixes=("a", "b/c")))
    for topic in ("a/switch/x/config", "b/c/switch/x/config"):
        assert len(convention.read_message(topic, json.dumps(SWITCH).encode(), retained=True)) == 1


@pytest.mark.parametrize(
    ("unit", "announced", "bounds"),
    [
        ("F", {}, (pytest.approx(2.2, abs=0.1), pytest.approx(40, abs=0.1))),
        ("F", {"temp_unit": "C"}, (36, 104)),
        ("F", {"temp_unit": None}, (pytest.approx(2.2, abs=0.1), pytest.approx(40, abs=0.1))),
        ("C", {}, (36, 104)),
    ],
)
def test_a_thermostat_that_announces_no_unit_counts_in_that_of_the_house(
    unit: Literal["C", "F"], announced: dict[str, object], bounds: tuple[float, float]
) -> None:
    """AqualinkD counts in °F, as the Home Assistant of most of its users does: ``source/hassio.c``."""
    convention = HomeAssistantDiscovery(HomeAssistantSettings(temperature_unit=unit))
    heater = {"uniq_id": "a", "modes": ["off", "heat"], "temp_cmd_t": "a/set", "min_temp": 36, "max_temp": 104}
    device = take(convention, "climate/aqualinkd/heater", {**heater, **announced})
    assert isinstance(device, DeviceAnnounced)
    (setpoint,) = [one for one in device.parts[0].part.capabilities if one.name == "heating_setpoint"]
    assert setpoint.bounds == bounds


def test_only_where_wanted_devices_are_asked_to_announce_themselves() -> None:
    assert HomeAssistantDiscovery(HomeAssistantSettings()).birth_messages() == ()
    settings = HomeAssistantSettings(prefixes=("homeassistant", "ha"), announce_please=True)
    assert HomeAssistantDiscovery(settings).birth_messages() == (
        Publication("homeassistant/status", b"online"),
        Publication("ha/status", b"online"),
    )


@pytest.mark.parametrize("prefix", ["", "a/+", "#", "a/", "x" * 201])
def test_a_prefix_that_cannot_be_is_refused(prefix: str) -> None:
    with pytest.raises(ValidationError):
        HomeAssistantSettings(prefixes=(prefix,))


def test_a_part_without_unique_id_is_named_by_its_announcement(convention: HomeAssistantDiscovery) -> None:
    device = take(convention, "switch/node/relay", {"command_topic": "r"})
    assert isinstance(device, DeviceAnnounced)
    assert device.parts[0].part.id == device.key == "switch/node/relay"
