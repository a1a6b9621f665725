import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.homie.formats.model import HomieProperty, Range, parse_options, parse_range
from homebot.integrations.homie.formats.properties import publication, read_color, read_plain, spell_color, spell_plain


def prop(datatype: str, *, within: Range | None = None, options: tuple[str, ...] = ()) -> HomieProperty:
    return HomieProperty("p", "", datatype, "homie/5/d/n/p", range=within or Range(), options=options)


@pytest.mark.parametrize(
    ("spelled", "expected"),
    [
        ("", Range()),
        ("0:100", Range(0, 100)),
        (":10", Range(None, 10)),
        ("-10:10:2", Range(-10, 10, 2)),
        ("5:30:0.5", Range(5, 30, 0.5)),
        ("0::5", Range(0, None, 5)),
    ],
)
def test_ranges_are_read(spelled: str, expected: Range) -> None:
    assert parse_range(spelled) == expected


@pytest.mark.parametrize("spelled", ["5", "a:", "nan:1", "1:0", "0:1:0", "0:1:2:3", "0x1:2"])
def test_an_invalid_range_is_refused(spelled: str) -> None:
    with pytest.raises(WireError):
        parse_range(spelled)


def test_blanks_of_options_count() -> None:
    assert parse_options("a, b") == ("a", " b")


@pytest.mark.parametrize(
    ("datatype", "payload", "expected"),
    [
        ("boolean", b"true", True),
        ("boolean", b"True", None),
        ("integer", b"21", 21.0),
        ("integer", b"+21", None),
        ("integer", b" 21", None),
        ("integer", b"2.5", None),
        ("float", b"21.5", 21.5),
        ("float", b"1e3", 1000.0),
        ("float", b"nan", None),
        ("float", b"inf", None),
        ("float", b"1e999", None),
        ("string", b"hello", "hello"),
        ("string", b"\x00", ""),
        ("string", b"\xff", None),
        ("datetime", b"2026-11-20T08:00:00Z", "2026-11-20T08:00:00Z"),
        ("enum", b"a", None),
    ],
)
def test_values_are_read(datatype: str, payload: bytes, expected: PlainValue) -> None:
    assert read_plain(prop(datatype), payload) == expected


def test_a_number_out_of_its_range_is_none() -> None:
    assert read_plain(prop("integer", within=Range(0, 100)), b"101") is None
    assert read_plain(prop("integer", within=Range(0, 100)), b"100") == 100.0


@pytest.mark.parametrize(
    ("datatype", "within", "value", "expected"),
    [
        ("boolean", Range(), False, "false"),
        ("integer", Range(0, 100), 29.6, "30"),
        ("integer", Range(-10, 10, 2), -4.9, "-4"),
        ("float", Range(5, 30, 0.5), 21.4, "21.5"),
        ("float", Range(5, 30, 0.5), 18.0, "18"),
        ("float", Range(0, 10, 3), 10.0, "9"),
        ("string", Range(), "", "\0"),
        ("string", Range(), "hello", "hello"),
    ],
)
def test_values_are_spelled(datatype: str, within: Range, value: PlainValue, expected: str) -> None:
    assert spell_plain(prop(datatype, within=within), "number", value) == expected


@pytest.mark.parametrize(
    ("datatype", "value"), [("integer", 101.0), ("integer", math.nan), ("boolean", 1.0), ("string", "a\n")]
)
def test_an_invalid_value_is_refused(datatype: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        spell_plain(prop(datatype, within=Range(0, 100)), "number", value)


@pytest.mark.parametrize(
    ("payload", "expected"),
    [
        (b"rgb,255,128,0", (30.118, 100.0, 100.0)),
        (b"hsv,300,50,75", (300.0, 50.0, 75.0)),
        (b"xyz,0.25,0.34", (175.89, 28.627, None)),
        (b"rgb,256,0,0", None),
        (b"rgb,0,0", None),
        (b"255,128,0", None),
        (b"cmyk,1,2,3,4", None),
        (b"", None),
    ],
)
def test_colours_are_read(payload: bytes, expected: object) -> None:
    assert read_color(prop("color", options=("rgb", "hsv", "xyz")), payload) == expected


def test_colours_of_version_4_do_not_name_their_form() -> None:
    rgb = HomieProperty("p", "", "color", "t", options=("rgb",), names_form=False)
    assert read_color(rgb, b"255,128,0") == (30.118, 100.0, 100.0)
    assert spell_color(rgb, 120.0, 100.0) == "0,255,0"


@pytest.mark.parametrize(
    ("forms", "expected"),
    [(("rgb", "hsv"), "hsv,300,50,100"), (("rgb",), "rgb,255,128,255"), (("xyz",), "xyz,0.368,0.204")],
)
def test_colours_are_spelled(forms: tuple[str, ...], expected: str) -> None:
    assert spell_color(prop("color", options=forms), 300.0, 50.0) == expected


def test_a_command_is_never_retained_and_exact_for_a_state() -> None:
    state = publication(prop("boolean"), "true")
    assert (state.topic, state.payload, state.qos, state.retain) == ("homie/5/d/n/p/set", b"true", 2, False)
    event = HomieProperty("p", "", "enum", "t", is_retained=False)
    assert publication(event, "stop").qos == 0


@given(st.floats(0, 360), st.floats(0, 100))
def test_a_spelled_colour_is_read_back_nearly(hue: float, saturation: float) -> None:
    hsv = prop("color", options=("hsv",))
    told = read_color(hsv, spell_color(hsv, hue, saturation).encode())
    assert told is not None
    assert abs(told[0] - hue) <= 0.5
    assert abs(told[1] - saturation) <= 0.5


@given(st.floats(-1e6, 1e6), st.sampled_from([None, 0.1, 0.5, 3.0]))
def test_a_spelled_number_is_read_back_within_a_step(value: float, step: float | None) -> None:
    number = prop("float", within=Range(-1e6, 1e6, step))
    told = read_plain(number, spell_plain(number, "number", value).encode())
    assert isinstance(told, float)
    assert abs(told - value) <= (step or 1e-6)
