"""A word means the same wherever people may write it."""

from collections.abc import Callable, Mapping

import pytest

from homebot.devices.part import Capability, Part
from homebot.devices.query.terms import NameIs, Query, StateIs, leaves
from homebot.devices.value import PlainValue
from homebot.words.colors import COLORS, WHITES
from homebot.words.commands import parse_command_words
from homebot.words.conditions import Matches, OnDays, read_condition
from homebot.words.days import CalendarDays, read_days
from homebot.words.exact_queries import parse_exact_query
from homebot.words.patterns import read_pattern
from homebot.words.queries import parse_query
from homebot.words.steps import Do, Wait, WaitUntil, read_step
from homebot.words.times import DaysAndTime, SunMoment
from homebot.words.triggers import Becomes, PersonMoves, read_trigger
from homebot.words.vocabulary import ADJECTIVES, CONDITIONS, HOUSEHOLD_FACTS
from homebot.words.wishes import KnownNames, StateCondition, read_wishes

TABLE: Mapping[str, tuple[str, ...]] = {
    "state": tuple(state for state, (first, *_) in ADJECTIVES.items() if first.capability != "at_home"),
    "people": tuple(f"{who} is {where}" for who in HOUSEHOLD_FACTS for where in ("home", "at home", "away")),
    "level = 40": ("%", "percent", "per cent"),
    "heating_setpoint = 21.5": ("°C", "C", "°", "degrees", "celsius"),
    "color_temperature = 2700": ("K", "k", "kelvin"),
    "color": (*COLORS, *WHITES),
    "length": ("30m", "30 min", "30 minutes", "half an hour", "1800 s", "0.5 h"),
    "days": ("sat,sun", "saturday and sunday", "weekends", "weekend", "Sat and Sun"),
}
"""The words of each kind; those of a number, a length and days all mean the same."""


def states(query: Query) -> frozenset[tuple[str, PlainValue]]:
    return frozenset((term.capability, term.value) for term in leaves(query) if isinstance(term, StateIs))


def meant(value: object) -> frozenset[tuple[str, PlainValue]]:
    """The values in what a grammar returns."""
    match value:
        case Matches(state):
            return states(state.query)
        case WaitUntil(state) | (Becomes() as state):
            return states(state.query)
        case PersonMoves():
            return frozenset({(value.fact, value.is_home)})
        case (StateCondition(states=terms),):
            return frozenset((term.capability, term.value) for term in terms)
    return states(value)  # type: ignore[arg-type]


def wishes(text: str) -> object:
    return read_wishes(text, KnownNames())


STATES: Mapping[str, Callable[[str], object]] = {
    "{} door": parse_query,
    "act {} door": lambda text: parse_exact_query(text.removeprefix("act ")),
    "use {} door": lambda text: read_pattern(text).query,
    "hall door {}": read_trigger,
    "hall door {} for 5m": read_trigger,
    "front door {}": read_condition,
    "no door {}": read_condition,
    "wait until hall door {}, at most 5m": read_step,
    "the hall door is {}": wishes,
}
"""Every grammar in which a device may be in a state."""


@pytest.mark.parametrize("form", STATES)
def test_a_state_is_the_same_in_all_grammars(form: str) -> None:
    for state in TABLE["state"]:
        expected = frozenset((term.capability, term.value) for term in ADJECTIVES[state])
        if state in {"on", "off"} and form != "the hall door is {}":  # a wish is about what can be switched
            expected |= {("contact", state == "on")}
        assert meant(STATES[form](form.format(state))) == expected, state


@pytest.mark.parametrize("form", ["{}", "wait until {}, at most 5m"])
def test_people_are_the_same_in_all_grammars(form: str) -> None:
    for text in TABLE["people"]:
        expected = states(CONDITIONS[text])
        readers: tuple[Callable[[str], object], ...] = (parse_query, read_trigger, read_condition)
        if "wait" in form:
            readers = (read_step,)
        for read in readers:
            assert meant(read(form.format(text))) == expected, text


