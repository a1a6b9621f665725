"""Loops, ends and messages with values, in a running routine and in its export."""

import pytest
from tests.apps.houses import hall, is_on
from tests.features.routines.test_routine import config

from homebot.errors import ConfigError
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.text import read_routines, read_settings
from homebot.testing import virtual_house_of
from homebot.words.routine_text import routine_text

OTHER: dict[str, object] = {"name": "Other", "when": ["08:05"], "do": ["hall lamp on"]}
MESSAGE = {"repeat": 2, "do": ["notify Hello", "wait 1m"]}
MOVES = {"while": ["hall motion occupied"], "do": ["notify Somebody is here", "wait 5m"]}
EMPTY = {"until": ["hall motion clear"], "do": ["notify Waiting", "wait 5m"]}
EACH = {
    "for_each": "motion sensor or lamp",
    "do": [{"if": ["it on"], "do": ["notify Close it: {name of it} in {room of it}"], "else": ["notify {name of it}"]}],
}
OFF_ONE_BY_ONE = {"for_each": "lamp on", "do": ["it off", "wait 1m"]}
WAIT = "wait until hall lamp on, at most 1m"


@pytest.mark.slow
@pytest.mark.virtual_time
@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize(
    ("steps", "told", "lamp_is_on"),
    [
        ((MESSAGE,), ["Hello"] * 2, True),
        (({"repeat": 2, "do": [MESSAGE, {"if": ["after 7:00"], "do": ["stop"]}]},), ["Hello"] * 2, True),
        ((MOVES, "notify Over"), ["Somebody is here"] * 3 + ["Over"], True),
        ((EMPTY, "notify Over"), ["Waiting"] * 3 + ["Over"], True),
        ((EACH, "notify Over"), ["hall_lamp", "hall_motion", "Over"], True),
        (("wait 10m", EACH), ["Close it: hall_lamp in hall", "hall_motion"], True),
        ((OFF_ONE_BY_ONE, "notify Over"), ["Over"], True),
        (("2 times: notify Hello; wait 1m",), ["Hello"] * 2, True),
        (("repeat while hall motion occupied: notify Hello; wait 5m", "notify Over"), ["Hello"] * 3 + ["Over"], True),
        (
            ("if hall lamp on and between 22:00 and 6:30: notify One, else: notify Two; notify Three",),
            ["Two", "Three"],
            True,
        ),
        (("wait 10m", "for each lamp on: it off", "notify Over"), ["Over"], False),
        (("wait 10m", OFF_ONE_BY_ONE, "notify Over"), ["Over"], False),
        (("notify One", "stop", "notify Two"), ["One"], True),
        ((f"{WAIT}, then stop", "notify Two"), [], True),
        ((f"{WAIT}, then go on", "notify Two"), ["Two"], True),
        ((WAIT, "notify Two"), ["Two"], True),
        (("routine Other off", "wait 10m", "notify Two"), ["Two"], False),
        (("turn off routine other", "turn on the routine Other"), [], True),
        (("run routine other", "wait until hall lamp on, at most 1m, then stop", "notify Two"), ["Two"], True),
        (("notify One", "start the routine Visit"), ["One"], True),
        (("wait 1m", "notify {before}"), ["clear"], True),
        (("wait for hall lamp on or 23:00, at most 1h", "if wait ended by 23:00: stop", "notify Two"), ["Two"], True),
        (("wait for hall lamp on or 23:00, at most 1m", "if wait ended by hall lamp on: notify Two"), [], True),
        (
            ("notify {hall lamp level}: {name}, {room}, {routine} at {time}; {temperature of hall}",),
            ["100 %: hall_motion, hall, Visit at 08:01; unknown"],
            True,
        ),
    ],
)
async def test_a_run_takes_its_steps(steps: tuple[object, ...], told: list[str], lamp_is_on: bool) -> None:  # noqa: FBT001
    """Somebody comes into the hall at 8:01, and leaves at 8:10; another routine turns the lamp on at 8:05."""
    world = hall(("08:01", "hall"), ("08:10", "outside"))
    routine = {"name": "Visit", "when": ["hall motion occupied"], "do": [*steps]}
    given = config(routine, OTHER) | {"notify": {}}
    async with virtual_house_of(world=world, config=given, start="2026-01-01 08:00") as house:
        await house.run_until("09:00")
        assert [one.message for one in house.notifications] == told
        assert is_on(world, "hall_lamp") is lamp_is_on


@pytest.mark.slow
@pytest.mark.virtual_time
@pytest.mark.rooms("homeassistant")
async def test_routines_that_run_each_other_do_so_once() -> None:
    ring = [{"name": one, "when": [when], "do": [f"notify {one}", f"run routine {other}"]}
            for one, other, when in (("A", "B", "08:05"), ("B", "C", "12:00"), ("C", "A", "12:00"))]  # fmt: skip
    async with virtual_house_of(config=config(*ring) | {"notify": {}}, start="2026-01-01 08:00") as house:
        await house.run_until("08:10")
        assert [one.message for one in house.notifications] == ["A", "B", "C"]


@pytest.mark.parametrize(
    ("steps", "problem"),
    [
        ([{"repeat": 0, "do": ["stop"]}], "a loop has one of the keys repeat, while and until"),
        ([{"repeat": 101, "do": ["stop"]}], "100"),
        ([{"while": ["sun is up"], "do": ["hall lamp on"]}], "has a step that waits"),
        ([{"repeat": 2, "while": ["sun is up"], "do": ["wait 1m"]}], "a loop has one of the keys"),
        ([{"repeat": 40, "do": [{"repeat": 40, "do": ["wait 1s"]}]}], "more than 1,000 steps"),
        ([{"if": ["last run over 1h ago"], "do": ["stop"]}], "only the conditions of the routine know"),
        ([{"for_each": "lamp", "do": [{"for_each": "plug", "do": ["it off"]}]}], "another for_each is in this one"),
        ([{"for_each": "level above", "do": ["it off"]}], "for_each"),
        ([{"for_each": "lamp", "do": ["notify {it}"]}], "write it like {temperature of office}"),
        (["it off"], "`it` is the device in turn of a for_each; write which device is meant"),
        (["notify {the weather}"], "{the weather} is no value; write it like {temperature of office}"),
    ],
)
def test_a_mistake_in_a_step_is_named(steps: list[object], problem: str) -> None:
    table = {"name": "Wrong", "when": ["8:00"], "do": steps}
    with pytest.raises((ConfigError, ValueError)) as caught:
        RoutineSettings.model_validate(table)
    assert problem in str(caught.value)


def test_a_loop_is_written_as_it_was_read() -> None:
    do = [{"repeat": 3, "do": ["hall lamp toggle", {"while": ["sun is up"], "do": ["wait 1s"]}]}]
    table = {"name": "Visit", "when": ("8:00",), "do": tuple(do)}
    routine = RoutineSettings.model_validate(table)
    (again,) = read_routines(routine_text(routine.written()), "test")
    assert read_settings(again.text, "test") == routine
    assert str(routine.do[0]) == "3 times: hall lamp toggle; repeat while sun is up: wait 1s"
