"""What starts a routine, as text."""

import pytest

from homebot.devices.device import DevicePart
from homebot.devices.part import Part
from homebot.devices.query.terms import NameIs, StateIs, leaves
from homebot.errors import UsageError
from homebot.words.times import DaysAndTime, SunMoment
from homebot.words.triggers import Becomes, PersonMoves, Press, RobotArrival, read_press, read_trigger


def test_a_state_may_have_to_last() -> None:
    found = read_trigger("front door  open for 5m")
    assert isinstance(found, Becomes)
    assert found.lasting == 300.0
    assert "contact" in found.capabilities


@pytest.mark.parametrize("text", ["hall motion occupied", "hall motion clear", "lamp on", "front door locked"])
def test_a_state_is_written_as_in_a_search(text: str) -> None:
    assert isinstance(read_trigger(text), Becomes)


@pytest.mark.parametrize(
    ("text", "capability"),
    [
        ("cellar smoke detected for 10s", "smoke"),
        ("smoke detected in cellar", "smoke"),
        ("carbon monoxide detected", "carbon_monoxide_alarm"),
        ("water detected in cellar", "water_leak"),
        ("shed tampering detected", "tamper"),
        ("cellar smoke clear", "smoke"),
    ],
)
def test_what_a_sensor_detects_is_written_as_people_say_it(text: str, capability: str) -> None:
    found = read_trigger(text)
    assert isinstance(found, Becomes)
    assert {one.capability: one.value for one in leaves(found.query) if isinstance(one, StateIs)} == {
        capability: "clear" not in text
    }


def test_the_room_of_a_measurement_may_come_before_its_limit() -> None:
    found = read_trigger("temperature in nursery below 18 °C")
    assert isinstance(found, Becomes)
    last = read_trigger("temperature below 18 °C in nursery")
    assert isinstance(last, Becomes)
    assert found.query == last.query
    under = read_trigger("temperature in nursery under 18")
    assert isinstance(under, Becomes)
    assert under.query == last.query


def test_a_press_may_be_a_certain_one() -> None:
    found = read_trigger("hall button pressed double")
    assert isinstance(found, Press)
    assert found.value == "double"
    every = read_trigger("hall button press")
    assert isinstance(every, Press)
    assert not every.value


def test_a_press_may_be_of_one_of_several_buttons() -> None:
    found = read_trigger("remote#Button 2 press 'remote_button_short_press turn_on'")
    assert isinstance(found, Press)
    assert (found.part, found.value) == ("button 2", "remote_button_short_press turn_on")
    named = read_trigger("Button #2 press")
    assert isinstance(named, Press)
    assert not named.part, "that is a name"


def test_a_robot_comes_and_goes() -> None:
    assert read_trigger("Rosie arrives in living room") == RobotArrival("rosie", "living room")
    assert read_trigger("robot leaves kitchen") == RobotArrival("robot", "kitchen", leaves=True)


def test_times_of_the_day_and_of_the_sun() -> None:
    assert read_trigger("22:00 on weekdays") == DaysAndTime("22:00", "mon-fri")
    assert read_trigger("7:30") == DaysAndTime("7:30", "")
    assert read_trigger("sunset - 30m") == SunMoment("sunset", "-30m")
    assert read_trigger("Sunrise") == read_trigger("sunrise") == SunMoment("sunrise", "0s")
    assert read_trigger("22:00 on sat and sun") == DaysAndTime("22:00", "sat,sun")
    assert read_trigger("22:00 on mondays") == DaysAndTime("22:00", "mondays")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("25:00", "25:00"),
        ("22:00 on funday", "no day 'funday'"),
        ("sunset - soon", "'soon' is not a duration"),
        ("sunset + 30h", "30h is more than 12 hours from the sunset"),
        ("hall lamp", "names no state; write it like"),
        ("at 22:00", "'at 22:00': write a time like '22:00 on weekdays'"),
        ("22.00", "write a time like '22:00 on weekdays'"),
        ("every day at 7", "write a time like '22:00 on weekdays', here '07:00'"),
        ("10pm", "here '22:00'"),
        ("every 0.5s", "the shortest interval is 1 s"),
        ("12:30 am on sat,sun", "here '00:30 on sat,sun'"),
        ("every monday at 22:00", "here '22:00 on monday'"),
        ("sunset -30", "like 'sunset - 30m'"),
        ("door open for 5", "like 'door open for 5m'"),
        ("temperature nursery under 18", "write it like 'temperature in nursery under 18 °C'"),
        ("temperature of tea urn above", "write it like 'tea urn temperature above 18 °C'"),
        ("temperature below", "write it like 'temperature below 18 °C'"),
        ("power above 5 kW", "power is a number in W, not '5kW'"),
        ("nobody home", "start by 'Anna arrives', 'everybody has left' or 'nobody is home'"),
        ("sunnset - 30m", "write a moment like 'sunset - 30m'"),
        ("1h before sunrise", "write a moment like 'sunset - 30m'"),
        ("all windows closed", "would hold as soon as one of them does; ask for the contrary, like 'no window open'"),
        ("every half hour", "write an interval like 'every 30m', or a time like '22:00 on weekdays'"),
        ("lamp on near robot", "arrives in"),
        ("front door open for 5 parsecs", "is not a duration"),
        ("front door open or sunset", "`or` joins only states of devices here; write 'sunset' for itself"),
        ("22:00 on monday or sunset", "write '22:00 on monday' for itself"),
        ("Anna arrives or Ben arrives", "write 'Anna arrives' for itself"),
        ("front door open and nobody in study", "write 'nobody in study' for itself"),
    ],
)
def test_a_mistake_is_named(text: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        read_trigger(text)


@pytest.mark.parametrize("text", ["Anna arrives", '"Anna" arrives', "the Anna arrives"])
def test_a_person_is_found_by_a_name_in_quotes_or_after_an_article(text: str) -> None:
    trigger = read_trigger(text)
    assert isinstance(trigger, PersonMoves)
    assert NameIs("anna") in [*leaves(trigger.query)]


def test_a_button_is_found_by_a_name_after_an_article() -> None:
    press = read_press("Remote#the left press double")
    assert press is not None
    part = DevicePart(id="l", part=Part(id="l", service_type="generic_switch", name="Left"), routes=())
    assert press.buttons([part]) == [part]


@pytest.mark.parametrize("text", ["temperature rises above 25 °C in hall", "temperature in hall rises above 25 °C"])
def test_what_passes_a_limit_begins_to_be_beyond_it(text: str) -> None:
    found, state = read_trigger(text), read_trigger("temperature in hall above 25 °C")
    assert isinstance(found, Becomes)
    assert isinstance(state, Becomes)
    assert found.query == state.query


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("temperature of tea urn above 26 °C for 5m", "tea urn temperature above 26 °C"),
        ("temperature of tea urn rises above 26", "tea urn temperature above 26"),
        ("temperature in nursery is below 18 °C", "temperature is below 18 °C in nursery"),
        ("light in hall level above 50 %", "light in hall level above 50 %"),
        ("mode option night", 'mode option="night"'),
        ("not mode option movie night for 5m", 'mode option="movie night"'),
    ],
)
def test_the_value_of_a_state_may_stand_before_its_device(text: str, words: str) -> None:
    """Both orders mean the same; a text that a helper or device may have needs no sign."""
    trigger = read_trigger(text)
    assert isinstance(trigger, Becomes)
    assert trigger.words == words
    assert trigger.is_none is text.startswith("not ")
