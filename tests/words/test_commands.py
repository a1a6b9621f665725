"""The words of a command as settings of a part."""

import pytest

from homebot.devices import KeyValue
from homebot.devices.part import Capability, Part
from homebot.errors import RefusedError
from homebot.words.commands import parse_command_words


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
    assert parse_command_words(word, (), alarm, "Alarm") == {"alarm": state}


@pytest.mark.parametrize("word", ["unlock", "unlocked"])
def test_a_lock_takes_the_word_and_the_state(word: str) -> None:
    lock = Part(id="", service_type="door_lock", capabilities=(Capability(name="lock", settable=True),))
    assert parse_command_words(word, (), lock, "Door") == {"lock": "unlocked"}
    with pytest.raises(RefusedError):
        parse_command_words("jammed", (), lock, "Door")


def test_a_button_takes_its_name() -> None:
    start = Part(id="", name="Start", service_type="x_setting", capabilities=(Capability(name="push", settable=True),))
    assert parse_command_words("start", (), start, "Dishwasher Start") == {"push": True}
    with pytest.raises(RefusedError):
        parse_command_words("stop", (), start, "Dishwasher Start")


def test_a_share_of_one_in_place_of_a_percentage_is_asked_back() -> None:
    """With its unit it is meant; alone it has always been a share."""
    lamp = Part(id="", service_type="light", capabilities=(Capability(name="level", settable=True),))
    asked = r"0\.4 as level of Lamp was refused: it takes percent; did you mean 40 %\? To set 0\.4 %: level 0\.4 %"
    with pytest.raises(RefusedError, match=asked):
        parse_command_words("level 0.4", (), lamp, "Lamp")
    with pytest.raises(RefusedError, match=asked):
        parse_command_words("set", (KeyValue(key="level", value="0.4"),), lamp, "Lamp")
    assert parse_command_words("level 0.4 %", (), lamp, "Lamp") == {"level": 0.4}
    assert parse_command_words("level 1", (), lamp, "Lamp") == {"level": 1.0}
    assert parse_command_words("0.4", (), lamp, "Lamp") == {"level": 40.0}


@pytest.mark.parametrize(
    ("words", "setting"),
    [
        (("red",), {"color": (0.0, 100.0)}),
        (("Sky_Blue",), {"color": (197.0, 43.0)}),
        (("set", "color", "hot pink"), {"color": (330.0, 59.0)}),
        (("warm white",), {"color_temperature": 2700.0}),
        (("color white",), {"color_temperature": 4000.0}),
        (("set color to Warm_White",), {"color_temperature": 2700.0}),
        (("set", "color", "White"), {"color_temperature": 4000.0}),
        (("set", "color_temperature", "cold white"), {"color_temperature": 6500.0}),
        (("Color temperature 3000 K",), {"color_temperature": 3000.0}),
        (("set color temperature to 3000",), {"color_temperature": 3000.0}),
        (("set", "color", "temperature 3000"), {"color_temperature": 3000.0}),
    ],
)
def test_a_lamp_takes_colours_by_name(words: tuple[str, ...], setting: dict[str, object]) -> None:
    settable = [Capability(name=name, settable=True) for name in ("on_off", "color", "color_temperature")]
    lamp = Part(id="", service_type="light", capabilities=tuple(settable))
    word, *value = words
    given = (KeyValue(key=value[0], value=value[1]),) if value else ()
    assert parse_command_words(word, given, lamp, "Lamp") == setting
    for part in (Part(id="", service_type="light", capabilities=tuple(settable[:1])), lamp):
        with pytest.raises(RefusedError):
            parse_command_words("red" if part is not lamp else "rde", (), part, "Lamp")


@pytest.mark.parametrize("words", ["white", "color white"])
def test_a_lamp_of_colours_alone_shows_white(words: str) -> None:
    settable = [Capability(name=name, settable=True) for name in ("on_off", "color")]
    lamp = Part(id="", service_type="light", capabilities=tuple(settable))
    assert parse_command_words(words, (), lamp, "Lamp") == {"color": (0.0, 0.0)}


def test_a_choice_named_as_a_colour_is_the_choice() -> None:
    choice = Capability(name="option", settable=True, options=("red", "green"))
    part = Part(id="", service_type="x_setting", capabilities=(choice,))
    assert parse_command_words("option red", (), part, "Strip") == {"option": "red"}


def test_a_number_in_another_unit_may_be_below_one() -> None:
    setpoint = Capability(name="heating_setpoint", settable=True)
    freezer = Part(id="", service_type="thermostat", capabilities=(setpoint,))
    assert parse_command_words("heating_setpoint 0.5", (), freezer, "Freezer") == {"heating_setpoint": 0.5}


def test_a_minus_is_part_of_a_number_that_may_be_below_zero_and_a_change_of_any_other() -> None:
    setpoint = Capability(name="heating_setpoint", settable=True, bounds=(-30.0, 30.0))
    freezer = Part(id="", service_type="thermostat", capabilities=(setpoint,))
    room = Part(id="", service_type="thermostat", capabilities=(setpoint.model_copy(update={"bounds": (5.0, 30.0)}),))
    known = {"heating_setpoint": 20.0}
    assert parse_command_words("heating_setpoint -18", (), freezer, "Freezer", known) == {"heating_setpoint": -18.0}
    assert parse_command_words("-1 °C", (), room, "Room", known) == {"heating_setpoint": 19.0}
    assert parse_command_words("+0.5", (), room, "Room", known) == {"heating_setpoint": 20.5}
    assert parse_command_words("+50", (), room, "Room", known) == {"heating_setpoint": 30.0}
    plug = Part(id="", service_type="plug", capabilities=(Capability(name="on_off", settable=True),))
    with pytest.raises(RefusedError, match="this part takes on, off"):
        parse_command_words("+10 %", (), plug, "Plug", {"on_off": True})


def test_words_joined_by_commas_are_one_command() -> None:
    names = ("on_off", "level", "color", "color_temperature")
    lamp = Part(id="", service_type="light", capabilities=tuple(Capability(name=one, settable=True) for one in names))
    assert parse_command_words("on, 40 %", (), lamp, "Lamp") == {"level": 40.0}
    assert parse_command_words("20 %, 2700 K", (), lamp, "Lamp") == {"level": 20.0, "color_temperature": 2700.0}
    assert parse_command_words("on, color 240, 50", (), lamp, "Lamp") == {"color": (240.0, 50.0)}
    own = Capability(name="option", settable=True, options=("Cotton, 40 %", "Off"))
    washer = Part(id="", service_type="x_setting", capabilities=(own,))
    assert parse_command_words("Cotton, 40 %", (), washer, "Washer") == {"option": "Cotton, 40 %"}


def test_a_command_has_a_length() -> None:
    """However it is cut into words, a longer one is read for seconds."""
    lamp = Part(id="", service_type="light", capabilities=(Capability(name="on_off", settable=True),))
    for command, values in (("on and " * 1000, ()), ("on", (KeyValue(key="level", value="4" * 1001),))):
        with pytest.raises(RefusedError, match=r"a command to Lamp .*: it is longer than 1,000 characters"):
            parse_command_words(command, values, lamp, "Lamp")
