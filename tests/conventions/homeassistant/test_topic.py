import pytest

from homebot.conventions.homeassistant.topics import ConfigTopic, parse_config_topic, valid_topic
from homebot.errors import WireError
from homebot.mqtt.topics import validate_filter, validate_topic


@pytest.mark.parametrize(
    ("topic", "expected", "key"),
    [
        ("ha/light/a/config", ConfigTopic("light", "", "a"), "light/a"),
        ("ha/light/n/a/config", ConfigTopic("light", "n", "a"), "light/n/a"),
        ("ha/device/0AFFD2/config", ConfigTopic("device", "", "0AFFD2"), "device/0AFFD2"),
        (
            "ha/device_automation/0x1/action_recall_*/config",
            ConfigTopic("device_automation", "0x1", "action_recall_*"),
            "device_automation/0x1/action_recall_*",
        ),
    ],
)
def test_a_config_topic_names_its_announcement(topic: str, expected: ConfigTopic, key: str) -> None:
    assert parse_config_topic("ha", topic) == expected
    assert expected.key == key


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
            valid_topic(topic, validate)
    with pytest.raises(WireError):
        valid_topic("a/+", validate_topic)
