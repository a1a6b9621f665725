"""The planner: the only file that imports ``unified_planning``, which takes a second, with the first plan."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from threading import Event
from typing import Any, Final

import anyio
from anyio import to_thread

from homebot.errors import UsageError
from homebot.features.goals.operators import GoalProblem, Operator, is_plan, reachable
from homebot.plugins import check_extra

_ENGINE: Final = "pyperplan"
_ANY: Final = Operator(frozenset(), frozenset())


_LONGEST: Final = 30.0
"""Seconds for a plan. That of a large house takes one, and the first needs some more to load the planner."""


async def find_plan(problem: GoalProblem, longest: float = _LONGEST) -> list[Operator] | None:
    """Return operators that lead to the goal, without any that it does not need; None if there are none.

    Its thread ends after *longest* seconds, and when the caller is cancelled.

    Raises:
        UsageError: The planner is not installed, or there was no plan in that time.
    """
    stopped = Event()
    try:
        with anyio.fail_after(longest):
            return await to_thread.run_sync(_plan, problem, stopped.is_set, abandon_on_cancel=True)
    except TimeoutError:
        raise UsageError(f"no plan was found in {longest:g} s; ask for a part of the goal first") from None
    finally:
        stopped.set()


def _plan(problem: GoalProblem, is_stopped: Callable[[], bool]) -> list[Operator] | None:
    if not problem.missing:
        return []
    check_extra("a plan", "goals", "unified_planning", "up_pyperplan")
    operators = list(problem.allowed())
    if not problem.goal.keys() <= reachable(problem.facts, operators) or _opposite(problem, operators):
        return None  # a search would last for minutes
    simple = _simple(problem, operators)
    rest = replace(problem, facts=problem.facts.union(*(one.gives for one in simple)))
    useful = _relevant(rest, operators)
    found = [useful[number] for number in _solve(rest, useful, is_stopped)] if rest.missing else []
    if not is_plan(rest, found):
        return None
    for one in tuple(reversed(found)):  # a satisficing planner may do more than is needed
        fewer = [other for other in found if other is not one]
        if is_plan(rest, fewer):
            found = fewer
    return [*simple, *found]


def _opposite(problem: GoalProblem, operators: Sequence[Operator]) -> bool:
    """Return whether a wish and another one undo each other, by whatever they are reached."""
    concerned = problem.goal.keys() | frozenset[str]().union(*(one.needs for one in operators if one.step is None))
    givers: dict[str, list[Operator]] = {}
    pairs = set[tuple[str, str]]()
    for one in operators:
        for fact in one.gives & concerned:
            givers.setdefault(fact, []).append(one)
            pairs.update((fact, other) for other in one.takes & concerned)
    undo = {(fact, other) for fact, other in pairs if all(other in one.takes for one in givers[fact])}
    both = [(fact, other) for fact, other in undo if (other, fact) in undo]
    undone = {fact for fact, other in both if other in problem.goal}
    return any(
        fact in undone or all(one.step is None and not one.needs.isdisjoint(undone) for one in givers.get(fact, [_ANY]))
        for fact in problem.goal
    )


def _relevant(problem: GoalProblem, operators: Sequence[Operator]) -> list[Operator]:
    """Return the operators that may be of use."""
    wanted, found, waiting = set(problem.missing), list[Operator](), list(operators)
    while useful := [one for one in waiting if not one.gives.isdisjoint(wanted)]:
        waiting = [one for one in waiting if one.gives.isdisjoint(wanted)]
        found += useful
        for one in useful:
            wanted |= one.needs | (one.takes & problem.goal.keys())
    return found


def _simple(problem: GoalProblem, operators: Sequence[Operator]) -> list[Operator]:
    """Return operators that reach wishes without a need, and disturb nothing: the planner is slow with many lamps."""
    touched = problem.goal.keys() | frozenset[str]().union(*(one.needs for one in operators))
    missing = dict.fromkeys(problem.missing)
    givers: dict[str, list[Operator]] = {}
    for one in sorted(operators, key=lambda one: -len(one.gives & missing.keys())):  # a scene before its commands
        if one.takes.isdisjoint(touched):
            for fact in one.gives:
                givers.setdefault(fact, []).append(one)
    found: dict[Operator, None] = {}
    given = set[str]()
    for fact in missing:
        if fact not in given and (way := next(_ways(fact, givers), None)) is not None:
            found.update(dict.fromkeys(way))
            given.update(*(one.gives for one in way))
    return list(found)


def _ways(fact: str, givers: Mapping[str, Sequence[Operator]]) -> Iterator[list[Operator]]:
    """Yield operators without a need that give *fact*, alone or as what it follows from."""
    for one in givers.get(fact, ()):
        first = [other for need in one.needs for other in givers.get(need, ())[:1]] if one.step is None else []
        if len(first) == len(one.needs) and not any(other.needs for other in first):
            yield [*first, one]


def _solve(problem: GoalProblem, operators: Sequence[Operator], is_stopped: Callable[[], bool]) -> list[int]:
    """Return the numbers of the operators of a plan; none if there is no plan."""
    from unified_planning.environment import Environment  # noqa: PLC0415 - see above
    from unified_planning.model import Fluent, InstantaneousAction  # noqa: PLC0415 - see above
    from unified_planning.model import Problem as PlanningProblem  # noqa: PLC0415 - see above

    house = Environment()
    house.credits_stream = None
    task = PlanningProblem("house", house)
    used = set(problem.goal).union(*(one.needs for one in operators))
    names = {fact: f"f{number}" for number, fact in enumerate(sorted(used))}
    fluents = {fact: Fluent(name, environment=house) for fact, name in names.items()}
    for fact, fluent in fluents.items():
        task.add_fluent(fluent, default_initial_value=fact in problem.facts)
    for number, one in enumerate(operators):
        action = InstantaneousAction(f"o{number}", _env=house)
        for fact in sorted(one.needs):
            action.add_precondition(fluents[fact])
        for facts, value in ((one.takes - one.gives, False), (one.gives, True)):
            for fact in sorted(facts & used):
                action.add_effect(fluents[fact], value)
        task.add_action(action)
    for fact in problem.goal:
        task.add_goal(fluents[fact])
    with house.factory.OneshotPlanner(name=_ENGINE) as planner:
        planner._heuristic = partial(_Heuristic, planner._heuristic, is_stopped)  # noqa: SLF001 - it has no time limit
        found = planner.solve(task).plan
    return [] if found is None else [int(one.action.name[1:]) for one in found.actions]


class _Heuristic:
    """The heuristic of the planner, which asks for it in each step of its search: the only place to end that."""

    def __init__(
        self, make: Callable[[Any], Callable[[Any], float]], is_stopped: Callable[[], bool], task: Any
    ) -> None:
        self._estimate, self._is_stopped = make(task), is_stopped

    def __call__(self, node: Any) -> float:
        if self._is_stopped():
            raise TimeoutError
        return self._estimate(node)
