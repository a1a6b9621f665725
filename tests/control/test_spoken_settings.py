"""The words of a command as settings of a part."""

import pytest

from homebot.control.spoken_settings import spoken_settings
from homebot.devices.part import Capability, Part
from homebot.errors import RefusedError


@pytest.mark.parametrize(
    ("word", "state"),
    [
        *(("disarm", "disarmed"), ("arm", "armed_away"), ("Arm home", "armed_home")),
        *(("arm_night", "armed_night"), ("Armed away", "armed_away")),
    ],
)
def test_an_alarm_takes_what_people_say(word: str, state: str) -> None:
    options = ("disarmed", "armed_home", "armed_away", "armed_night")
    alarm = Part(
        id="", service_type="x_alarm_panel", capabilities=(Capability(name="alarm", settable=True, options=options),)
    )
    assert spoken_settings(word, (), alarm, "Alarm") == {"alarm": state}


@pytest.mark.parametrize("word", ["unlock", "unlocked"])
def test_a_lock_takes_the_word_and_the_state(word: str) -> None:
    lock = Part(id="", service_type="door_lock", capabilities=(Capability(name="lock", settable=True),))
    assert spoken_settings(word, (), lock, "Door") == {"lock": "unlocked"}
    with pytest.raises(RefusedError):
        spoken_settings("jammed", (), lock, "Door")


def test_a_button_takes_its_name() -> None:
    start = Part(id="", name="Start", service_type="x_setting", capabilities=(Capability(name="push", settable=True),))
    assert spoken_settings("start", (), start, "Dishwasher Start") == {"push": True}
    with pytest.raises(RefusedError):
        spoken_settings("stop", (), start, "Dishwasher Start")
