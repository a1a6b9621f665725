"""The server of the action that identifies devices. Loaded when used."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from contextlib import closing
from datetime import UTC, datetime, time
from math import cos, hypot, sin
from random import Random
from typing import TYPE_CHECKING, Final, TypeAlias, final

import anyio

from homebot.clock import home_time
from homebot.command_words.command_service import UNNAMED_CLIENT
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import SEEN, TEACH_PLACE, WHERE_IS_ROBOT
from homebot.devices.places_messages import TeachPlace, TeachPlaceRequest
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.devices.wording.journal_words import issuer_text
from homebot.errors import HomebotError, ServiceError, UsageError
from homebot.features.identify import IDENTIFY_DEVICE, VALUES
from homebot.features.identify.candidates import CandidatePart, Preview, check_beds, check_time, find_candidates
from homebot.features.identify.identification import Identification
from homebot.features.identify.messages import (
    IdentifyDevice,
    IdentifyDeviceFeedback,
    IdentifyDeviceGoal,
    IdentifyDeviceResult,
)
from homebot.features.identify.saved_values import SavedValues
from homebot.features.identify.sight import open_sight
from homebot.graph import Node
from homebot.graph.actions import ActionServer, Preemption, ServerGoal
from homebot.support.folding import fold

if TYPE_CHECKING:
    from homebot.devices import Device, DevicePart
    from homebot.devices.command_messages import CommandRequest
    from homebot.devices.device import KeyValue
    from homebot.devices.outcomes import Refused
    from homebot.feature_context import FeatureContext
    from homebot.graph import Node


_ERROR: Final = 0.1
"""Metres by which a sighting may be wrong, and metres for each metre of distance."""

_TELLING: Final = 5.0
"""Seconds for which an identification waits until people are told."""

_PUTTING_BACK: Final = 5.0
"""Seconds for which the result waits until everything is back; what is not goes on coming back."""

_MAX_NAMED: Final = 8

IdentifyGoal: TypeAlias = ServerGoal[IdentifyDeviceGoal, IdentifyDeviceResult, IdentifyDeviceFeedback]


@final
class IdentifyServer:
    """Identifies one device after the other: two at once would disturb each other.

    Args:
        kept: Puts back the values before.
        preview: Returns the refusal of a command.
        notify: Tells people a message with a title.
        quiet: Returns the quiet hours.
    """

    def __init__(
        self,
        node: Node,
        kept: SavedValues,
        preview: Preview,
        notify: Callable[[str, str], Awaitable[object]],
        quiet: Callable[[], Iterable[tuple[time, time]]],
        random: Random,
    ) -> None:
        self._node = node
        self._lookup = DeviceLookup(node)
        self._kept = kept
        self._preview, self._notify, self._quiet, self._random = preview, notify, quiet, random
        ActionServer(node, IdentifyDevice, IDENTIFY_DEVICE.name, self._execute, preemption=Preemption.QUEUE)

    async def _execute(self, goal: IdentifyGoal) -> IdentifyDeviceResult:
        request = goal.request.model_copy(update={"issuer": goal.request.issuer or UNNAMED_CLIENT})
        run = f"{goal.goal_id.uuid.hex()} {self._node.graph.clock.now():.3f}"  # a client may use an id again
        try:
            result = await self._identify(goal, request, run)
        except HomebotError as exc:
            result = IdentifyDeviceResult(success=False, message=str(exc))
        except anyio.get_cancelled_exc_class():
            if goal.is_cancel_requested:
                message = f"cancelled; {self._kept.left(run) or 'everything is as before'}"
                goal.canceled(IdentifyDeviceResult(success=False, message=message))
            raise
        if left := self._kept.left(run):
            result = result.model_copy(update={"message": f"{result.message}; {left}"})
        (goal.succeed if result.success else goal.abort)()
        return result

    async def _identify(self, goal: IdentifyGoal, request: IdentifyDeviceGoal, run: str) -> IdentifyDeviceResult:
        check_time(request, self._local_time(), self._quiet())
        if request.robot:
            await check_robot(self._node, request.robot)
        candidates, left_out = await find_candidates(self._node, self._lookup, request, self._preview)

        async def check() -> None:
            check_time(request, self._local_time(), self._quiet())
            await check_beds(self._lookup, candidates)

        by = f"identify by {issuer_text(request.issuer).removeprefix('the client ')}"
        rooms = {fold(candidate.device.area) for candidate in candidates if candidate.device.area}
        with await open_sight(self._node, self._lookup, request.topic, request.region, rooms) as sight:
            identification = Identification(
                self._node,
                run,
                by,
                request,
                candidates,
                self._lookup,
                sight,
                self._kept,
                self._random,
                check,
                goal.publish_feedback,
            )
            with closing(identification):
                await identification.watch()  # a sensor that sees nothing is found before anything changes
                await self._announce(by, request, candidates)
                await self._kept.keep(run, by, request.issuer, request.scope, candidates)
                try:
                    is_sure, candidate = await identification.run()
                finally:
                    with anyio.move_on_after(_PUTTING_BACK, shield=True):
                        await identification.end()
        at, problem = "", ""
        if candidate is not None and request.robot and request.distance:
            at, problem = await save_seen_place(self._node, request, candidate.device.id)
        return _result(identification, candidate, left_out, is_sure=is_sure, at=at, problem=problem)

    async def _announce(self, by: str, request: IdentifyDeviceGoal, candidates: list[CandidatePart]) -> None:
        names = [candidate.name for candidate in candidates]
        more = f" and {len(names) - _MAX_NAMED} more" if len(names) > _MAX_NAMED else ""
        text = f"{by}: {', '.join(names[:_MAX_NAMED])}{more} change for up to {request.seconds:g} s, and are put back"
        with anyio.move_on_after(_TELLING):
            await self._notify(text, "Identify")

    def _local_time(self) -> time:
        local = home_time.get()
        now = datetime.fromtimestamp(self._node.graph.clock.now(), UTC) if local is None else local()
        return now.time()


def _result(
    identification: Identification,
    found: CandidatePart | None,
    left_out: tuple[KeyValue, ...],
    *,
    is_sure: bool,
    at: str,
    problem: str,
) -> IdentifyDeviceResult:
    states, none = identification.states(), identification.none
    best = max(states, key=lambda state: state.probability)
    if found is not None:
        message = f"{found.name} is in view{problem and f'; its position is not kept: {problem}'}"
    elif is_sure:
        message = f"{best.name} is not in view" if len(states) == 1 else "none of the candidates is in view"
        message += f": it does not change what is seen by {identification.largest:.3g}"
    else:
        likeliest = "none of them" if none > best.probability else best.name
        percent = 100 * max(none, best.probability)
        excluded = f"; none changes what is seen by {identification.largest:.3g}" if none > best.probability else ""
        advice = f"{likeliest}, by {percent:.0f} %{excluded}; look longer, come nearer, or give fewer candidates"
        message = f"not sure: {identification.trouble or advice}"
    if problems := "; ".join(
        f"{state.name} took no part to the end: {state.problem}" for state in states if state.problem
    ):
        message = f"{message}; {problems}"
    device, part = found.place if found is not None else ("", "")
    return IdentifyDeviceResult(
        success=is_sure,
        message=message,
        device=device,
        part=part,
        name="" if found is None else found.name,
        probability=max(none, best.probability),
        none=none,
        at=at,
        candidates=states,
        looks=tuple(identification.looks),
        left_out=left_out,
    )


@final
class IdentifyStarter:
    """Puts back what a killed homebot left, and starts the server with the first goal."""

    def __init__(self, node: Node, house: FeatureContext) -> None:
        self._node, self._house = node, house
        self._kept = SavedValues(node, DeviceLookup(node), house.store(VALUES), house.write_stores, house.began_at)
        node.create_task(self._kept.run)

    def serve(self, _: str) -> None:
        """Create the server."""

        async def tell(message: str, title: str) -> None:
            await self._house.notify(message, title, self._node.full_name)

        IdentifyServer(self._node, self._kept, self._preview, tell, self._quiet_hours, self._house.random)

    def _preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        control = self._house.control()
        return None if control is None else control.preview(request, device, part)  # then nothing can be held either

    def _quiet_hours(self) -> tuple[tuple[time, time], ...]:
        control = self._house.control()
        return () if control is None else control.quiet_hours()


async def check_robot(node: Node, robot: str) -> None:
    """Check the name of a *robot*.

    Raises:
        UsageError: Other robots have said where they are, but there is none of that name.
    """
    with closing(node.create_client(WhereIsRobot, WHERE_IS_ROBOT)) as where:
        if where.service_is_ready() and (answer := await where.call(WhereIsRobotRequest(robot=robot))).is_mistake:
            raise UsageError(answer.message)


async def save_seen_place(node: Node, goal: IdentifyDeviceGoal, device: str) -> tuple[str, str]:
    """Keep the position of *device*, seen in the direction and distance of *goal*; return it, and the problem if any.

    It counts only if neither the owner nor the device states one.
    """
    with (
        closing(node.create_client(WhereIsRobot, WHERE_IS_ROBOT)) as where,
        closing(node.create_client(TeachPlace, TEACH_PLACE)) as teach,
    ):
        try:
            answer = await where.call(WhereIsRobotRequest(robot=goal.robot))
            if not answer.success or not answer.pose or not answer.pose[0].has_position:
                return "", answer.message or f"the position of {goal.robot} is unknown"
            pose = answer.pose[0]
            x, y = (
                start + goal.distance * turn(pose.yaw + goal.bearing) for start, turn in ((pose.x, cos), (pose.y, sin))
            )
            floor, error = f",{pose.floor}" if pose.floor else "", hypot(pose.error, _ERROR * (1 + goal.distance))
            at = f"{x:.2f},{y:.2f}{floor} ±{error:.2f} m"
            taught = await teach.call(TeachPlaceRequest(device=device, gateway=SEEN, at=at))
        except ServiceError as exc:
            return "", str(exc)
    return (at, "") if taught.success else ("", taught.message)
