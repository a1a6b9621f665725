"""One goal on its way: plan, show, do each step, and plan anew when the house is not as it was planned."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

import anyio

from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.names import APPLY_SCENE
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest
from homebot.devices.trigger import Trigger
from homebot.errors import GoalAbortedError, HomebotError
from homebot.features.goals.house_snapshot import Assumed, HouseReader, HouseSnapshot
from homebot.features.goals.meanings import ParsedGoal, parse_goal
from homebot.features.goals.messages import AchieveFeedback, AchieveRequest, AchieveResponse, PlannedStep
from homebot.features.goals.obstacles import why_not
from homebot.features.goals.operators import GoalProblem, PlanStep
from homebot.features.goals.planner import find_plan
from homebot.features.goals.problem_builder import GoalClient, Preview, build_problem
from homebot.messages import Time
from homebot.robots.drive import drive
from homebot.words.steps import SendRobot

if TYPE_CHECKING:
    from homebot.devices.outcomes import Outcome
    from homebot.graph import Client

_MAX_PLANS: Final = 4
"""The first plan, and three more."""

_MAX_WAIT_S: Final = 900.0
_LOOK: Final = 1.0
"""Seconds after which the facts that a step needs are read again, such as the doors on a robot's way."""

_LAG: Final = 5.0
"""Seconds after the last step in which a robot still says where it is."""

_DONE: Final = "done"
DROVE: Final = "goals.drove"


