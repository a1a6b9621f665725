"""Operators: possible changes of facts of the house. Facts are clauses such as ``front door is open``. Pure."""

from collections.abc import Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from homebot.devices.value import PlainValue

Settings: TypeAlias = tuple[tuple[str, PlainValue], ...]
"""Values by capability."""

PartSettings: TypeAlias = tuple[str, str, Settings]
"""Device, part and values."""


@dataclass(frozen=True, slots=True)
class PlanStep:
    """A command to a part, a scene, or a drive of a robot.

    Attributes:
        place: The part as ``DEVICE#PART``, the id of the scene, or the robot.
        parts: The parts that it sets; none for a scene with values that only its bridge knows. For a drive, the robot
            without values, if it is a device.
        asks: The reason to ask a person first; empty for none.
        room: The end of the drive, which may be the dock.
    """

    kind: Literal["command", "scene", "drive"]
    text: str
    place: str
    parts: tuple[PartSettings, ...] = ()
    asks: str = ""
    room: str = ""


@dataclass(frozen=True, slots=True)
class Operator:
    """A possible change.

    Attributes:
        needs: The facts without which it cannot be done.
        gives: The facts that hold afterwards.
        takes: The facts that hold no more.
        step: How it is done; None for a fact that follows from others.
        blocked: The reason against it; empty for none.
        is_unseen: Whether only its success tells the facts that it gives.
    """

    needs: frozenset[str]
    gives: frozenset[str]
    takes: frozenset[str] = frozenset()
    step: PlanStep | None = None
    blocked: str = ""
    is_unseen: bool = False

    def after(self, facts: AbstractSet[str]) -> frozenset[str]:
        """Return the *facts* that hold afterwards."""
        return frozenset(facts - self.takes | self.gives)


@dataclass(slots=True)
class GoalProblem:
    """The facts, the wished facts and the possible changes.

    Attributes:
        contrary: For each fact, the words for its absence.
    """

    facts: set[str] = field(default_factory=set)
    goal: dict[str, None] = field(default_factory=dict)
    operators: list[Operator] = field(default_factory=list)
    contrary: dict[str, str] = field(default_factory=dict)

    @property
    def missing(self) -> list[str]:
        """The wished facts that are not so."""
        return [fact for fact in self.goal if fact not in self.facts]

    def allowed(self) -> Iterator[Operator]:
        """Yield the operators that are not blocked."""
        return (operator for operator in self.operators if not operator.blocked)


def reachable(facts: Iterable[str], operators: Iterable[Operator]) -> set[str]:
    """Return all facts that can hold at some time, if nothing that is done undid another."""
    known, waiting = set(facts), list(operators)
    while True:
        ready = [operator for operator in waiting if operator.needs <= known]
        if not ready:
            return known
        waiting = [operator for operator in waiting if not operator.needs <= known]
        for operator in ready:
            known |= operator.gives


def is_plan(problem: GoalProblem, operators: Sequence[Operator]) -> bool:
    """Return whether *operators* in this order lead to the goal."""
    facts: AbstractSet[str] = problem.facts
    for operator in operators:
        if not operator.needs <= facts:
            return False
        facts = operator.after(facts)
    return problem.goal.keys() <= facts
