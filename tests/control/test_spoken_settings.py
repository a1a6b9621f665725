"""The words of a command as settings of a part."""

import pytest

from homebot.control.spoken_settings import spoken_settings
from homebot.devices.part import Capability, Part


@pytest.mark.parametrize(
    ("word", "state"),
    [("disarm", "disarmed"), ("arm", "armed_away"), ("Arm home", "armed_home"), ("arm_night", "armed_night")],
)
def test_an_alarm_takes_what_people_say(word: str, state: str) -> None:
    options = ("disarmed", "armed_home", "armed_away", "armed_night")
    alarm = Part(
        id="", service_type="x_alarm_panel", capabilities=(Capability(name="alarm", settable=True, options=options),)
    )
    assert spoken_settings(word, (), alarm, "Alarm") == {"alarm": state}