@final
class Achievement:
    """A goal of a client.

    Args:
        run: Its id.
        fight: Returns the conflict of a plan with another goal under way; without one, claims it, and returns nothing.
        on_plan: Called with each plan, and after each step.
        record: Records what was done with devices, for an issuer, in the journal.

    Attributes:
        steps: Those done, also of earlier plans, and the last plan, with outcomes.
    """

    def __init__(
        self,
        reader: HouseReader,
        commands: Client[CommandRequest, Outcome],
        run: str,
        request: AchieveRequest,
        preview: Preview,
        fight: Callable[[Sequence[Move]], Awaitable[str]],
        on_plan: Callable[[AchieveFeedback], Awaitable[None]],
        record: Callable[[Iterable[str], str, str], None],
    ) -> None:
        self._reader, self._commands, self._request = reader, commands, request
        self._node = reader.node
        self._fight, self._on_plan, self._record = fight, on_plan, record
        now = Time.from_seconds(self._node.graph.clock.now())
        self._trigger = Trigger(kind="goal", id=f"goal-{run}", text=request.goal[:200], at=now)
        self._goal = ParsedGoal()
        self._blocked: dict[tuple[str, str], str] = {}
        self._asker = GoalClient(request.issuer, request.scope, preview, self._blocked)
        self._assumed: Assumed = {}
        self._unseen: set[str] = set()
        self._tried: list[str] = []
        self._moves: Sequence[Move] = ()
        self._done: list[PlannedStep] = []
        self._first = 0
        self.steps: list[PlannedStep] = []

    async def run(self) -> AchieveResponse:
        """Reach the goal, or return the obstacle.

        Raises:
            HomebotError: The goal is not parse_goal, or the house cannot be read.
        """
        self._goal = await parse_goal(self._request.goal, self._reader)
        for _ in range(_MAX_PLANS):
            problem = build_problem(self._goal, await self._house(), self._unseen, self._asker)
            operators = await find_plan(problem)
            if operators is None or (problem.missing and not operators):
                return self._answer(f"cannot be reached: {why_not(problem)}")
            moves: list[Move] = []
            for operator in operators:
                if operator.step is None:
                    continue
                is_drive = operator.step.kind == "drive"
                needs = operator.needs - operator.takes if is_drive else operator.needs
                if is_drive and moves and moves[-1].step.place == operator.step.place:
                    needs |= moves.pop().needs
                moves.append(Move(operator.step, needs, operator.gives if operator.is_unseen else frozenset()))
            if self._request.is_dry_run:
                self.claim(moves)
            elif against := await self._fight(moves):
                return self._answer(f"has to wait: {against}")
            if (reached := await self._carry_out(moves)) is not None:
                return reached
        return self._answer(f"is not reached after {_MAX_PLANS} plans; the last one failed: {self._tried[-1]}")

    @property
    def devices(self) -> set[str]:
        """The ids of the devices of the plan."""
        return {device for move in self._moves for device, *_ in move.step.parts}

    def claim(self, moves: Sequence[Move]) -> None:
        """Take *moves* as the plan."""
        self._moves = moves
        self._first = len(self._done)
        self.steps = [*self._done, *(PlannedStep(text=move.step.text, asks=move.step.asks) for move in moves)]

    async def _carry_out(self, moves: Sequence[Move]) -> AchieveResponse | None:
        """Do all steps, or only show them; return None if that did not reach the goal."""
        await self._show()
        is_so = "is reached" if moves or self._tried else "is so already"
        if self._request.is_dry_run:
            return self._answer("would be reached" if moves else is_so, is_reached=True)
        if trouble := await self._do(moves) or await self._left():
            self._tried.append(trouble)
            await self._show()
            return None
        return self._answer(is_so, is_reached=True)

    async def undone_by(self, moves: Sequence[Move]) -> str:
        """Return the fact of this goal that *moves* of another one would undo, now or after its own; empty for none."""
        house = await self._house()
        own = self._moves[sum(bool(step.outcome) for step in self.steps[self._first :]) :]
        after = house.after(move.step for move in own)
        robots = {move.step.place for move in own if move.step.kind == "drive"}
        if shared := robots.intersection(move.step.place for move in moves):
            return f"{min(shared)} for itself"
        kept = self._facts(after.after(move.step for move in moves))
        lost = self._facts(after).facts - kept.facts
        wanted = kept.goal.keys() | frozenset[str]().union(*(move.needs for move in own))
        return next((repr(fact) for fact in sorted(wanted & lost)), "")

    async def _house(self) -> HouseSnapshot:
        return await self._reader.read([(wish.robot, wish.room) for wish in self._goal.drives], self._assumed)

    def _facts(self, house: HouseSnapshot) -> GoalProblem:
        return build_problem(self._goal, house, self._unseen)

    async def _left(self) -> str:
        """Return the first wish that is not so after all steps, in words; empty if there is none."""
        problem = self._facts(await self._house())
        with anyio.move_on_after(_LAG):
            while self._goal.drives and problem.missing:
                await anyio.sleep(_LOOK)
                problem = self._facts(await self._house())
        return "".join(f"after all steps, {problem.contrary[fact]}" for fact in problem.missing[:1])

    async def _do(self, moves: Sequence[Move]) -> str:
        """Do all steps; return the failure of one, empty if there is none."""
        for number, move in enumerate(moves, self._first):
            trouble = await self._lost(move.needs)
            if not trouble:
                outcome, is_done = await self._one(move)
                self.steps[number] = self.steps[number].model_copy(update={"outcome": outcome})
                if is_done:
                    self._done.append(self.steps[number])
                await self._show()
                trouble = "" if is_done else f"{move.step.text}: {outcome}"
            if trouble:
                return trouble
        return ""

    async def _lost(self, needs: frozenset[str]) -> str:
        """Return those of *needs* that are not so, in words."""
        problem = self._facts(await self._house())
        return "; ".join(problem.contrary.get(fact, f"no longer: {fact}") for fact in sorted(needs - problem.facts))

    async def _one(self, move: Move) -> tuple[str, bool]:
        """Do a step, unless a fact that it needs is lost meanwhile; return its outcome, and whether it was done.

        A failure by itself is not tried again, but for an aborted drive, once.
        """
        step, lost, outcome, is_done = move.step, "", "called off", False

        async def watch() -> None:
            nonlocal lost
            while not lost:
                await anyio.sleep(_LOOK)
                lost = await self._lost(move.needs)
            tasks.cancel_scope.cancel()

        try:
            async with anyio.create_task_group() as tasks:
                if move.needs:
                    tasks.start_soon(watch)
                outcome, is_done = await self._perform(step)
                tasks.cancel_scope.cancel()
            outcome = outcome if is_done else lost or outcome
        finally:
            if step.kind == "drive":
                text = f"{step.text} for {self._request.goal[:200]!r}: {outcome}"
                self._node.log.info(DROVE, message=text)
                self._record([device for device, *_ in step.parts], self._request.issuer, text)
        if is_done:
            for device, part, settings in step.parts:
                self._assumed.setdefault((device, part), {}).update(settings)
            self._unseen |= move.unseen
        elif not (lost or await self._lost(move.needs)):
            self._blocked[step.place, step.text] = outcome
        return outcome, is_done

    async def _perform(self, step: PlanStep) -> tuple[str, bool]:
        issuer, scope = self._request.issuer, self._request.scope
        try:
            if step.kind == "drive":
                move = SendRobot(step.text, step.place, step.room)
                try:
                    await drive(self._node, move)
                except GoalAbortedError:  # as by another command to the robot
                    await drive(self._node, move)
                return _DONE, True
            if step.kind == "scene":
                with closing(self._node.create_client(ApplyScene, APPLY_SCENE)) as client:
                    asked = ApplySceneRequest(name=step.place, issuer=issuer, scope=scope, trigger=self._trigger)
                    answer = await client.call(asked, timeout=_MAX_WAIT_S, cancel_with_caller=True)
                return answer.message or _DONE, answer.success
            ((device, part, settings),) = step.parts
            request = CommandRequest(
                device=device,
                part=part,
                settings=tuple(Setting.of(*pair) for pair in settings),
                issuer=issuer,
                scope=scope,
                ask_first=bool(step.asks),
                cause=self._trigger.id,
                trigger=self._trigger,
            )
            outcome = await self._commands.call(request, timeout=_MAX_WAIT_S, cancel_with_caller=True)
        except HomebotError as exc:
            return str(exc), False
        return outcome.text, outcome.succeeded

    async def _show(self) -> None:
        await self._on_plan(AchieveFeedback(steps=tuple(self.steps), tried=tuple(self._tried)))

    def _answer(self, text: str, *, is_reached: bool = False) -> AchieveResponse:
        message = f"{self._request.goal!r} {text}"
        return AchieveResponse(success=is_reached, message=message, steps=tuple(self.steps), tried=tuple(self._tried))


@dataclass(frozen=True, slots=True)
class Move:
    """A step with the facts that it needs until its end: doors on its way, but not the room where it begins.

    Attributes:
        unseen: The facts that hold afterwards, and that only the step tells.
    """

    step: PlanStep
    needs: frozenset[str]
    unseen: frozenset[str] = frozenset()
