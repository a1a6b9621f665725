"""What a command changes outside the device, and which sensors may see it."""

from __future__ import annotations

import pytest

from homebot.control.witnesses.effect import ACTING, SENSED, looks_of, seen_by, strength_of
from homebot.devices.value import PlainValue


@pytest.mark.parametrize(
    ("setting", "sensors"),
    [
        ("on_off", {"illuminance", "power"}),
        ("level", {"illuminance", "power"}),
        ("fan_speed", {"power"}),
        ("position", {"contact"}),
        ("movement", {"contact"}),
        ("lock", {"unlocked"}),
        ("valve", {"flow"}),
        ("color", set()),
    ],
)
def test_each_setting_is_seen_by_its_sensors(setting: str, sensors: set[str]) -> None:
    assert seen_by([setting]) == sensors
    assert sensors <= SENSED
    assert setting in ACTING


@pytest.mark.parametrize(
    ("values", "strength"),
    [
        ({"on_off": False, "level": 70.0}, 0.0),
        ({"on_off": True, "level": 70.0}, 70.0),
        ({"on_off": True}, 100.0),
        ({"position": 30.0}, 30.0),
        ({"movement": "open"}, 100.0),
        ({"movement": "opening"}, None),
        ({"lock": "locked"}, 0.0),
        ({"valve": "open"}, 100.0),
        ({}, None),
    ],
)
def test_a_part_is_as_strong_as_it_reports(values: dict[str, PlainValue], strength: float | None) -> None:
    assert strength_of(values, ()) == strength


def test_a_lamp_that_told_a_level_once_is_of_unknown_strength_without_one() -> None:
    assert strength_of({"on_off": True}, {"level"}) is None
    assert strength_of({"on_off": False}, {"level"}) == 0.0


def test_a_blue_lamp_looks_other_than_a_white_one_and_pale_colours_are_white() -> None:
    assert looks_of({"color": (240.0, 100.0)}) == " 8/4"
    assert looks_of({"color": (240.0, 5.0)}) == looks_of({}) == ""
    assert looks_of({"effect": "Rainbow"}) == "rainbow"
