"""Checks of commanded values."""

import math

import pytest

from homebot.conventions.command_values import (
    Writer,
    bool_writer,
    number_writer,
    option_writer,
    push_writer,
    require_bool,
    require_color,
    require_number,
    require_option,
    require_transition,
)
from homebot.conventions.description import Publication, Publications
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError


def test_a_valid_value_is_returned() -> None:
    assert require_bool("on_off", value=False) is False
    assert require_number("level", 50, 0, 100, "%") == 50.0
    assert require_option("movement", "open", ("open", "closed")) == "open"
    assert require_color((120, 50.5)) == (120.0, 50.5)


@pytest.mark.parametrize("value", [None, 1, "on", (1.0,)])
def test_a_flag_is_true_or_false(value: PlainValue) -> None:
    with pytest.raises(RefusedError, match="true or false"):
        require_bool("on_off", value)


@pytest.mark.parametrize("value", [None, True, "5", -1, 101, math.nan])
def test_a_number_is_within_its_bounds(value: PlainValue) -> None:
    with pytest.raises(RefusedError, match="a number from 0 to 100 %"):
        require_number("level", value, 0, 100, "%")


@pytest.mark.parametrize("value", [None, 5.0, (), (1.0,), (361.0, 0.0), (0.0, 101.0), (math.nan, 0.0)])
def test_a_color_is_a_hue_and_a_saturation(value: PlainValue) -> None:
    with pytest.raises(RefusedError, match="0 to 360, 0 to 100"):
        require_color(value)


def test_an_option_is_one_of_those_named() -> None:
    with pytest.raises(RefusedError, match="it takes open, closed"):
        require_option("movement", "ajar", ("open", "closed"))
    with pytest.raises(RefusedError, match="it takes none"):
        require_option("movement", "ajar", ())
    with pytest.raises(RefusedError, match="…"):
        require_option("effect", "ajar", [f"effect {index}" for index in range(30)])


def test_a_transition_has_an_end_and_perhaps_a_longest() -> None:
    assert require_transition(1e6) == 1e6
    for seconds in (-1.0, math.nan, math.inf):
        with pytest.raises(RefusedError, match="it takes 0 or more seconds"):
            require_transition(seconds)
    with pytest.raises(RefusedError, match=r"a transition of 11 s.*it takes 0 to 10 s"):
        require_transition(11.0, most=10.0)


def test_a_writer_publishes_valid_values() -> None:
    def publish(value: object) -> Publications:
        return (Publication("t", str(value).encode()),)

    assert bool_writer("on_off", publish)(True, 0.0)[0].payload == b"True"
    assert number_writer("level", (0, 100), "%", publish)(40, 0.0)[0].payload == b"40.0"
    assert option_writer("movement", ("open", "closed"), publish)("open", 0.0)[0].payload == b"open"
    assert push_writer("push", lambda: publish("pushed"))(True, 0.0)[0].payload == b"pushed"


@pytest.mark.parametrize(
    ("writer", "value"),
    [
        (bool_writer("on_off", lambda _on: ()), 1.0),
        (number_writer("level", (0, 100), "%", lambda _number: ()), 101.0),
        (option_writer("movement", ("open",), lambda _option: ()), "ajar"),
        (push_writer("push", lambda: ()), False),
    ],
)
def test_a_writer_refuses_invalid_values(writer: Writer, value: PlainValue) -> None:
    with pytest.raises(RefusedError, match="it takes"):
        writer(value, 0.0)
