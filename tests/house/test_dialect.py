"""What a device's words and its state look like on MQTT."""

import pytest

from homebot.errors import UsageError
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo, state_of
from homebot.house.sensors import LuxSensor
from homebot.house.simulated_device import SimulatedDevice


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
