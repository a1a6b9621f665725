"""Applying a scene, and bringing back the values before it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from itertools import starmap
from typing import Final, final

from homebot.command_words.command_service import UNNAMED_CLIENT
from homebot.command_words.undo_record import known_states
from homebot.devices import DevicePart
from homebot.devices.batch import perform_all
from homebot.devices.client_rights import CLIENT
from homebot.devices.command_messages import (
    CommandDevicesResponse,
    CommandedPart,
    CommandRequest,
    CommandResult,
    PerformCommand,
    Setting,
)
from homebot.devices.device import target_of
from homebot.devices.names import PERFORM_COMMAND
from homebot.devices.outcomes import Gone, NoAnswer, Outcome, Refused
from homebot.devices.part import check_setting
from homebot.devices.scene_messages import ApplySceneRequest
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, ServiceError
from homebot.features.scenes.scene import HouseScenes, Place, Scene, place_of
from homebot.features.scenes.scene_book import SceneBook
from homebot.graph import Node
from homebot.messages.key_value import KeyValue

_MAX_WAIT_S: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""

_NOT_DONE: Final = frozenset({Refused.kind, Gone.kind, NoAnswer.kind})


@final
class SceneApplying:
    """Gives each part of a scene its command, by the control layer, as every other command."""

    def __init__(self, node: Node) -> None:
        self._node, self._clock = node, node.graph.clock
        self._perform = node.create_client(PerformCommand, PERFORM_COMMAND)

    async def apply(
        self,
        request: ApplySceneRequest,
        scene: Scene,
        house: HouseScenes,
        book: SceneBook,
        keep: Callable[[], Awaitable[object]],
    ) -> CommandDevicesResponse:
        """Apply *scene*, and note the values before it, which *keep* stores."""
        before, given_at = await known_states(self._node, house.devices.values()), self._clock.now()
        wanted: Mapping[Place, Mapping[str, PlainValue]] = scene.parts
        is_told = scene.recalled_by is None or (bool(wanted) and all(wanted.values()))
        if not is_told:
            wanted = {place_of(scene.id): {"scene": True}}
        earlier = book.begin(scene.id, given_at)
        known = dict(earlier.entries)
        earlier.add_parts(before, scene.parts)
        await keep()  # in case homebot ends before the outcomes are known
        answer = await self._command(request, scene, house, wanted)
        earlier.entries.clear()
        earlier.entries.update(known)
        if is_told:
            earlier.add(before, answer.results)
        elif answer.outcome != Refused.kind:
            earlier.add_parts(before, scene.parts, [result.result.command_id for result in answer.results])
        return answer

    async def undo(
        self, request: ApplySceneRequest, scene: Scene, house: HouseScenes, book: SceneBook
    ) -> CommandDevicesResponse:
        """Bring back the values before *scene*, where nothing else has changed them since.

        Parts that were not reached, or refused it, can be brought back by another undo.
        """
        applied = book.applied.get(scene.id)
        if applied is None or applied.is_undone:
            problem = f"there is nothing to undo: {scene.name} was not applied, or was undone since"
            return CommandDevicesResponse(success=False, message=problem)
        entries = dict(applied.before)
        earlier = book.begin(scene.id, applied.at)
        devices = [house.devices[device] for device in earlier.devices if device in house.devices]
        due = earlier.due(await known_states(self._node, devices, from_journal=True))
        applied.is_undone = True
        if not due:
            return CommandDevicesResponse(
                success=True, message=f"nothing that {scene.name} changed is left to bring back"
            )
        wanted = {
            place: {setting.capability: setting.value.plain() for setting in settings}
            for place, settings in due.items()
        }
        reasons = {house.name(place): house.why_asked(place, values) for place, values in wanted.items()}
        if request.unless_asks and (asks := {name: why for name, why in reasons.items() if why}):
            applied.before.update(entries)
            applied.is_undone = False
            listed = tuple(KeyValue(key=name, value=why) for name, why in asks.items())
            return CommandDevicesResponse(success=False, message="", asks=listed)
        answer = await self._command(request, scene, house, wanted)
        failed = {target_of(part.device, part.part) for part in answer.results if part.result.outcome in _NOT_DONE}
        left = {key: entry for key, entry in entries.items() if key.rpartition(" ")[0] in failed}
        if left:
            applied.before.update({**left, **applied.before})
            applied.is_undone = False
        return answer

    async def _command(
        self,
        request: ApplySceneRequest,
        scene: Scene,
        house: HouseScenes,
        values_of: Mapping[Place, Mapping[str, PlainValue]],
    ) -> CommandDevicesResponse:
        outcomes: dict[Place, Outcome] = {}
        requests: dict[Place, CommandRequest] = {}
        for place, values in values_of.items():
            device_and_part = house.place(place)
            if device_and_part is not None and (refused := _refusal(device_and_part[1], place, values)) is not None:
                outcomes[place] = refused
                continue
            agreed = request.agreed and request.issuer.startswith(CLIENT)
            is_recall = scene.recalled_by is not None and place == place_of(scene.id)
            judged = {place: values, **(scene.parts if is_recall else {})}
            asks = not agreed and any(starmap(house.why_asked, judged.items()))
            requests[place] = _request(request, scene, place, values, asks=asks)
        outcomes |= zip(requests, await perform_all(self._outcome, tuple(requests.values())), strict=True)
        lacking = () if request.undo else scene.problems.items()
        commanded = [_commanded(*place, house.name(place), outcome) for place, outcome in outcomes.items()]
        commanded += [_commanded("", "", name, Gone(problem)) for name, problem in lacking]
        if not commanded:
            return CommandDevicesResponse(success=False, message=f"{scene.name} has no part")
        return CommandDevicesResponse.of(commanded)

    async def _outcome(self, request: CommandRequest) -> Outcome:
        try:
            return await self._perform.call(request, timeout=_MAX_WAIT_S)
        except ServiceError as exc:
            return NoAnswer(0.0, str(exc))


def _commanded(device: str, part: str, name: str, outcome: Outcome) -> tuple[CommandedPart, Outcome]:
    return CommandedPart(device=device, name=name, part=part, result=CommandResult.of(outcome)), outcome


def _refusal(part: DevicePart, place: Place, values: Mapping[str, PlainValue]) -> Refused | None:
    """Return the refusal of values that the part does not take any more."""
    try:
        for capability, value in values.items():
            check_setting(target_of(*place), part.part, capability, value)
    except RefusedError as exc:
        return Refused("device", f"{exc.what}: {exc.reason}")
    return None


def _request(
    request: ApplySceneRequest, scene: Scene, place: Place, values: Mapping[str, PlainValue], *, asks: bool
) -> CommandRequest:
    return CommandRequest(
        device=place[0],
        part=place[1],
        settings=tuple(map(Setting.of, values, values.values())),
        transition=request.transition,
        issuer=request.issuer or UNNAMED_CLIENT,
        scope=request.scope,
        ask_first=request.ask_first or asks,
        cause=request.trigger.id,
        trigger=request.trigger.model_copy(update={"scene": scene.name, "is_undo": request.undo}),
    )
