"""Answers to the questions of agents and scripts, in as few words as an agent needs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from datetime import UTC, datetime
from http import HTTPStatus
from typing import TYPE_CHECKING, Final, cast

from homebot.bridges.home_api.device_search import HomeCalls, all_listed, listed, meant_device
from homebot.bridges.home_api.problem import ProblemError
from homebot.bridges.home_api.shapes import (
    CommandQuestion,
    DeviceDetails,
    DeviceLine,
    DeviceList,
    DeviceQuestion,
    HistoryAnswer,
    HistoryQuestion,
    HomeAnswer,
    ListQuestion,
    NoQuestion,
    OutcomeAnswer,
    PartOutcome,
    ShortValue,
    ValueSeries,
    WhyAnswer,
    WhyQuestion,
)
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.client_rights import CLIENT_RIGHTS
from homebot.devices.names import (
    COMMAND_DEVICES,
    EXPLAIN_DEVICE,
    EXPLAIN_MISSING_STATE,
    GET_UNAPPROVED,
    READ_HISTORY,
)
from homebot.devices.outcomes import Evidence
from homebot.devices.wording.history_words import chain_lines, chains_of, finding_text, result_text
from homebot.devices.wording.journal_words import clock_text, issuer_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import from_seconds, iso
from homebot.devices.wording.values import main_parts, span, state_text
from homebot.support.printable import printable
from homebot.units import parse_duration

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.approval_messages import UnapprovedResponse
    from homebot.devices.command_messages import CommandDevicesResponse
    from homebot.devices.history_messages import HistorySeries, ReadHistoryResponse
    from homebot.devices.journal_messages import ExplainDeviceResponse, ExplainMissingStateResponse
    from homebot.devices.services import ListedDevice
    from homebot.devices.value import Reading

__all__ = ["command", "device_details", "find_devices", "history", "home_in_short", "why"]

_SHORT: Final = {"on_off": "on"}
_MOST_STEPS: Final = 12
_MOST_NAMED: Final = 20
_WIDEST: Final = 100
_FLAGS: Final = {"true": True, "false": False}


async def home_in_short(home: HomeCalls, _: NoQuestion) -> HomeAnswer:
    """Return the rooms of the house, with the number of devices of each type."""
    devices = await all_listed(home)
    rooms: dict[str, Counter[str]] = {}
    for one in devices:
        rooms.setdefault(printable(one.room, _WIDEST) or "(no room)", Counter())[one.type] += 1
    return HomeAnswer(
        home=home.home,
        devices=len(devices),
        rooms={room: dict(rooms[room]) for room in sorted(rooms)},
        unreachable=tuple([one.id for one in devices if not one.is_reachable][:_MOST_NAMED]),
        waiting_for_approval=tuple([one.id for one in devices if one.waits][:_MOST_NAMED]),
    )


async def find_devices(home: HomeCalls, asked: ListQuestion) -> DeviceList:
    """Return the devices that fit a query, by id."""
    answer = await listed(home, query=asked.q, limit=asked.limit)
    if not answer.success:
        raise ProblemError(HTTPStatus.BAD_REQUEST, answer.message)
    devices = tuple(map(_line, answer.devices))
    return DeviceList(devices=devices, more=answer.total - len(devices))


async def device_details(home: HomeCalls, asked: DeviceQuestion) -> DeviceDetails:
    """Return one device, with what it takes."""
    device, _ = await meant_device(home, asked.id)
    answer = await listed(home, ids=[device.id])
    line = _line(answer.devices[0]).model_dump() if answer.devices else {"id": device.id, "type": device.service_type}
    return DeviceDetails(
        **line,
        state=state_text(device),
        takes=_takes(device),
        always_asks=await _why_it_asks(home, device.id),
        last_seen=iso(device.last_seen),
    )


async def command(home: HomeCalls, asked: CommandQuestion) -> OutcomeAnswer:
    """Command one device, and return the outcome.

    Raises:
        ProblemError: There is no such device, there are several, or the client has no right to it.
    """
    device, target = await meant_device(home, asked.device)
    found = await home.call(COMMAND_DEVICES, {"target": target, "command": asked.do})
    answer = cast("CommandDevicesResponse", found)
    if not answer.results:
        raise ProblemError(HTTPStatus.NOT_FOUND, answer.message)
    results = [one.result for one in answer.results]
    if denied := next((one for one in results if one.policy == CLIENT_RIGHTS), None):
        raise ProblemError(HTTPStatus.FORBIDDEN, denied.reason, CLIENT_RIGHTS)
    worst = next(one for one in results if one.outcome == answer.outcome)
    parts = [
        PartOutcome(part=one.part, outcome=one.result.outcome, text=one.result.text)
        for one in answer.results[: 0 if len(results) == 1 else None]
    ]
    return OutcomeAnswer(
        id=device.id,
        name=_shown(device.name),
        outcome=worst.outcome,
        text=worst.text,
        evidence=Evidence(worst.evidence).text if worst.evidence else "",
        policy=worst.policy,
        reason=worst.reason,
        command_id=worst.command_id,
        parts=tuple(parts),
    )


async def why(home: HomeCalls, asked: WhyQuestion) -> WhyAnswer:
    """Return why a device is as it is, or why it is not in a state."""
    device, _ = await meant_device(home, asked.id)
    if asked.state:
        return await _why_not(home, device, asked.state)
    found = cast("ExplainDeviceResponse", await _answered(home, EXPLAIN_DEVICE, {"device": device.id}))
    names, now = {device.id: device.name, **{one.key: one.value for one in found.names}}, home.now()
    steps = [" ".join(one).strip() for one in chain_lines(chains_of(found.entries), names, now)]
    return WhyAnswer(
        id=device.id,
        state=state_text(device),
        since=iso(found.changed_at) if found.changed_at.sec else "",
        why=finding_text(found, names, now),
        steps=tuple(steps[-_MOST_STEPS:]),
        more=max(0, len(steps) - _MOST_STEPS),
    )


async def history(home: HomeCalls, asked: HistoryQuestion) -> HistoryAnswer:
    """Return the values of a device over a time."""
    length = parse_duration(asked.since)
    if not home.offers(READ_HISTORY):
        problem = (
            "no history is kept, or it has not begun yet; `enabled = true` in [history] of homebot.toml begins one"
        )
        raise ProblemError(HTTPStatus.SERVICE_UNAVAILABLE, problem)
    device, _ = await meant_device(home, asked.device)
    since = from_seconds(max(0.0, home.now() - length))
    request = {"device": device.id, "capability": asked.capability, "since": since, "points": asked.points}
    found = cast("ReadHistoryResponse", await _answered(home, READ_HISTORY, request))
    return HistoryAnswer(id=device.id, series=tuple(map(_series, found.series)), more=found.left_out)


async def _why_not(home: HomeCalls, device: Device, state: str) -> WhyAnswer:
    request = {"device": device.id, "state": state}
    found = cast("ExplainMissingStateResponse", await _answered(home, EXPLAIN_MISSING_STATE, request))
    chains, now = chains_of(found.entries), home.now()
    asked = [f"{clock_text(one[0].at, now)} {issuer_text(one[0].issuer)}: {result_text(one, now)}" for one in chains]
    is_so = "it is so" if found.is_so else ""
    return WhyAnswer(
        id=device.id,
        state=state_text(device),
        why=is_so or found.problem or (asked[-1] if asked else "no command asked for that"),
        is_so=found.is_so,
        asked=tuple(asked[-_MOST_STEPS:]),
        more=max(0, len(asked) - _MOST_STEPS),
    )


def _line(device: ListedDevice) -> DeviceLine:
    often = Counter(one.capability for one in device.states)
    values = {_key(one, is_alone=often[one.capability] == 1): short_value(one.value) for one in device.states}
    return DeviceLine(
        id=device.id,
        type=device.type,
        room=printable(device.room, _WIDEST),
        name="" if device.id.endswith(device.name) else _shown(device.name),
        reachable=device.is_reachable,
        freshness=device.freshness,
        waits_for_approval=device.waits,
        **{name: value for name, value in values.items() if value is not None and name not in DeviceLine.model_fields},
    )


def _key(reading: Reading, *, is_alone: bool) -> str:
    name = _SHORT.get(reading.capability, reading.capability)
    return name if is_alone else f"{reading.part}.{name}"


def short_value(value: object) -> ShortValue | None:
    """Return *value*, as JSON has it, with two decimal places at most; None for an unknown one."""
    match value:
        case bool() | None:
            return value
        case int() | float():
            rounded = round(value, 2)
            return int(rounded) if rounded == int(rounded) else rounded
        case list():
            return [round(one, 2) for one in value]
    return printable(str(value), _WIDEST)


def _takes(device: Device) -> dict[str, str]:
    """Return the settable capabilities of the main parts, each with its values."""
    found: dict[str, str] = {}
    for part in main_parts(device):
        for one in part.part.capabilities:
            if one.settable:
                known = CAPABILITIES.get(one.name)
                found[one.name] = span(one) or ("on, off" if known is not None and known.kind == "bool" else "any")
    return found


async def _why_it_asks(home: HomeCalls, device: str) -> str:
    if not home.offers(GET_UNAPPROVED):  # not where nothing is controlled
        return ""
    answer = cast("UnapprovedResponse", await home.call(GET_UNAPPROVED, {"device": device}))
    return next((one.value for one in answer.reasons), "")


async def _answered(home: HomeCalls, service: str, request: Mapping[str, object]) -> JsonMessage:
    answer = await home.call(service, request)
    if not answer.success:
        raise ProblemError(HTTPStatus.BAD_REQUEST, str(answer.message))
    return answer


def _series(one: HistorySeries) -> ValueSeries:
    values = [_FLAGS.get(word, printable(word, _WIDEST)) for word in one.words] or map(short_value, one.values)
    times = (datetime.fromtimestamp(at, UTC).strftime("%Y-%m-%dT%H:%M:%SZ") for at in one.times)
    points = tuple((at, value) for at, value in zip(times, values, strict=True) if value is not None)
    return ValueSeries(capability=one.capability, part=one.part, unit=one.unit, width=one.width, points=points)


def _shown(name: str) -> str:
    return printable(name, _WIDEST)
