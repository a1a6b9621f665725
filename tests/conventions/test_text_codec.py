"""Codec of text devices: states, commands, and answers to commands."""

import pytest

from homebot.conventions.description import Publication
from homebot.conventions.text_codec import TextCodec
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.thesis.formats import thesis_part


def codec(service_type: str) -> TextCodec:
    return TextCodec(thesis_part(service_type, "x/out", "x/in"))


def read(part: TextCodec, payload: bytes, *, retained: bool = False) -> dict[str, PlainValue]:
    return dict(part.read("x/out", payload, retained=retained))


def test_a_part_of_unknown_type_has_no_capabilities() -> None:
    coffee = codec("coffee")
    assert read(coffee, b"on") == {}
    with pytest.raises(RefusedError, match="this part takes nothing"):
        coffee.write("on_off", value=True)


def test_a_command_is_its_text_on_the_topic_where_the_part_listens() -> None:
    assert codec("lights").write("level", 40.0, transition=3.0) == (Publication("x/in", b"0.4", qos=1),)


def test_a_white_turns_a_lamp_on() -> None:
    published = codec("lights").write("color_temperature", 2700.0)
    assert [(one.topic, one.payload) for one in published] == [("x/in", b"2700 K"), ("x/in", b"on")]


def test_the_answer_of_a_thermostat_is_its_target_once() -> None:
    hall = codec("thermostats")
    hall.write("heating_setpoint", 21.0)
    assert [read(hall, one) for one in (b"18.5", b"21", b"20", b"21")] == [
        {"local_temperature": 18.5},
        {"heating_setpoint": 21.0},
        {"local_temperature": 20.0},
        {"local_temperature": 21.0},
    ]


@pytest.mark.parametrize("command", [b"\xff", b"brew", b"7" * 5000])
def test_a_command_that_the_part_does_not_know_changes_no_answer(command: bytes) -> None:
    hall = codec("thermostats")
    hall.expect(command)
    assert read(hall, b"19") == {"local_temperature": 19.0}
    assert read(hall, command) == {}


def test_the_same_text_again_is_the_answer_to_a_command_once() -> None:
    """A stuck lamp answers with its old state."""
    lamp = codec("lights")
    read(lamp, b"off")
    lamp.write("on_off", value=True)
    told = [read(lamp, b"off", retained=one) for one in (True, False, False)]
    assert told == [{}, {"on_off": False}, {}]


def test_a_thermostat_that_repeats_a_number_answers_nothing() -> None:
    """The room may have been as warm before as it is to be."""
    hall = codec("thermostats")
    read(hall, b"21")
    hall.write("heating_setpoint", 21.0)
    assert [read(hall, one) for one in (b"21", b"20", b"21")] == [
        {},
        {"local_temperature": 20.0},
        {"heating_setpoint": 21.0},
    ]
