"""The fact that is in the way of a goal without a plan. Pure."""

from collections.abc import Iterable

from homebot.features.goals.operators import GoalProblem, Operator, reachable

_MAX_NAMED = 3


def why_not(problem: GoalProblem) -> str:
    """Return why there is no plan for *problem*, in words."""
    allowed = list(problem.allowed())
    known = reachable(problem.facts, allowed)
    if not (missing := [fact for fact in problem.goal if fact not in known]):
        return f"each wish can be reached, but not all at once: {' and '.join(_at_odds(problem, allowed))}"
    blocked = [
        operator for operator in problem.operators if operator.blocked and operator.gives and operator.step is not None
    ]
    for operator in blocked:
        if problem.goal.keys() <= reachable(known, [*allowed, *_like(operator, blocked)]):
            return _refusal(problem, operator)
    with_all = reachable(known, problem.operators)
    for fact in (*_enough(problem, known, allowed), *_enough(problem, with_all, problem.operators)):
        return f"{problem.contrary[fact]}, and nothing here can change that"
    reasons = [
        _refusal(problem, operator)
        for operator in blocked
        if operator.needs <= with_all and not operator.gives <= known
    ]
    hopeless = [problem.contrary[fact] for fact in missing if fact not in with_all]
    if hopeless:
        return f"{'; '.join(hopeless[:_MAX_NAMED])}, and nothing here can change that"
    return "; ".join(dict.fromkeys(reasons[:_MAX_NAMED]))


def _at_odds(problem: GoalProblem, operators: list[Operator]) -> Iterable[str]:
    """Return a wish, and another that each way to it undoes; all wishes if there is no such pair."""
    for fact in problem.goal:
        ways = [operator for operator in operators if fact in operator.gives]
        for other in problem.goal if ways else ():
            if all(other in operator.takes for operator in ways):
                return fact, other
    return problem.goal


def _enough(problem: GoalProblem, known: set[str], operators: list[Operator]) -> list[str]:
    """Return the facts beyond *known*, other than wishes, each of which makes the goal reachable by *operators*."""
    needed = {fact for operator in operators for fact in operator.needs if fact in problem.contrary}
    unknown = sorted(needed - known - problem.goal.keys())
    return [fact for fact in unknown if problem.goal.keys() <= reachable({*known, fact}, operators)]


def _like(blocked: Operator, others: list[Operator]) -> list[Operator]:
    """Return those of *others* that are blocked for the same place and reason: the drives of one robot, for example."""

    def where(one: Operator) -> tuple[str, str]:
        return one.step.place if one.step else "", one.blocked

    return [other for other in others if where(other) == where(blocked)]


def _refusal(problem: GoalProblem, blocked: Operator) -> str:
    facts = [problem.contrary[fact] for fact in sorted(blocked.gives - problem.facts) if fact in problem.contrary]
    now = f"{facts[0]}, and " if facts else ""
    return f"{now}{blocked.step.text if blocked.step else ''} is not possible: {blocked.blocked}"
