"""Waits for what comes next, conditions about the run itself, and waits of a random length."""

import pytest
from tests.apps.houses import hall
from tests.features.routines.test_routine import config

from homebot.errors import ConfigError, UsageError
from homebot.features.routines.settings import RoutineSettings
from homebot.testing import virtual_house_of
from homebot.words.steps import read_step

VISIT = "hall motion occupied"
EMPTY = "hall motion clear"
FOR_NEXT = f"wait for {VISIT}, at most 1h"
TOLD: dict[str, object] = {"if": ["wait timed out"], "do": ["notify Nobody"], "else": ["notify Somebody"]}
BY_START: dict[str, object] = {"if": ["started by 08:05"], "do": ["notify Early"], "else": ["notify Late"]}


@pytest.mark.slow
@pytest.mark.virtual_time
@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize(
    ("when", "condition", "steps", "told"),
    [
        (["08:05"], [], [f"wait until {VISIT}, at most 1h", "notify At once"], ["08:05 At once"]),
        (["08:05"], [], [FOR_NEXT, "notify Again"], ["08:30 Again"]),
        (["08:05"], [], [f"wait for {EMPTY} for 2m or 09:00, at most 2h", "notify Left"], ["08:13 Left"]),
        (["08:05"], [], [f"wait for 08:20 or {EMPTY}, at most 2h", "notify Left"], ["08:11 Left"]),
        (["08:05"], [], ["wait for 08:07 or 10:00, at most 2h", "notify Seven"], ["08:07 Seven"]),
        (["08:05"], [], ["wait for hall motion changes, at most 2h", "notify Changed"], ["08:11 Changed"]),
        (["08:05"], [], ["wait for 09:30, at most 1m, then stop", "notify Over"], []),
        (["08:05"], [], ["wait for 09:30, at most 1m", TOLD, FOR_NEXT, TOLD], ["08:06 Nobody", "08:30 Somebody"]),
        (["08:05", "08:07"], [], [BY_START], ["08:05 Early", "08:07 Late"]),
        (["08:05", "08:07"], ["not started by 08:05"], ["wait 1m", BY_START], ["08:08 Late"]),
        (["08:05", "08:07"], ["started by 08:05 or after 09:00"], ["notify Now"], ["08:05 Now"]),
    ],
)
async def test_a_run_waits_for_what_comes_and_knows_what_started_it(
    when: list[str], condition: list[str], steps: list[object], told: list[str]
) -> None:
    """Somebody is in the hall from 8:01 to 8:10, and from 8:30 on."""
    world = hall(("08:01", "hall"), ("08:10", "outside"), ("08:30", "hall"))
    routine = {"name": "Visit", "when": when, "if": condition, "do": steps}
    given = config(routine) | {"notify": {}}
    async with virtual_house_of(world=world, config=given, start="2026-01-01 08:00") as house:
        told_at: list[str] = []
        for minute in range(1, 100):
            await house.run_until(f"{8 + minute // 60:02}:{minute % 60:02}:30")
            new = house.notifications[len(told_at) :]
            told_at += [f"{8 + minute // 60:02}:{minute % 60:02} {one.message}" for one in new]
        assert told_at == told


@pytest.mark.slow
@pytest.mark.virtual_time
async def test_a_random_wait_is_as_long_as_its_ends_say() -> None:
    routine = {"name": "Random", "when": ["08:05"], "do": ["wait 1m to 3m", "notify Now"]}
    given = config(routine) | {"notify": {}}
    async with virtual_house_of(world=hall(), config=given, start="2026-01-01 08:00") as house:
        await house.run_until("08:05:59")
        assert not house.notifications
        await house.run_until("08:08:05")
        assert len(house.notifications) == 1


@pytest.mark.parametrize(
    ("routine", "problem"),
    [
        ({"when": ["8:00"], "if": ["started by 9:00"], "do": ["stop"]}, "is none of the triggers in `when`"),
        ({"when": ["8:00"], "if": ["wait timed out"], "do": ["stop"]}, "none comes before"),
        ({"when": ["8:00"], "do": ["wait for the weather, at most 5m"]}, "the weather"),
        ({"when": ["8:00"], "do": ["wait 5m to 1m"]}, "must be longer"),
    ],
)
def test_a_mistake_about_a_run_is_named(routine: dict[str, object], problem: str) -> None:
    with pytest.raises((ConfigError, ValueError, UsageError)) as caught:
        RoutineSettings.model_validate({"name": "Wrong", **routine})
    assert problem in str(caught.value)


def test_to_wait_for_a_length_of_time_is_still_explained() -> None:
    with pytest.raises(UsageError, match="write 'wait 5m'"):
        read_step("wait for 5m")
