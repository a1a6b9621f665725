"""Candidates of an identification: parts with two levels that may change now."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from datetime import time
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, TypeAlias

from homebot.command_words.targets import CommandTargets, NoTargetError
from homebot.devices import Device, DevicePart, KeyValue
from homebot.devices.always_ask import why_it_asks
from homebot.devices.command_messages import CommandDevicesRequest, CommandRequest, Setting
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UsageError
from homebot.features.identify.messages import MAX_CANDIDATES, IdentifyDeviceGoal
from homebot.support.folding import fold
from homebot.words.queries import parse_query
from homebot.words.suitable_parts import part_name, settings_by_part
from homebot.words.times import TimeSpan

if TYPE_CHECKING:
    from homebot.devices.device_lookup import DeviceLookup
    from homebot.devices.outcomes import Refused
    from homebot.graph import Node

Preview: TypeAlias = Callable[[CommandRequest, Device, DevicePart], "Refused | None"]
"""Returns the refusal of a command by rights and policies, if it were given now."""

NIGHT: Final = (time(22), time(7))

_MIN_VALUES: Final = MappingProxyType({"level": 1.0, "position": 0.0, "fan_speed": 0.0})
"""Percent at least: of what has no switch; a dimmer at 0 may be off."""

_MAX_NAMED: Final = 8
_IN_BED: Final = "tag=bed occupied"
"""As in routines: the sensors that the owner tagged as those of a bed."""


@dataclass(eq=False)
class CandidatePart:
    """A part that changes between two levels.

    Attributes:
        dark: The lower value of *capability*.
        before: The value to put back.
        wanted: The value of the last command; *before* until the first one.
        set_at: The time of that command, in seconds since the Unix epoch; 0 for none.
        lease: The name of its lease; empty for none.
        problem: Why it takes part no more; empty if it does.
    """

    device: Device
    part: DevicePart
    capability: str
    dark: PlainValue
    bright: PlainValue
    before: PlainValue
    wanted: PlainValue = None
    set_at: float = 0.0
    lease: str = ""
    problem: str = ""

    @property
    def place(self) -> tuple[str, str]:
        """The ids of the device and the part."""
        return self.device.id, self.part.id

    @property
    def name(self) -> str:
        """Its name for people."""
        return part_name(self.device, self.part)

    @property
    def settles(self) -> float:
        """Seconds after its last report in which it changes further: a lamp fades, and a fan runs up."""
        return 0.8 if self.part.part.service_type == "light" else 3.0

    @property
    def transition(self) -> float:
        """Seconds of each change, in place of a fade that may go on for long after its report; 0 for no lamp."""
        return 0.1 if self.part.part.service_type == "light" else 0.0

    @staticmethod
    def level_of(value: PlainValue) -> float:
        """Return the level that is *value*, from 0 to 1."""
        return float(value) / (1 if isinstance(value, bool) else 100) if isinstance(value, int | float) else 0.0


def check_time(goal: IdentifyDeviceGoal, now: time, quiet: Iterable[tuple[time, time]]) -> None:
    """Refuse a *goal* at night and in *quiet* hours, unless it is for them.

    Raises:
        RefusedError: It is night.
    """
    for start, end in () if goal.at_night else (NIGHT, *quiet):
        if TimeSpan(start, end).has(now):
            reason = f"it is {now:%H:%M}, and people sleep from {start:%H:%M} to {end:%H:%M}"
            raise RefusedError("the identification", f"{reason}; `at_night` (`--night`) allows it")


async def check_beds(lookup: DeviceLookup, candidates: Iterable[CandidatePart]) -> None:
    """Refuse to change *candidates* further when a person went to bed beside one.

    Raises:
        RefusedError: A bed in the room of one is occupied.
    """
    asleep = await _rooms_asleep(lookup)
    for candidate in candidates:
        if fold(candidate.device.area) in asleep:
            raise RefusedError("the rest of the identification", f"somebody sleeps in {candidate.device.area} now")


async def find_candidates(
    node: Node, lookup: DeviceLookup, goal: IdentifyDeviceGoal, preview: Preview
) -> tuple[list[CandidatePart], tuple[KeyValue, ...]]:
    """Return the candidates of *goal*, and what is left out, with the reasons.

    Raises:
        UsageError: There is none, there are too many, or the query is wrong.
    """
    request = CommandDevicesRequest(target=goal.candidates, command="on", issuer=goal.issuer, scope=goal.scope)
    try:
        targets = await CommandTargets(node, lookup, lambda *_: "").find(request)
    except NoTargetError as exc:
        raise UsageError(str(exc)) from exc
    asleep = await _rooms_asleep(lookup)
    candidates, left_out = list[CandidatePart](), list[KeyValue]()
    for device, parts in targets:
        for part, _ in settings_by_part(request, device, parts):
            candidate = _candidate(device, part)
            if candidate is None:
                problem = "it has no two levels whose state is known"
            else:
                problem = _why_left_out(candidate, goal, asleep, preview)
            if candidate is not None and not problem:
                candidates.append(candidate)
            else:
                left_out.append(KeyValue(key=part_name(device, part), value=problem))
    count = len(candidates)
    if count == 0:
        reasons = "; ".join(f"{item.key}: {item.value}" for item in left_out[:_MAX_NAMED])
        raise UsageError(f"nothing of {goal.candidates!r} can be identified; {reasons}")
    if count > MAX_CANDIDATES:
        raise UsageError(f"{count} parts fit {goal.candidates!r}; at most {MAX_CANDIDATES} can be told apart")
    return candidates, tuple(left_out)


async def _rooms_asleep(lookup: DeviceLookup) -> set[str]:
    return {fold(device.area) for device in await lookup.devices(parse_query(_IN_BED)) if device.area}


def _candidate(device: Device, part: DevicePart) -> CandidatePart | None:
    settable = {capability.name: capability for capability in part.part.capabilities if capability.settable}
    values = {state.capability: state.value.plain() for state in device.states if state.part == part.id}
    if isinstance(before := values.get("on_off"), bool) and "on_off" in settable:
        return CandidatePart(device, part, "on_off", dark=False, bright=True, before=before, wanted=before)
    for name, least in _MIN_VALUES.items():
        if isinstance(before := values.get(name), float) and (capability := settable.get(name)) is not None:
            low, high = capability.bounds or (0.0, 100.0)
            dark = capability.nearest(max(low, least))
            return CandidatePart(device, part, name, dark=dark, bright=high, before=before, wanted=before)
    return None


def _why_left_out(candidate: CandidatePart, goal: IdentifyDeviceGoal, asleep: set[str], preview: Preview) -> str:
    device, part = candidate.device, candidate.part
    if part.part.is_group:
        return "it is a group"
    if reason := why_it_asks(device, part):
        return f"it always asks: {reason}"
    if device.reachable.state == "no" or device.freshness == "stale" or part.id in device.offline_parts:
        return "it cannot be reached"
    if fold(device.area) in asleep:
        return f"somebody sleeps in {device.area}"
    for value in (candidate.dark, candidate.bright):
        request = CommandRequest(
            device=device.id,
            part=part.id,
            settings=(Setting.of(candidate.capability, value),),
            issuer=goal.issuer,
            scope=goal.scope,
        )
        if (refused := preview(request, device, part)) is not None:
            return refused.reason
    return ""
