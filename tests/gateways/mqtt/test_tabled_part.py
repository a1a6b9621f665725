import math

import pytest

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.mqtt.description import DescribedPart, Publication
from homebot.gateways.mqtt.tabled_part import TabledPart, json_in, number_in, text_in


def build() -> DescribedPart:
    part = TabledPart("a", "switch", name="A", advertised="relay")
    part.reads("t", lambda payload: {"on_off": payload == b"on"})
    part.reads_events("t", lambda _payload: {"press": "single"})
    part.listens("t/set")

    def write(value: PlainValue, transition: float) -> tuple[Publication, ...]:
        return (Publication("t/set", f"{value} {transition}".encode()),)

    part.offers("on_off", writer=write)
    part.offers("press")
    return part.described((Publication("t/get", b""),))


def test_a_part_says_what_it_can_do_and_where() -> None:
    described = build()
    assert described.part.reads == ("t",)
    assert described.part.writes == ("t/set",)
    assert [(one.name, one.settable) for one in described.part.capabilities] == [("on_off", True), ("press", False)]
    assert described.asks == (Publication("t/get", b""),)


def test_an_event_that_was_kept_is_none() -> None:
    codec = build().codec
    assert codec.read("t", b"on", retained=False) == {"on_off": True, "press": "single"}
    assert codec.read("t", b"on", retained=True) == {"on_off": True}
    assert codec.read("other", b"on", retained=False) == {}


@pytest.mark.parametrize("transition", [-1.0, math.nan, math.inf])
def test_a_transition_is_some_seconds(transition: float) -> None:
    with pytest.raises(RefusedError, match="seconds"):
        build().codec.write("on_off", True, transition=transition)


def test_what_it_cannot_be_told_is_refused() -> None:
    with pytest.raises(RefusedError, match="on_off"):
        build().codec.write("level", 1.0)
    assert build().codec.write("on_off", True, transition=2.0) == (Publication("t/set", b"True 2.0"),)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (1, 1.0),
        ("21.5", 21.5),
        ("1e3", 1000.0),
        (True, None),
        (None, None),
        ([], None),
        ("", None),
        ("nan", None),
        ("1_0", None),
        ("٣", None),
        (10**400, None),
        ("9" * 50, None),
    ],
)
def test_numbers_are_finite_and_spelled_plainly(value: object, expected: float | None) -> None:
    assert number_in(value) == expected


def test_what_is_no_text_or_json_is_none() -> None:
    assert text_in(b"\xff") is None
    assert text_in(b"x" * 300_000) is None
    assert json_in(b"NaN") is None
    assert json_in(b'{"a":1}') == {"a": 1}
