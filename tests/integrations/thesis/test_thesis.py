"""The thesis layout: HOME/SERVICE_TYPE/DEVICE_ID/CHANNEL."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.description import TextEndpoint
from homebot.errors import WireError
from homebot.integrations.thesis.formats import Thesis, ThesisSettings
from homebot.mqtt.topics import topic_matches, validate_filter

LEVEL = st.text(st.characters(exclude_characters="/+#\0", exclude_categories=["Cs"]), min_size=1, max_size=20)


@pytest.fixture
def layout() -> Thesis:
    return Thesis(ThesisSettings(root="home425"))


def test_a_lamp_speaks_on_out_and_listens_on_in(layout: Thesis) -> None:
    """The thesis's own example."""
    lamp = layout.announced("home425/lights/roomlights405/out")

    assert lamp is not None
    assert (lamp.key, lamp.name) == ("lights/roomlights405", "roomlights405")
    assert lamp.text == TextEndpoint("lights", "home425/lights/roomlights405/out", "home425/lights/roomlights405/in")


@pytest.mark.parametrize("channel", ["in", "status", "OUT"])
def test_other_channels_are_no_devices(layout: Thesis, channel: str) -> None:
    """Above all a command on ``in`` must not make a device."""
    assert layout.announced(f"home425/lights/lamp/{channel}") is None


def test_another_home_is_ignored(layout: Thesis) -> None:
    """Nor is one with only the beginning of the name."""
    assert layout.announced("home426/lights/lamp/out") is None
    assert layout.announced("home4257/lights/lamp/out") is None


@pytest.mark.parametrize(
    ("topic", "problem"),
    [
        ("home425", "0 levels"),
        ("home425/lights", "1 levels"),
        ("home425/lights/lamp", "2 levels"),
        ("home425/lights/lamp/out/more", "4 levels"),
        ("home425//lamp/out", "empty level where SERVICE_TYPE"),
        ("home425/lights//out", "empty level where DEVICE_ID"),
        ("home425/lights/lamp/", "empty level where CHANNEL"),
    ],
)
def test_a_topic_that_breaks_the_layout_is_named_with_the_reason(layout: Thesis, topic: str, problem: str) -> None:
    """The message has the topic and its problem."""
    with pytest.raises(WireError, match=problem) as caught:
        layout.announced(topic)
    assert repr(topic) in str(caught.value)


@pytest.mark.parametrize("device_id", ["Küche 1", "0x00158d", "日本", "a-b.c"])
def test_odd_device_ids_are_devices_all_the_same(layout: Thesis, device_id: str) -> None:
    """A name may have any character that MQTT allows in a level."""
    device = layout.announced(f"home425/lights/{device_id}/out")
    assert device is not None
    assert device.name == device_id


def test_without_a_root_every_home_is_read_and_part_of_the_key() -> None:
    """Two homes on one broker may have lamps of the same name."""
    device = Thesis(ThesisSettings()).announced("villa/lights/lamp/out")
    assert device is not None
    assert device.text is not None
    assert (device.key, device.text.command_address) == ("villa/lights/lamp", "villa/lights/lamp/in")


@pytest.mark.parametrize(
    ("home", "topic", "is_device"),
    [
        ("villa", "villa/lights/lamp/out", True),
        ("villa", "esphome/other/thing/out", False),
        ("Villa Rosa", "Villa Rosa/lights/lamp/out", True),
        ("a/b", "a/b/lights/out", False),
        ("+", "villa/lights/lamp/out", False),
    ],
)
def test_without_a_root_a_foreign_topic_makes_no_device(home: str, topic: str, *, is_device: bool) -> None:
    layout = Thesis(ThesisSettings(home=home))
    assert any(topic_matches(one, topic) for one in layout.filters()) is is_device
    assert not is_device or layout.announced(topic) is not None


@pytest.mark.parametrize("root", ["home425", "", "building/7"])
@given(service_type=LEVEL, device_id=LEVEL)
def test_our_own_commands_match_no_filter_and_every_device_does(root: str, service_type: str, device_id: str) -> None:
    """So a command cannot come back as if a device had spoken, on any MQTT version."""
    layout = Thesis(ThesisSettings(root=root))
    filters = layout.filters()
    for one in filters:
        validate_filter(one)
    device = layout.announced(f"{root or 'home'}/{service_type}/{device_id}/out")

    assert device is not None
    assert device.text is not None
    if not device.text.address.startswith("$"):
        assert sum(topic_matches(one, device.text.address) for one in filters) == 1
    assert not any(topic_matches(one, device.text.command_address) for one in filters)
