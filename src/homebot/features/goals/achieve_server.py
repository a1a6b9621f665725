"""The server of the action and the service that achieve goals. Loaded when used."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, MutableMapping, Sequence
from functools import partial
from itertools import count
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar, final

import anyio

from homebot.command_words.command_service import UNNAMED_CLIENT
from homebot.devices.command_messages import PerformCommand
from homebot.devices.names import PERFORM_COMMAND
from homebot.devices.wording.journal_words import issuer_text
from homebot.errors import HomebotError
from homebot.features.goals import ACHIEVE, ACHIEVE_WORDS, CUT_OFF_GOALS
from homebot.features.goals.achievement import Achievement
from homebot.features.goals.house_snapshot import HouseReader
from homebot.features.goals.messages import (
    Achieve,
    AchieveFeedback,
    AchieveGoal,
    AchieveRequest,
    AchieveResponse,
    AchieveResult,
    AchieveWords,
    PlannedStep,
)
from homebot.graph.actions import ActionServer, ServerGoal
from homebot.words.mistakes import mistake_in

if TYPE_CHECKING:
    from homebot.control import Control
    from homebot.devices import Device, DevicePart
    from homebot.devices.command_messages import CommandRequest
    from homebot.devices.outcomes import Refused
    from homebot.feature_context import FeatureContext
    from homebot.features.goals.achievement import Move
    from homebot.graph import Node

CUT_OFF = "goals.cut_off"

_MAX_DEVICES: Final = 200
_MAX_CHARACTERS: Final = 500

ToldT = TypeVar("ToldT", AchieveFeedback, AchieveResponse)
_Goal: TypeAlias = ServerGoal[AchieveGoal, AchieveResult, AchieveFeedback]


@final
class AchieveServer:
    """Achieves goals; one that is against another under way is refused.

    Args:
        language: That of its answers.
        control: Returns the control layer, whose rights and policies limit the plans.
        kept: Goals under way, by their runs; kept across restarts.
        flush: Writes them now.
    """

    def __init__(
        self,
        node: Node,
        language: str,
        control: Callable[[], Control | None],
        kept: MutableMapping[str, Any],
        flush: Callable[[], Awaitable[object]],
    ) -> None:
        self._node, self._control = node, control
        self._said = partial(mistake_in, language)
        self._kept, self._flush = kept, flush
        self._reader = HouseReader(node)
        self._commands = node.create_client(PerformCommand, PERFORM_COMMAND)
        self._numbers = count(1)
        self._claiming = anyio.Lock()
        self._under_way: dict[Achievement, str] = {}

    def serve(self, name: str) -> None:
        """Create the action or the service *name*."""
        if name == ACHIEVE.name:
            ActionServer(self._node, Achieve, name, self._execute)
        else:
            self._node.create_service(AchieveWords, ACHIEVE_WORDS.name, self._achieve_words)

    async def _achieve_words(self, request: AchieveRequest) -> AchieveResponse:
        return await self._achieve(self._new_run(), request, lambda _: None)

    def record_cut_off(self) -> None:
        """Say in the log and in the journal which goals the end of homebot cut off."""
        while self._kept:
            _, run = self._kept.popitem()
            text = f"{run['goal']} was cut off when homebot ended, {run['how_far']}"
            self._node.log.warning(CUT_OFF, message=text)
            self._record(run["devices"], run["issuer"], text)

    def _record(self, devices: Iterable[str], issuer: str, text: str) -> None:
        control = self._control()
        if control is not None:
            control.record_note(devices, issuer, text)

    def _new_run(self) -> str:
        return f"{next(self._numbers)}-{self._node.graph.clock.now():.0f}"

    def _preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        control = self._control()
        return None if control is None else control.preview(request, device, part)  # then nothing can be sent either

    async def _execute(self, goal: _Goal) -> AchieveResult:
        shown, run = AchieveFeedback(steps=()), self._new_run()

        def on_plan(feedback: AchieveFeedback) -> None:
            nonlocal shown
            shown = feedback
            goal.publish_feedback(feedback)

        try:
            response = await self._achieve(run, goal.request, on_plan)
        except anyio.get_cancelled_exc_class():
            if goal.is_cancel_requested:
                self._kept.pop(run, None)
                done = sum(bool(step.outcome) for step in shown.steps)
                message = f"cancelled; {done} of {len(shown.steps)} steps are done"
                goal.canceled(
                    AchieveResult(success=False, message=self._said(message), steps=shown.steps, tried=shown.tried)
                )
            raise
        (goal.succeed if response.success else goal.abort)()
        return AchieveResult(**dict(response))

    async def _achieve(
        self, run: str, asked: AchieveRequest, on_plan: Callable[[AchieveFeedback], None]
    ) -> AchieveResponse:
        request = asked.model_copy(update={"issuer": asked.issuer or UNNAMED_CLIENT})

        async def fight(moves: Sequence[Move]) -> str:
            async with self._claiming:  # of two at once, the second sees what the first has claimed
                for other, by in tuple(self._under_way.items()):
                    if other is not achievement and (undone := await other.undone_by(moves)):
                        return f"{by} is under way, and needs {undone}; ask again when it has ended, or cancel it"
                achievement.claim(moves)
                if moves:
                    self._under_way[achievement] = f"the goal {request.goal[:200]!r} of {issuer_text(request.issuer)}"
            return ""

        async def show(feedback: AchieveFeedback) -> None:
            on_plan(self._told(feedback))
            if achievement in self._under_way:
                before = self._kept.get(run, {"how_far": "before its first step", "devices": ()})
                done = [
                    f"after {step.text}: {step.outcome[:_MAX_CHARACTERS]}" for step in achievement.steps if step.outcome
                ]
                self._kept[run] = {
                    "goal": self._under_way[achievement],
                    "issuer": request.issuer,
                    "how_far": done[-1] if done else before["how_far"],
                    "devices": sorted(achievement.devices.union(before["devices"]))[:_MAX_DEVICES],
                }
                await self._flush()

        achievement = Achievement(self._reader, self._commands, run, request, self._preview, fight, show, self._record)
        try:
            answer = await achievement.run()
        except HomebotError as exc:
            answer = AchieveResponse(success=False, message=str(exc), steps=tuple(achievement.steps))
        finally:
            self._under_way.pop(achievement, None)
        if self._kept.pop(run, None) is not None:
            await self._flush()
        return self._told(answer).model_copy(update={"message": self._said(answer.message)})

    def _told(self, told: ToldT) -> ToldT:
        """Return the plan *told* in the language."""
        said = self._said
        steps = tuple(
            PlannedStep(text=said(step.text), asks=said(step.asks), outcome=said(step.outcome)) for step in told.steps
        )
        return told.model_copy(update={"steps": steps, "tried": tuple(map(said, told.tried))})


def start(node: Node, house: FeatureContext) -> AchieveServer:
    """Return the server; goals that the end of homebot cut off are recorded first."""
    server = AchieveServer(node, house.home.language, house.control, house.store(CUT_OFF_GOALS), house.write_stores)
    server.record_cut_off()
    return server
