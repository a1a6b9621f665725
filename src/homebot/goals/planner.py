"""The planner: the only file that imports ``unified_planning``, which takes a second, with the first plan."""

from collections.abc import Sequence
from typing import Final

from homebot.goals.operators import GoalProblem, Operator, is_plan
from homebot.plugins import check_extra

__all__ = ["plan"]

_ENGINE: Final = "pyperplan"


def plan(problem: GoalProblem) -> list[Operator] | None:
    """Return operators that lead to the goal, without any that it does not need; None if there are none. Takes time.

    Raises:
        UsageError: The planner is not installed.
    """
    if not problem.missing:
        return []
    check_extra("a plan", "goals", "unified_planning", "up_pyperplan")
    operators = list(problem.allowed())
    found = [operators[number] for number in _solve(problem, operators)]
    if not is_plan(problem, found):
        return None
    for one in tuple(reversed(found)):  # a satisficing planner may do more than is needed
        fewer = [other for other in found if other is not one]
        if is_plan(problem, fewer):
            found = fewer
    return found


def _solve(problem: GoalProblem, operators: Sequence[Operator]) -> list[int]:
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
        found = planner.solve(task).plan
    return [] if found is None else [int(one.action.name[1:]) for one in found.actions]
