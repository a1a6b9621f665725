"""What a device's words and its state look like on MQTT."""

import pytest

from homebot.errors import UsageError
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat
from homebot.house.dialect import DeviceState, OutgoingMessage, SimulatedDeviceInfo, state_of
from homebot.house.family import dialects
from homebot.house.kinds import KINDS
from homebot.house.sensors import LuxSensor
from homebot.house.simulated_device import SimulatedDevice

LAMP = SimulatedDeviceInfo("villa", "lamp", "desk", "lights", "study")


def test_the_thesis_says_words_as_they_are_and_announces_nothing() -> None:
    """On the device's own topics."""
    thesis = dialects()["thesis"]
    assert thesis.filters(LAMP) == ("villa/lights/desk/in",)
    assert thesis.state_messages(LAMP, DeviceState(text="21.5")) == (
        OutgoingMessage("villa/lights/desk/out", b"21.5", retain=False, qos=1),
    )
    assert thesis.state_messages(LAMP, DeviceState(text="\ud800")) == (OutgoingMessage("villa/lights/desk/out", b"?"),)
    assert (thesis.birth(LAMP), thesis.will(LAMP)) == ((), None)
    assert thesis.kinds == KINDS.keys()


def test_the_thesis_takes_any_payload_for_a_word() -> None:
    """What it means is for the device."""
    told = dialects()["thesis"].parse_command
    assert told(LAMP, "villa/lights/desk/in", b"on") == ("on",)
    assert told(LAMP, "villa/lights/desk/in", b"\xff") == ("�",)


@pytest.mark.parametrize("name", ["", "a/b", "+", "#", "a\0"])
def test_a_name_that_is_no_level_of_a_topic_is_refused(name: str) -> None:
    """It would speak for others, or hear them."""
    with pytest.raises(UsageError, match="cannot be a level of a topic"):
        SimulatedDeviceInfo("villa", "lamp", name, "lights", "study")
    with pytest.raises(UsageError, match="cannot be a level of a topic"):
        SimulatedDeviceInfo("villa", "lamp", "desk", name, "study")


@pytest.mark.parametrize(
    ("device", "word", "condition"),
    [
        (SimulatedLamp("a", is_on=True, brightness=0.5), "on", DeviceState(text="on", is_on=True, brightness=0.5)),
        (SimulatedLamp("a", is_on=True), "off", DeviceState(text="off", is_on=False)),
        (SimulatedLamp("a"), "0.25", DeviceState(text="0.25", is_on=True, brightness=0.25)),
        (SimulatedLamp("a", brightness=0.5), "0", DeviceState(text="0", is_on=False, brightness=0.5)),
        (SimulatedLamp("a"), "4000 K", DeviceState(text="4000 K", kelvin=4000.0)),
        (SimulatedLamp("a", is_on=True), "mumble", DeviceState(text="mumble", is_on=True)),
        (CoverMotor("a"), "closed", DeviceState(text="closed", position=0.0)),
        (CoverMotor("a"), "closing", DeviceState(text="closing", position=1.0, way=-1)),
        (CoverMotor("a"), "0.4", DeviceState(text="0.4", position=0.4)),
        (LuxSensor("a"), "12.5", DeviceState(text="12.5", value=12.5)),
        (SimulatedDoorLock("a"), "jammed", DeviceState(text="jammed")),
        (SimulatedThermostat("a", celsius=19.5, target=21.0), "21", DeviceState(text="21", celsius=19.5, target=21.0)),
    ],
)
def test_the_last_word_counts_and_the_rest_is_the_device_s_own(
    device: SimulatedDevice, word: str, condition: DeviceState
) -> None:
    """Even where the word is a lie, a message that tells the whole state holds it."""
    assert state_of(device, word) == condition
