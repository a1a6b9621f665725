"""Readings of queries with ``or``, and of lists."""

import pytest

from homebot.errors import UsageError
from homebot.words.readings import readings_of


@pytest.mark.parametrize(
    ("text", "alternatives", "distributed"),
    [
        ("lights in hall or kitchen", "lights in hall|kitchen", "lights in hall|lights in kitchen"),
        ("(lights in hall or kitchen)", "lights in hall|kitchen", "lights in hall|lights in kitchen"),
        ("fan in hall or big den or bath", "fan in hall|big den|bath", "fan in hall|fan in big den|fan in bath"),
        ("lights or fans or plugs in hall", "lights|fans|plugs in hall", "lights in hall|fans in hall|plugs in hall"),
        ("on lights or fans", "on lights|fans", "on lights|on fans"),
        ("hall or kitchen lights", "hall|kitchen lights", "hall lights|kitchen lights"),
        ("fan in den or bath with level", "fan in den|bath with level", "fan in den with level|fan in bath with level"),
        ("lights on or off in hall", "lights on|off in hall", "lights on in hall|lights off in hall"),
        ("on or off lights", "on|off lights", "on lights|off lights"),
        ("lights in hall or on", "lights in hall|on", "lights in hall|lights on"),
        ("lights not in hall or in den", "lights not in hall|in den", "lights not in hall|lights in den"),
        ("lights (on) or off in hall", "lights (on)|off in hall", ""),
        ("lights in hall or kitchen fans", "lights in hall|kitchen fans", ""),
        ("lights in hall or lights in kitchen", "lights in hall|lights in kitchen", ""),
        ("lights not in hall or kitchen", "lights not in hall|kitchen", ""),
        ("(lights in hall) or (kitchen)", "(lights in hall)|(kitchen)", ""),
        ("hall_lamp or kitchen_lamp", "hall_lamp|kitchen_lamp", ""),
        ("lights in hall", "lights in hall", ""),
        ("hall lamp, hall lamp 2", "hall lamp, hall lamp 2", "hall lamp|hall lamp 2"),
        ("kitchen and hall lights", "kitchen and hall lights", "kitchen lights|hall lights"),
        ("lights and dimmable in hall", "lights dimmable in hall", ""),
        ("all", "all", ""),
        ("the or lamp", "all|lamp", ""),
    ],
)  # fmt: skip
def test_words_of_one_side_may_be_meant_for_both(text: str, alternatives: str, distributed: str) -> None:
    found = readings_of(text)
    assert "|".join(found.alternatives) == alternatives
    assert "|".join(found.distributed) == distributed
    assert "|".join(readings_of(" or ".join(found.distributed or ["x"])).distributed) == ""  # it can be given back


def test_words_alone_are_told_apart() -> None:
    assert readings_of("light in hall or kitchen lamp or old kettle or (pump)").words == {"old kettle"}


@pytest.mark.parametrize("text", ["light or", "(light", "with nothing"])
def test_an_invalid_query_has_no_readings(text: str) -> None:
    with pytest.raises(UsageError):
        readings_of(text)
