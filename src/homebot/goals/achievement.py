"""One goal on its way: plan, show, do each step, and plan anew when the house is not as it was planned."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

import anyio
from anyio import to_thread

from homebot.devices.achieve_messages import AchieveFeedback, AchieveRequest, AchieveResponse, PlannedStep
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.trigger import Trigger
from homebot.errors import HomebotError, ServiceError
from homebot.goals.house_now import Assumed, HouseReader
from homebot.goals.obstacles import why_not
from homebot.goals.operators import CommandStep, DriveStep, GoalProblem, Operator, Step, reachable
from homebot.goals.planner import plan
from homebot.goals.problem_builder import Preview, build_problem
from homebot.goals.wishes import RobotWish, Wish, read_wishes
from homebot.messages import Time
from homebot.routines.robot_drive import drive
from homebot.routines.steps import SendRobot

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome
    from homebot.graph import Client

__all__ = ["Achievement"]

_MOST_PLANS: Final = 4
"""The first plan, and three more."""

_LONGEST: Final = 900.0
_LOOK: Final = 1.0
"""Seconds after which a drive is checked against the doors again."""

_DONE: Final = "done"
DROVE: Final = "goals.drove"


@final
class Achievement:
    """A goal of a client.

    Args:
        run: Its id.
        fight: Returns the conflict of steps with another goal under way; empty if there is none.
        on_plan: Called with each plan, and after each step.

    Attributes:
        steps: The plan, with outcomes.
    """

    def __init__(
        self,
        reader: HouseReader,
        commands: Client[CommandRequest, Outcome],
        run: str,
        request: AchieveRequest,
        preview: Preview,
        fight: Callable[[Sequence[Step]], Awaitable[str]],
        on_plan: Callable[[AchieveFeedback], None],
    ) -> None:
        self._reader, self._commands, self._request = reader, commands, request
        self._node = reader.node
        self._preview, self._fight, self._on_plan = preview, fight, on_plan
        now = Time.from_seconds(self._node.graph.clock.now())
        self._trigger = Trigger(kind="goal", id=f"goal-{run}", text=request.goal[:200], at=now)
        self._wishes: tuple[Wish, ...] = ()
        self._blocked: dict[tuple[str, str], str] = {}
        self._assumed: Assumed = {}
        self._tried: list[str] = []
        self.steps: list[PlannedStep] = []
        self._claimed: dict[str, str] = {}

    async def run(self) -> AchieveResponse:
        """Reach the goal, or return the obstacle.

        Raises:
            HomebotError: The goal is not understood, or the house cannot be read.
        """
        self._wishes = read_wishes(self._request.goal, [one.name for one in (await self._reader.places()).rooms])
        for _ in range(_MOST_PLANS):
            problem = await self._problem()
            operators = await to_thread.run_sync(plan, problem, abandon_on_cancel=True)
            if operators is None or (problem.missing and not operators):
                return self._answer(f"cannot be reached: {why_not(problem)}")
            moves = _merged(operators)
            if against := await self._fight([one.step for one in moves]):
                return self._answer(f"has to wait: {against}")
            if (reached := await self._carry_out(moves)) is not None:
                return reached
        return self._answer(f"is not reached after {_MOST_PLANS} plans; the last one failed: {self._tried[-1]}")

    async def _carry_out(self, moves: Sequence[_Move]) -> AchieveResponse | None:
        """Do all steps, or only show them; return None if that did not reach the goal."""
        self._claimed = {one.step.place: one.step.text for one in moves}
        self.steps = [PlannedStep(text=one.step.text, asks=one.step.asks) for one in moves]
        self._show()
        is_so = "is reached" if moves or self._tried else "is so already"
        if self._request.is_dry_run:
            return self._answer("would be reached" if moves else is_so, is_reached=True)
        if trouble := await self._do(moves) or await self._left():
            self._tried.append(trouble)
            self._show()
            return None
        return self._answer(is_so, is_reached=True)

    async def undone_by(self, steps: Sequence[Step]) -> str:
        """Return the step or wish of this goal that *steps* of another one would undo; empty for none."""
        for step in steps:
            if (own := self._claimed.get(step.place, step.text)) != step.text:
                return own
        problem = await self._problem()
        known = {(one.step.place, one.step.text): one for one in problem.operators if one.step is not None}
        facts = frozenset(problem.facts)
        for step in steps:
            if (one := known.get((step.place, step.text))) is not None:
                facts = one.after(facts)
        kept = reachable(facts, (one for one in problem.operators if one.step is None))
        return next((one for one in problem.goal if one in problem.facts - kept), "")

    async def _problem(self) -> GoalProblem:
        robots = [(one.robot, one.room) for one in self._wishes if isinstance(one, RobotWish)]
        house = await self._reader.read(robots, self._assumed)
        request = self._request
        return build_problem(self._wishes, house, request.issuer, request.scope, self._preview, self._blocked)

    async def _left(self) -> str:
        """Return the first wish that is not so after all steps, in words; empty if there is none."""
        problem = await self._problem()
        return "".join(f"after all steps, {problem.contrary[one]}" for one in problem.missing[:1])

    async def _do(self, moves: Sequence[_Move]) -> str:
        """Do all steps; return the failure of one, empty if there is none."""
        for number, move in enumerate(moves):
            trouble = await self._lost(move.needs)
            if not trouble:
                outcome, is_done = await self._one(move)
                self.steps[number] = self.steps[number].model_copy(update={"outcome": outcome})
                self._show()
                trouble = "" if is_done else f"{move.step.text}: {outcome}"
            if trouble:
                return trouble
        return ""

    async def _lost(self, needs: frozenset[str]) -> str:
        """Return those of *needs* that are not so, in words."""
        problem = await self._problem()
        return "; ".join(problem.contrary.get(one, f"no longer: {one}") for one in sorted(needs - problem.facts))

    async def _one(self, move: _Move) -> tuple[str, bool]:
        """Do a step; return its outcome, and whether it was done. A failure by itself is not tried again."""
        step = move.step
        outcome, is_done = await (self._command(step) if isinstance(step, CommandStep) else self._drive(step, move))
        if not is_done and (isinstance(step, CommandStep) or not await self._lost(move.needs)):
            self._blocked[step.place, step.text] = outcome
        return outcome, is_done

    async def _command(self, step: CommandStep) -> tuple[str, bool]:
        request = CommandRequest(
            device=step.device.id,
            part=step.part.id,
            settings=(Setting.of(step.capability, step.value),),
            issuer=self._request.issuer,
            scope=self._request.scope,
            ask_first=bool(step.asks),
            cause=self._trigger.id,
            trigger=self._trigger,
        )
        try:
            outcome = await self._commands.call(request, timeout=_LONGEST, cancel_with_caller=True)
        except ServiceError as exc:
            return str(exc), False
        if outcome.succeeded:
            self._assumed.setdefault((step.device.id, step.part.id), {})[step.capability] = step.value
        return outcome.text, outcome.succeeded

    async def _drive(self, step: DriveStep, move: _Move) -> tuple[str, bool]:
        """Send the robot, and call it off when a door on its way is not as it was planned."""
        lost = ""

        async def watch() -> None:
            nonlocal lost
            while not lost:
                await anyio.sleep(_LOOK)
                lost = await self._lost(move.needs)
            tasks.cancel_scope.cancel()

        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(watch)
                try:
                    await drive(self._node, SendRobot(step.text, step.robot, step.room))
                except HomebotError as exc:
                    lost = lost or str(exc)
                tasks.cancel_scope.cancel()
        finally:
            self._node.log.info(DROVE, message=f"{step.text} for {self._request.goal!r}: {lost or _DONE}")
        return (lost, False) if lost else (_DONE, True)

    def _show(self) -> None:
        self._on_plan(AchieveFeedback(steps=tuple(self.steps), tried=tuple(self._tried)))

    def _answer(self, text: str, *, is_reached: bool = False) -> AchieveResponse:
        message = f"{self._request.goal!r} {text}"
        return AchieveResponse(success=is_reached, message=message, steps=tuple(self.steps), tried=tuple(self._tried))


@dataclass(frozen=True, slots=True)
class _Move:
    """A step with the facts that it needs until its end: doors on its way, but not the room where it begins."""

    step: Step
    needs: frozenset[str]


def _merged(operators: Sequence[Operator]) -> list[_Move]:
    """Return the steps of a plan, with one drive for several rooms in a row."""
    moves: list[_Move] = []
    for one in operators:
        if one.step is None:
            continue
        on_the_way = one.needs if isinstance(one.step, CommandStep) else one.needs - one.takes
        last = moves[-1] if moves else None
        if isinstance(one.step, DriveStep) and last is not None and last.step.place == one.step.place:
            moves[-1] = _Move(one.step, last.needs | on_the_way)
        else:
            moves.append(_Move(one.step, on_the_way))
    return moves
