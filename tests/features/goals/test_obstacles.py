"""The reason against a goal is the fact that is in its way."""

from homebot.features.goals.obstacles import why_not
from homebot.features.goals.operators import GoalProblem, Operator, PlanStep

DOOR = frozenset(("door is open",))


def behind_a_door(blocked: str = "") -> GoalProblem:
    """A robot in the hall is wished into the living room, behind a closed door with only a contact."""
    problem = GoalProblem(facts={"rosie in hall"}, goal={"rosie in living": None})
    problem.contrary = {"door is open": "the door is closed", "rosie in living": "rosie is in hall"}
    for here, there in (("hall", "living"), ("living", "hall")):
        step = PlanStep("drive", f"rosie drives to {there}", "rosie", room=there)
        at, then = frozenset((f"rosie in {here}",)), frozenset((f"rosie in {there}",))
        problem.operators.append(Operator(at | DOOR, then, at, step, blocked if there == "living" else ""))
    return problem


def test_a_closed_door_is_the_reason_also_after_a_drive_that_failed() -> None:
    for problem in (behind_a_door(), behind_a_door("the robot was stopped")):
        assert why_not(problem) == "the door is closed, and nothing here can change that"


def test_a_drive_that_failed_is_the_reason_if_no_door_is_in_the_way() -> None:
    problem = behind_a_door("the robot was stopped")
    problem.facts |= DOOR
    assert why_not(problem) == "rosie is in hall, and rosie drives to living is not possible: the robot was stopped"
