"""What is known of a part that a witness contradicted, and its record."""

from __future__ import annotations

import pytest

from homebot.control.witnesses.disproof import Disproof, disproof_name, disproof_record, read_disproof
from homebot.errors import WireError

PLACE = "lamp", "1"


def disproof(before: float = 0.0) -> Disproof:
    return Disproof(before, ("lux", "", "illuminance"), "Lux", 1000.0)


@pytest.mark.parametrize(("before", "strength"), [(0.0, 100.0), (0.0, 20.0), (100.0, 0.0), (100.0, 40.0)])
def test_what_the_witness_did_not_see_is_not_believed(before: float, strength: float) -> None:
    assert disproof(before).covers(strength)


@pytest.mark.parametrize(("before", "strength"), [(0.0, 0.0), (100.0, 100.0)])
def test_that_it_is_as_the_witness_saw_is_believed(before: float, strength: float) -> None:
    assert not disproof(before).covers(strength)


def test_an_unknown_strength_is_believed() -> None:
    assert not disproof().covers(None)


def test_commands_count_when_they_are_a_minute_apart_and_the_sensor_said_nothing() -> None:
    one = disproof()
    for seconds in (30, 60, 90, 120):
        one.count(1000.0 + seconds, is_heard=False)
    assert one.unheard == 2


def test_a_report_of_the_sensor_begins_the_count_anew() -> None:
    one = disproof()
    one.count(1060.0, is_heard=False)
    one.count(1070.0, is_heard=True)
    assert one.unheard == 0
    one.count(1129.0, is_heard=False)
    assert one.unheard == 0


def test_a_record_is_read_as_it_was_written() -> None:
    known = disproof(100.0)
    known.unheard = 3
    place, read = read_disproof(disproof_name(PLACE), disproof_record(PLACE, known))
    assert place == PLACE
    assert (read.before, read.sensor, read.name, read.counted_at, read.unheard) == (
        100.0,
        ("lux", "", "illuminance"),
        "Lux",
        1000.0,
        3,
    )
    assert (read.watch, read.reported) == (None, set())


@pytest.mark.parametrize(
    ("name", "record"),
    [
        ("lamp 1", "nonsense"),
        ("lamp 1", disproof_record(PLACE, disproof()).replace('"version":1', '"version":2')),
        ("lamp 1", disproof_record(PLACE, disproof()).replace('"before":0.0', '"before":1e999')),
        ("lamp 2", disproof_record(PLACE, disproof())),
    ],
    ids=["no JSON", "another version", "not finite", "another part"],
)
def test_a_record_that_cannot_be_read_is_an_error(name: str, record: str) -> None:
    with pytest.raises(WireError):
        read_disproof(name, record)
