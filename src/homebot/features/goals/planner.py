"""The planner: a best-first search over the facts that matter, in a thread. Each step counts the same."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from heapq import heapify, heappop, heappush
from math import inf
from threading import Event
from typing import Final

import anyio
from anyio import to_thread

from homebot.errors import UsageError
from homebot.features.goals.operators import GoalProblem, Operator, is_plan, reachable

_ANY: Final = Operator(frozenset(), frozenset())

MAX_STATES: Final = 20_000
"""States of the house that a search visits. The way of a robot through fifty closed doors takes 4,900."""

MAX_TIME_S: Final = 30.0


async def find_plan(
    problem: GoalProblem, max_time: float = MAX_TIME_S, max_states: int = MAX_STATES
) -> list[Operator] | None:
    """Return operators that lead to the goal, without any that it does not need; None if there are none.

    Its thread ends after *max_time* seconds, and when the caller is cancelled.

    Raises:
        UsageError: There was no plan in that time, or among so many states.
    """
    stopped = Event()
    try:
        with anyio.fail_after(max_time):
            return await to_thread.run_sync(_plan, problem, stopped.is_set, max_states, abandon_on_cancel=True)
    except TimeoutError:
        raise UsageError(f"no plan was found in {max_time:g} s; ask for a part of the goal first") from None
    finally:
        stopped.set()


def _plan(problem: GoalProblem, is_stopped: Callable[[], bool], max_states: int) -> list[Operator] | None:
    if not problem.missing:
        return []
    operators = list(problem.allowed())
    if not problem.goal.keys() <= reachable(problem.facts, operators) or _opposite(problem, operators):
        return None  # a search would last for minutes
    simple = _simple(problem, operators)
    rest = replace(problem, facts=problem.facts.union(*(operator.gives for operator in simple)))
    useful = sorted(_relevant(rest, operators), key=_is_drive, reverse=True)  # of equals, the last is tried first
    plan = _search(rest, useful, is_stopped, max_states)
    if plan is None:
        return None
    for operator in tuple(reversed(plan)):  # the estimate may lead to more than is needed
        fewer = [other for other in plan if other is not operator]
        if is_plan(rest, fewer):
            plan = fewer
    return [*simple, *plan]


def _is_drive(operator: Operator) -> bool:
    """Return whether a robot drives: last and together, its drives become one."""
    return operator.step is not None and operator.step.kind == "drive"


def _opposite(problem: GoalProblem, operators: Sequence[Operator]) -> bool:
    """Return whether a wish and another one undo each other, by whatever they are reached."""
    concerned = problem.goal.keys() | frozenset[str]().union(
        *(operator.needs for operator in operators if operator.step is None)
    )
    givers: dict[str, list[Operator]] = {}
    pairs = set[tuple[str, str]]()
    for operator in operators:
        for fact in operator.gives & concerned:
            givers.setdefault(fact, []).append(operator)
            pairs.update((fact, other) for other in operator.takes & concerned)
    undo = {(fact, other) for fact, other in pairs if all(other in operator.takes for operator in givers[fact])}
    both = [(fact, other) for fact, other in undo if (other, fact) in undo]
    undone = {fact for fact, other in both if other in problem.goal}
    return any(
        fact in undone
        or all(operator.step is None and not operator.needs.isdisjoint(undone) for operator in givers.get(fact, [_ANY]))
        for fact in problem.goal
    )


def _relevant(problem: GoalProblem, operators: Sequence[Operator]) -> list[Operator]:
    """Return the operators that may be of use."""
    wanted, relevant, waiting = set(problem.missing), list[Operator](), list(operators)
    while useful := [operator for operator in waiting if not operator.gives.isdisjoint(wanted)]:
        waiting = [operator for operator in waiting if operator.gives.isdisjoint(wanted)]
        relevant += useful
        for operator in useful:
            wanted |= operator.needs | (operator.takes & problem.goal.keys())
    return relevant


def _simple(problem: GoalProblem, operators: Sequence[Operator]) -> list[Operator]:
    """Return operators that reach wishes without a need, and disturb nothing: the planner is slow with many lamps."""
    touched = problem.goal.keys() | frozenset[str]().union(*(operator.needs for operator in operators))
    missing = dict.fromkeys(problem.missing)
    givers: dict[str, list[Operator]] = {}
    for operator in sorted(
        operators, key=lambda operator: -len(operator.gives & missing.keys())
    ):  # a scene before its commands
        if operator.takes.isdisjoint(touched):
            for fact in operator.gives:
                givers.setdefault(fact, []).append(operator)
    chosen: dict[Operator, None] = {}
    given = set[str]()
    for fact in missing:
        if fact not in given and (way := next(_ways(fact, givers), None)) is not None:
            chosen.update(dict.fromkeys(way))
            given.update(*(operator.gives for operator in way))
    return list(chosen)


def _ways(fact: str, givers: Mapping[str, Sequence[Operator]]) -> Iterator[list[Operator]]:
    """Yield operators without a need that give *fact*, alone or as what it follows from."""
    for giver in givers.get(fact, ()):
        first = [other for need in giver.needs for other in givers.get(need, ())[:1]] if giver.step is None else []
        if len(first) == len(giver.needs) and not any(other.needs for other in first):
            yield [*first, giver]


def _search(
    problem: GoalProblem, operators: Sequence[Operator], is_stopped: Callable[[], bool], max_states: int
) -> list[Operator] | None:
    """Return the operators of a plan; None if there is none."""
    used = frozenset(problem.goal).union(*(operator.needs for operator in operators))
    users: dict[str, list[int]] = {}
    for number, operator in enumerate(operators):
        for fact in operator.needs:
            users.setdefault(fact, []).append(number)
    start = used.intersection(problem.facts)
    ways: dict[frozenset[str], tuple[Operator, ...]] = {start: ()}
    queue = [(0.0, 0, start)]
    while queue:
        facts = heappop(queue)[-1]
        if problem.goal.keys() <= facts:
            return list(ways[facts])
        if is_stopped():
            raise TimeoutError
        for operator in operators:
            if not operator.needs <= facts or (then := operator.after(facts) & used) in ways:
                continue
            ways[then] = (*ways[facts], operator)
            if (estimate := _estimate(then, problem, operators, users)) < inf:
                heappush(queue, (len(ways[then]) + estimate, -len(ways), then))
        if len(ways) > max_states:
            raise UsageError(f"no plan was found among {max_states} states; ask for a part of the goal first")
    return None


def _estimate(
    facts: frozenset[str], problem: GoalProblem, operators: Sequence[Operator], users: Mapping[str, Sequence[int]]
) -> float:
    """Return the steps to all wishes if none undid another and none served two; infinity if one is out of reach.

    The additive heuristic of Bonet and Geffner (Planning as heuristic search, 2001).
    """
    costs: dict[str, float] = {}
    waiting = [len(operator.needs) for operator in operators]
    sums = [1.0] * len(operators)
    queue = [(0.0, fact) for fact in facts]
    queue += [(1.0, fact) for operator in operators if not operator.needs for fact in operator.gives]
    heapify(queue)
    while queue:
        cost, fact = heappop(queue)
        if fact in costs:
            continue
        costs[fact] = cost
        for number in users.get(fact, ()):
            waiting[number] -= 1
            sums[number] += cost
            if not waiting[number]:
                for given in operators[number].gives - costs.keys():
                    heappush(queue, (sums[number], given))
    return sum(costs.get(fact, inf) for fact in problem.goal)
