"""Steps with numbers of the house: a helper says how long, or how bright."""

import pytest
from tests.apps.houses import hall
from tests.features.routines.test_routine import config

from homebot.errors import UsageError
from homebot.testing import virtual_house_of
from homebot.words.steps import Do, Wait, read_step


@pytest.mark.slow
@pytest.mark.virtual_time
async def test_a_step_takes_the_number_of_now_and_is_left_out_while_it_is_unknown() -> None:
    """Of two pauses the last is unknown."""
    steps = ["wait {number of pause}m", "limit number {number of pause}", "wait {number of nothing}h"]
    routine = {"name": "Steps", "when": ["08:00"], "do": [*steps, "notify {number of limit} at {time}"]}
    given = config(routine) | {"home": {"zone": "UTC"}, "helpers": {"limit": 60, "pause": 5}, "notify": {}}
    async with virtual_house_of(world=hall(), config=given, start="2026-01-01 07:59") as house:
        await house.run_until("08:10")
        assert [one.message for one in house.notifications] == ["5 at 08:05"]


def test_only_commands_and_pauses_have_numbers_of_the_house() -> None:
    assert isinstance(read_step("heater to {number of target} °C"), Do)
    assert isinstance(read_step("wait {number of pause}m"), Wait)
    for text in ("scene {number of pause}", "heater to {name} °C", "wait {option of mode}m"):
        with pytest.raises(UsageError):
            read_step(text)
