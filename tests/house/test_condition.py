"""What a device's last word and its state make together."""

from __future__ import annotations

import pytest

from homebot.house.condition import Condition, condition_of
from homebot.house.devices import CoverMotor, DoorLock, Lamp, LuxSensor, Machine, Thermostat


@pytest.mark.parametrize(
    ("device", "word", "condition"),
    [
        (Lamp("a", is_on=True, brightness=0.5), "on", Condition(word="on", is_on=True, brightness=0.5)),
        (Lamp("a", is_on=True), "off", Condition(word="off", is_on=False)),
        (Lamp("a"), "0.25", Condition(word="0.25", is_on=True, brightness=0.25)),
        (Lamp("a", brightness=0.5), "0", Condition(word="0", is_on=False, brightness=0.5)),
        (Lamp("a"), "4000 K", Condition(word="4000 K", kelvin=4000.0)),
        (Lamp("a", is_on=True), "mumble", Condition(word="mumble", is_on=True)),
        (CoverMotor("a"), "closed", Condition(word="closed", position=0.0)),
        (CoverMotor("a"), "closing", Condition(word="closing", position=1.0, way=-1)),
        (CoverMotor("a"), "0.4", Condition(word="0.4", position=0.4)),
        (LuxSensor("a"), "12.5", Condition(word="12.5", value=12.5)),
        (DoorLock("a"), "jammed", Condition(word="jammed")),
        (Thermostat("a", celsius=19.5, target=21.0), "21", Condition(word="21", celsius=19.5, target=21.0)),
    ],
)
def test_the_last_word_counts_and_the_rest_is_the_device_s_own(
    device: Machine, word: str, condition: Condition
) -> None:
    """Even where the word is a lie, a message that tells the whole state holds it."""
    assert condition_of(device, word) == condition
