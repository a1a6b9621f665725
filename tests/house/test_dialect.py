"""What a device's words look like on MQTT."""

from __future__ import annotations

import pytest

from homebot.errors import UsageError
from homebot.house.dialect import DeviceState, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.dialects import DIALECTS
from homebot.house.kinds import KINDS

LAMP = SimulatedDeviceInfo("villa", "lamp", "desk", "lights", "study")


def test_the_thesis_says_words_as_they_are_and_announces_nothing() -> None:
    """On the device's own topics."""
    thesis = DIALECTS["thesis"]
    assert thesis.filters(LAMP) == ("villa/lights/desk/in",)
    assert thesis.state_messages(LAMP, DeviceState(text="21.5")) == (
        OutgoingMessage("villa/lights/desk/out", b"21.5", retain=False, qos=1),
    )
    assert thesis.state_messages(LAMP, DeviceState(text="\ud800")) == (OutgoingMessage("villa/lights/desk/out", b"?"),)
    assert (thesis.birth(LAMP), thesis.will(LAMP)) == ((), None)
    assert thesis.kinds == KINDS.keys()


def test_the_thesis_takes_any_payload_for_a_word() -> None:
    """What it means is for the device."""
    told = DIALECTS["thesis"].parse_command
    assert told(LAMP, "villa/lights/desk/in", b"on") == ("on",)
    assert told(LAMP, "villa/lights/desk/in", b"\xff") == ("�",)


@pytest.mark.parametrize("name", ["", "a/b", "+", "#", "a\0"])
def test_a_name_that_is_no_level_of_a_topic_is_refused(name: str) -> None:
    """It would speak for others, or hear them."""
    with pytest.raises(UsageError, match="cannot be a level of a topic"):
        SimulatedDeviceInfo("villa", "lamp", name, "lights", "study")
    with pytest.raises(UsageError, match="cannot be a level of a topic"):
        SimulatedDeviceInfo("villa", "lamp", "desk", name, "study")