@pytest.mark.parametrize("quantity", [kind for kind in TABLE if "=" in kind])
def test_a_unit_is_the_same_in_all_grammars(quantity: str) -> None:
    capability, number = quantity.split(" = ")
    part = Part(id="part", service_type="light", capabilities=(Capability(name=capability, settable=True),))
    value = {(capability, float(number))}
    for unit in TABLE[quantity]:
        text = f"{number} {unit}"
        assert meant(parse_query(f"{capability} = {text}")) == value, unit
        assert meant(read_trigger(f"{capability} in hall above {text}")) == value, unit
        assert meant(read_condition(f"no {capability} in hall above {text}")) == value, unit
        assert meant(read_pattern(f"use {capability} < {text}").query) == value, unit
        assert read_step(f"thing {text}") == Do(f"thing {text}", "thing", text)
        assert read_step(f"thing to {text}") == Do(f"thing to {text}", "thing", text)
        assert wishes(f"thing is at {text}") == (StateCondition(f"thing is at {text}", "thing", text),)
        for command in (text, f"{capability} {text}", f"set {capability} to {text}"):
            assert parse_command_words(command, (), part, "thing") == dict(value), command


@pytest.mark.parametrize("color", TABLE["color"])
def test_a_color_is_the_same_in_all_grammars(color: str) -> None:
    able = tuple(Capability(name=name, settable=True) for name in ("level", "color_temperature", "color"))
    part = Part(id="part", service_type="light", capabilities=able)
    assert read_step(f"thing {color}") == Do(f"thing {color}", "thing", color)
    assert read_step(f"thing color {color}").command == f"color {color}"  # type: ignore[union-attr]
    assert wishes(f"thing is {color}") == (StateCondition(f"thing is {color}", "thing", color),)
    expected = {"color_temperature": WHITES[color]} if color in WHITES else {"color": COLORS[color]}
    for command in (color, f"color {color}"):
        assert parse_command_words(command, (), part, "thing") == expected


def test_a_hue_is_the_same_in_all_grammars() -> None:
    part = Part(id="part", service_type="light", capabilities=(Capability(name="color", settable=True),))
    for hue in ("color 240 80", "color 240, 80"):
        assert parse_command_words(hue, (), part, "thing") == {"color": (240.0, 80.0)}
        assert read_step(f"thing {hue}") == Do(f"thing {hue}", "thing", hue)
        assert read_step(f"thing {hue}, 20 %") == Do(f"thing {hue}, 20 %", "thing", hue, (("level", "20 %"),))


def test_a_length_of_time_and_days_are_the_same_in_all_grammars() -> None:
    for length in TABLE["length"]:
        assert read_trigger(f"hall door open for {length}").lasting == 1800.0  # type: ignore[union-attr]
        assert read_step(f"wait {length}") == Wait(1800.0)
        assert read_step(f"wait until hall door open, at most {length}").most == 1800.0  # type: ignore[union-attr]
        assert read_step(f"thing on, over {length}").transition == 1800.0  # type: ignore[union-attr]
        assert read_step(f"scene Film, over {length}").transition == 1800.0  # type: ignore[union-attr]
        assert SunMoment.seconds.fget(read_trigger(f"sunset - {length}")) == -1800.0  # type: ignore[attr-defined]
    for days in TABLE["days"]:
        assert read_days(days) == CalendarDays(frozenset({5, 6}))
        assert read_condition(f"on {days}") == OnDays(CalendarDays(frozenset({5, 6})))
        moment = read_trigger(f"22:00 on {days}")
        assert isinstance(moment, DaysAndTime)
        assert read_days(moment.days) == CalendarDays(frozenset({5, 6}))


def test_an_exact_name_is_the_same_in_all_grammars() -> None:
    name = NameIs("hall lamp")
    read: tuple[Query, ...] = (
        parse_query('name="Hall lamp"'),
        parse_exact_query('name="Hall lamp"'),
        read_pattern('use name="Hall lamp"').query,
        read_trigger('name="Hall lamp" on').query,  # type: ignore[union-attr]
        read_condition('name="Hall lamp" on').state.query,  # type: ignore[union-attr]
    )
    assert all(name in leaves(query) for query in read)
