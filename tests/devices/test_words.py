"""Plain words: what parts say, and what they are told."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.devices.words import main_part, meaning, read_words_address, word, words_address
from homebot.errors import RefusedError


def part(*settable: str, **options: tuple[str, ...]) -> Part:
    names = (*settable, *options)
    return Part(
        id="",
        service_type="light",
        capabilities=tuple(Capability(name=one, settable=True, options=options.get(one, ())) for one in names),
    )


@pytest.mark.parametrize(
    ("readings", "said"),
    [
        ({"level": 40.0, "on_off": True, "color_temperature": 2700.0}, "on"),
        ({"on_off": False, "level": 0.0}, "off"),
        ({"level": 40.0}, "0.4"),
        ({"color_temperature": 2700.0}, "2700 K"),
        ({"position": 0.0}, "closed"),
        ({"position": 100.0, "movement": "open"}, "open"),
        ({"position": 30.0, "movement": "stopped"}, "0.3"),
        ({"position": 30.0, "movement": "closing"}, "closing"),
        ({"movement": "open"}, "open"),
        ({"lock": "jammed"}, "jammed"),
        ({"contact": True}, "open"),
        ({"contact": False, "battery": 80.0}, "closed"),
        ({"occupancy": True, "illuminance": 3.0}, "motion"),
        ({"occupancy": False}, "clear"),
        ({"temperature": 21.5}, "21.5"),
        ({"temperature": -0.0001}, "0"),
        ({"smoke": True}, "on"),
        ({"on_off": None, "temperature": 3.0}, "3"),
        ({"on_off": None}, None),
        ({"color": (1.0, 2.0)}, None),
        ({}, None),
    ],
)
def test_a_message_is_told_in_one_word(readings: dict[str, PlainValue], said: str | None) -> None:
    assert word(readings) == said


@pytest.mark.parametrize(
    ("told", "thing", "meant"),
    [
        ("off", part("level", "on_off"), ("on_off", False)),
        ("0.4", part("on_off", "level"), ("level", 40.0)),
        ("0", part("on_off", "level"), ("on_off", False)),
        ("2700 K", part("color_temperature"), ("color_temperature", 2700.0)),
        ("open", part("movement", "position"), ("movement", "open")),
        ("close", part("position"), ("position", 0.0)),
        ("0.5", part("movement", "position"), ("position", 50.0)),
        ("stop", part("valve"), ("valve", "stopped")),
        ("unlock", part("lock"), ("lock", "unlocked")),
        ("21.5", part("heating_setpoint"), ("heating_setpoint", 21.5)),
        ("press", part("push"), ("push", True)),
        ("eco", part("on_off", preset_mode=("eco", "away")), ("preset_mode", "eco")),
        ("anything", part("text"), ("text", "anything")),
    ],
)
def test_a_word_is_understood_by_what_the_part_can_do(told: str, thing: Part, meant: tuple[str, PlainValue]) -> None:
    assert meaning(told, thing) == meant


@pytest.mark.parametrize("told", ["on", "1.5", "nan", "", "3 K", "eco"])
def test_a_word_that_the_part_does_not_take_is_refused_with_those_that_it_takes(told: str) -> None:
    with pytest.raises(RefusedError, match=r"this part takes open, close, stop, a number from 0 to 1$"):
        meaning(told, part("movement", "position"))


def test_a_part_that_cannot_be_told_anything_takes_nothing() -> None:
    sensor = Part(id="", service_type="temperature_sensor", capabilities=(Capability(name="temperature"),))
    with pytest.raises(RefusedError, match="takes nothing"):
        meaning("on", sensor)


def test_the_main_part_is_no_setting_and_no_diagnosis() -> None:
    lamp = Part(id="lamp", service_type="light")
    led = Part(id="led", service_type="switch", category="config")
    assert main_part((led, lamp)) is lamp
    assert main_part((led,)) is led
    assert main_part(()) is None


@given(st.text(), st.text())
def test_a_words_address_holds_key_and_part(key: str, part_id: str) -> None:
    address = words_address(key, part_id)
    assert read_words_address(address) == (key, part_id)


@pytest.mark.parametrize("address", ["home/lamp/out", "words:x", "words:a#b#c", ""])
def test_any_other_address_is_none(address: str) -> None:
    assert read_words_address(address) is None


@given(st.dictionaries(st.text(), st.none() | st.booleans() | st.floats() | st.text() | st.tuples(st.floats())))
def test_no_reading_is_too_odd_for_a_word(readings: dict[str, PlainValue]) -> None:
    said = word(readings)
    assert said is None or isinstance(said, str)


@given(st.text(), st.sampled_from(["level", "position", "on_off", "text", "option", "color_temperature"]))
def test_no_word_is_too_odd_to_be_judged(told: str, name: str) -> None:
    try:
        capability, _ = meaning(told, part(name))
    except RefusedError:
        return
    assert capability == name
