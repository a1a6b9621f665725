"""Plans of a large house, and the bounds of the search."""

from __future__ import annotations

import sys
import traceback
from dataclasses import replace

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.errors import UsageError
from homebot.features.goals.operators import GoalProblem, Operator, is_plan
from homebot.features.goals.planner import find_plan


def chain(rooms: int) -> GoalProblem:
    """A robot in the first of *rooms* in a row, each door of which is closed, is wished into the last one."""
    problem = GoalProblem(facts={"at 0"}, goal={f"at {rooms - 1}": None})
    for number in range(rooms - 1):
        door = frozenset((f"open {number}",))
        problem.operators.append(Operator(frozenset(), door))
        for here, there in ((number, number + 1), (number + 1, number)):
            at = frozenset((f"at {here}",))
            problem.operators.append(Operator(at | door, frozenset((f"at {there}",)), at))
    return problem


def lamps(count: int) -> GoalProblem:
    """So many lamps are off, and wished on."""
    problem = GoalProblem()
    for number in range(count):
        on, off = frozenset((f"{number} on",)), frozenset((f"{number} off",))
        problem.facts |= off
        problem.goal |= dict.fromkeys(on)
        problem.operators += [Operator(frozenset(), on, off), Operator(frozenset(), off, on)]
    return problem


async def test_a_robot_passes_all_doors_of_fifty_rooms() -> None:
    problem = chain(50)
    found = await find_plan(problem)
    assert found is not None
    assert len(found) == 2 * 49
    assert is_plan(problem, found)


async def test_five_hundred_lamps_are_turned_on_at_once() -> None:
    problem = lamps(500)
    found = await find_plan(problem)
    assert found is not None
    assert len(found) == 500
    assert is_plan(problem, found)


async def test_opposite_wishes_for_five_hundred_lamps_have_no_find_plan() -> None:
    problem = lamps(500)
    problem.goal |= {fact.replace("on", "off"): None for fact in problem.goal}
    assert await find_plan(problem) is None


async def test_a_room_of_a_hundred_lamps_is_not_lit_and_dark_at_once() -> None:
    problem = lamps(100)
    lit = frozenset(("lit",))
    problem.goal = dict.fromkeys(fact.replace("on", "off") for fact in problem.goal) | {"lit": None}
    problem.operators = [
        replace(one, takes=one.takes | lit) if "off" in str(one.gives) else one for one in problem.operators
    ]
    problem.operators += [Operator(frozenset((f"{number} on",)), lit) for number in range(100)]
    assert await find_plan(problem) is None


def puzzle() -> GoalProblem:
    """Eight sliding tiles, two of which are to be exchanged: each step is possible, and no way leads there."""
    problem = GoalProblem(facts={"free 8"})
    goal = [1, 0, *range(2, 8)]
    for tile in range(8):
        problem.facts.add(f"{tile} on {tile}")
        problem.goal[f"{tile} on {goal[tile]}"] = None
        for here, there in (
            (a, b) for a in range(9) for b in range(9) if abs(a // 3 - b // 3) + abs(a % 3 - b % 3) == 1
        ):
            needs = frozenset((f"{tile} on {here}", f"free {there}"))
            problem.operators.append(Operator(needs, frozenset((f"{tile} on {there}", f"free {here}")), needs))
    return problem


async def test_a_search_without_end_stops_after_its_time_or_its_states() -> None:
    with pytest.raises(UsageError, match=r"no plan was found in 0.1 s; ask for a part of the goal first"):
        await find_plan(puzzle(), 0.1)
    with pytest.raises(UsageError, match=r"no plan was found among 100 states; ask for a part of the goal first"):
        await find_plan(puzzle(), max_states=100)
    await no_search()


async def test_a_cancelled_search_stops() -> None:
    with anyio.move_on_after(0.1) as scope:
        await find_plan(puzzle())
    assert scope.cancelled_caught
    await no_search()


def _is_searching() -> bool:
    stacks = (traceback.extract_stack(frame) for frame in sys._current_frames().values())
    return any(frame.name == "_search" for stack in stacks for frame in stack)


async def no_search() -> None:
    """Wait until no thread searches."""
    with anyio.fail_after(PATIENCE):
        while _is_searching():  # noqa: ASYNC110 - threads set no event
            await anyio.sleep(0.01)


async def test_a_goal_that_is_so_needs_no_step() -> None:
    assert await find_plan(GoalProblem(facts={"at 0"}, goal={"at 0": None})) == []
