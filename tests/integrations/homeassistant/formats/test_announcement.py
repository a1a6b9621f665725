import json

import pytest

from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.abbreviations import ABBREVIATIONS
from homebot.integrations.homeassistant.formats.reader import (
    MAX_COMPONENTS,
    Announced,
    ConfigTopic,
    parse_config_topic,
    read_announcement,
)
from homebot.integrations.homeassistant.formats.topics import valid_topic
from homebot.mqtt.topics import validate_filter, validate_topic

LIGHT = ConfigTopic("light", "lamp", "light/lamp")
WHOLE = ConfigTopic("device", "0AFFD2", "device/0AFFD2")


def announced(fields: object, topic: ConfigTopic = LIGHT) -> Announced:
    found = read_announcement(topic, json.dumps(fields).encode())
    assert found is not None
    return found


def test_there_are_as_many_short_forms_as_home_assistant_ever_had() -> None:
    assert len(ABBREVIATIONS) == 272
    assert ABBREVIATIONS["cmd_t"] == "command_topic"
    assert ABBREVIATIONS["whit_scl"] == "white_scale"


def test_short_forms_are_spelled_out_where_they_may_be() -> None:
    (component,) = announced({"cmd_t": "a/set", "dev": {"ids": "x", "cmd_t": "no topic here"}}).components
    assert component.values == {"command_topic": "a/set", "device": {"ids": "x", "cmd_t": "no topic here"}}


def test_where_both_forms_are_there_the_short_one_wins() -> None:
    (component,) = announced({"command_topic": "long", "cmd_t": "short"}).components
    assert component.values == {"command_topic": "short"}


def test_a_base_topic_stands_in_at_the_beginning_or_the_end_of_topics_alone() -> None:
    (component,) = announced(
        {
            "~": "home/lamp",
            "cmd_t": "~/set",
            "stat_t": "state/~",
            "bri_cmd_t": "a/~/b",
            "rgb_cmd_t": "~",
            "val_tpl": "~{{ value }}~",
            "json_attributes_topic": 3,
            "availability": {"t": "~/av"},
        }
    ).components
    assert component.values == {
        "command_topic": "home/lamp/set",
        "state_topic": "state/home/lamp",
        "brightness_command_topic": "a/~/b",
        "rgb_command_topic": "home/lamp",
        "value_template": "~{{ value }}~",
        "json_attributes_topic": 3,
        "availability": {"topic": "home/lamp/av"},
    }


def test_the_components_of_a_whole_device_inherit_shared_fields() -> None:
    told = announced(
        {
            "dev": {"ids": "0AFFD2"},
            "o": {"name": "bridge"},
            "stat_t": "kitchen/state",
            "qos": 1,
            "icon": "mdi:lamp",
            "~": "not for components",
            "cmps": {
                "one": {"p": "light", "uniq_id": "a", "cmd_t": "~/x"},
                "two": {"platform": "sensor", "uniq_id": "b", "stat_t": "~/own", "~": "base"},
                "gone": {"p": "switch"},
            },
        },
        WHOLE,
    )
    one, two = told.components
    assert (one.component, one.discovery_id) == ("light", "device/0AFFD2/one")
    assert one.values == {"unique_id": "a", "command_topic": "~/x", "state_topic": "kitchen/state", "qos": 1}
    assert (two.component, two.values["state_topic"]) == ("sensor", "base/own")


def test_a_node_id_is_part_of_the_discovery_id() -> None:
    told = announced(
        {"cmps": {"c": {"p": "light", "uniq_id": "a"}}}, ConfigTopic("device", "object", "device/node/object")
    )
    assert told.components[0].discovery_id == "device/node/object/c"


def test_child_devices_lend_their_components_and_their_names() -> None:
    components = {"x": {"p": "switch", "uniq_id": "a"}, "y": {"p": "button", "uniq_id": "b", "name": "Toggle"}}
    told = announced({"dev": {"ids": "p"}, "cdevs": [{"identifiers": "c", "name": "Gate", "cmps": components}]}, WHOLE)
    found = [(one.discovery_id, one.values["name"]) for one in told.components]
    assert found == [("device/0AFFD2/x", "Gate"), ("device/0AFFD2/y", "Gate Toggle")]


@pytest.mark.parametrize("key", ["migrate_discovery", "migr_discvry"])
def test_a_move_to_another_form_announces_nothing(key: str) -> None:
    assert read_announcement(LIGHT, json.dumps({key: True}).encode()) is None


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ([], "not a JSON object"),
        ({"~": ["x"]}, "~ is list of 1"),
    ],
)
def test_an_invalid_config_is_refused(fields: object, problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        announced(fields)


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"dev": {"ids": "x"}}, "no components"),
        ({"cmps": []}, "components is list of 0"),
        ({"cmps": {"a": "light"}}, "component 'a'"),
        ({"cmps": {"a": {"uniq_id": "x"}}}, "platform is None"),
        ({"cmps": {f"c{n}": {"p": "light"} for n in range(MAX_COMPONENTS + 1)}}, "more than 300"),
    ],
)
def test_an_invalid_whole_device_is_refused(fields: object, problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        announced(fields, WHOLE)


@pytest.mark.parametrize(
    ("topic", "expected"),
    [
        ("ha/light/a/config", ConfigTopic("light", "a", "light/a")),
        ("ha/light//a/config", ConfigTopic("light", "a", "light/a")),
        ("ha/light/n/a/config", ConfigTopic("light", "a", "light/n/a")),
        ("ha/device/0AFFD2/config", ConfigTopic("device", "0AFFD2", "device/0AFFD2")),
        (
            "ha/device_automation/0x1/action_recall_*/config",
            ConfigTopic("device_automation", "action_recall_*", "device_automation/0x1/action_recall_*"),
        ),
    ],
)
def test_a_config_topic_names_its_announcement(topic: str, expected: ConfigTopic) -> None:
    assert parse_config_topic("ha", topic) == expected


@pytest.mark.parametrize(
    "topic",
    ["ha/status", "ha/light/config", "ha/light/a/state", "other/light/a/config", "ha/a/b/c/d/config", "haa/l/a/config"],
)
def test_another_topic_is_no_config(topic: str) -> None:
    assert parse_config_topic("ha", topic) is None


def test_a_config_topic_that_would_fill_an_index_is_refused() -> None:
    with pytest.raises(WireError, match="512"):
        parse_config_topic("ha", f"ha/light/{'x' * 512}/config")


@pytest.mark.parametrize("topic", ["", "a/+/b#", "#/a", "a\x00", "a\n", "a\x7f", "a\ufdd0", "\ud800", "a" * 65_536])
def test_a_topic_that_cannot_be_is_refused(topic: str) -> None:
    for validate in (validate_topic, validate_filter):
        with pytest.raises(WireError):
            valid_topic("switch: command_topic", topic, validate)
    with pytest.raises(WireError):
        valid_topic("switch: command_topic", "a/+", validate_topic)
