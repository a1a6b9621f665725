"""What hundreds of routines cost, by the processor."""

import time
from typing import NamedTuple

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest
from homebot.devices.names import CHANGE_ROUTINE
from homebot.graph import Node
from homebot.runtime import Runtime

pytestmark = [pytest.mark.slow, pytest.mark.no_cover]

ADDED = '[[routines]]\nname = "Added"\nwhen = ["lamp 7 on"]\ndo = ["lamp 8 on"]\n'


class Cost(NamedTuple):
    """Seconds of the processor for the start, and to add one more."""

    start: float
    addition: float


async def cost_of(routines: int) -> Cost:
    tables = [
        {"name": f"Routine {number}", "when": [f"lamp {number} on"], "do": [f"plug {number} off", "wait 5m", "undo"]}
        for number in range(routines)
    ]
    began = time.process_time()
    async with (
        Runtime(parse_config({"routines": tables}, "test"), with_door=False) as runtime,
        Node(runtime.graph, "owner") as owner,
    ):
        started = time.process_time()
        client = owner.create_client(ChangeRoutine, CHANGE_ROUTINE)
        answer = await client.call(ChangeRoutineRequest(name="", change="new", text=ADDED), timeout=PATIENCE)
        assert answer.success
        return Cost(started - began, time.process_time() - started)


async def test_the_start_is_linear_in_routines_and_one_more_costs_little() -> None:
    """Each heard of all entities of all others, and one more was compared by all pairs."""
    with anyio.fail_after(PATIENCE):
        await cost_of(1)  # imports
        few, many = await cost_of(30), await cost_of(300)
    assert many.start < 20 * few.start
    assert many.addition < many.start / 5
