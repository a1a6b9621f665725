"""Answers to the questions of agents and scripts, in as few words as an agent needs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from http import HTTPStatus
from itertools import pairwise
from typing import TYPE_CHECKING, Final, cast

import anyio

from homebot.bridges.home_api import shapes
from homebot.bridges.home_api.device_search import HomeCalls, all_listed, all_meant, listed, meant_device
from homebot.bridges.home_api.shapes import ProblemError
from homebot.devices import names
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.client_rights import CLIENT_RIGHTS
from homebot.devices.outcomes import OUTCOMES, Evidence
from homebot.devices.wording.journal_words import (
    caused_text,
    chain_lines,
    chains_of,
    clock_text,
    finding_text,
    issuer_text,
    name_text,
    repeats,
    result_text,
    was_obeyed,
)
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import from_seconds, iso
from homebot.devices.wording.values import main_parts, span, state_text
from homebot.support.folding import fold
from homebot.support.printable import printable
from homebot.units import parse_duration
from homebot.words.tokens import quoted

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.approval_messages import UnapprovedResponse
    from homebot.devices.command_messages import CommandDevicesResponse, CommandedPart
    from homebot.devices.journal_messages import ExplainDeviceResponse, ExplainMissingStateResponse, ReadJournalResponse
    from homebot.devices.services import ListedDevice

_MAX_STEPS: Final = 12
_MAX_NAMED: Final = 20
_STEPS: Final = frozenset({"sent", "acknowledged", "reported"})  # of a command whose outcome follows
_WIDEST: Final = 100
_FLAGS: Final = {"true": True, "false": False}
_BEST_FIRST: Final = tuple(OUTCOMES)


async def home_in_short(home: HomeCalls, _: shapes.NoQuestion) -> shapes.HomeAnswer:
    """Return the rooms of the house, with the number of devices of each type."""
    devices = await all_listed(home)
    rooms: dict[str, Counter[str]] = {}
    spelled: dict[str, str] = {}  # makers write a room differently
    for device in devices:
        room = spelled.setdefault(fold(device.room), printable(device.room, _WIDEST) or "(no room)")
        rooms.setdefault(room, Counter())[device.type] += 1
    return shapes.HomeAnswer(
        home=home.home,
        devices=len(devices),
        rooms={room: dict(rooms[room]) for room in sorted(rooms)},
        unreachable=tuple([device.id for device in devices if not device.is_reachable][:_MAX_NAMED]),
        waiting_for_approval=tuple([device.id for device in devices if device.waits][:_MAX_NAMED]),
    )


async def find_devices(home: HomeCalls, asked: shapes.ListQuestion) -> shapes.DeviceList:
    """Return the devices that fit a query, by id, or else those called so, by words that may mean something else."""
    answer = await listed(home, query=asked.q, limit=asked.limit)
    if answer.success and not answer.devices and 0 < len(asked.q) <= _WIDEST:
        named = await listed(home, query=f"name={quoted(asked.q)}", limit=asked.limit)
        answer = named if named.devices else answer
    if not answer.success:
        raise ProblemError(HTTPStatus.BAD_REQUEST, answer.message)
    devices = tuple(map(_line, answer.devices))
    note = answer.message or ("" if devices else "nothing matches; without a query all are listed")
    return shapes.DeviceList(devices=devices, more=answer.total - len(devices), note=note)


async def device_details(home: HomeCalls, asked: shapes.DeviceQuestion) -> shapes.DeviceDetails:
    """Return one device, with its commands; of ``all lights in hall`` the ids."""
    if ids := await all_meant(home, asked.id):
        return shapes.DeviceDetails(id=asked.id, type="", state=", ".join(ids), by_words=True)
    device, target = await meant_device(home, asked.id)
    answer = await listed(home, ids=[device.id])
    asks: tuple[str, ...] = ()
    if home.offers(names.GET_UNAPPROVED):  # not where nothing is controlled
        unapproved = await home.call(names.GET_UNAPPROVED, {"device": device.id})
        asks = tuple(reason.value for reason in cast("UnapprovedResponse", unapproved).reasons)
    return shapes.DeviceDetails(
        **(_line(answer.devices[0]).model_dump() if answer.devices else {"id": device.id, "type": ""}),
        state=state_text(device),
        takes=_takes(device),
        always_asks=asks[0] if asks else "",
        last_seen=iso(device.last_seen),
        by_words=target.partition("#")[0] != device.id,
    )


async def command(home: HomeCalls, asked: shapes.CommandQuestion) -> shapes.OutcomeAnswer:
    """Command one device or several at once, and return the outcome; nothing is sent if one of them is unknown.

    ``all lights in hall`` means no device that always asks, unless a person is asked first.
    """
    wanted = (asked.device,) if isinstance(asked.device, str) else asked.device
    meant: dict[str, Device | None] = {}  # by target; None for several devices
    for text in wanted:
        device, target = (None, text) if await all_meant(home, text) else await meant_device(home, text)
        meant[target] = device
    answers: list[shapes.OutcomeAnswer] = []
    problems: list[ProblemError] = []

    async def send(target: str, device: Device | None) -> None:
        ident = target if device is None else device.id
        unless_asks = device is None and not asked.ask
        try:
            request = {"target": target, "command": asked.do, "ask_first": asked.ask, "unless_asks": unless_asks}
            response = await home.call(names.COMMAND_DEVICES, request)
            answer = cast("CommandDevicesResponse", response)
            if not answer.results:
                raise ProblemError(HTTPStatus.FORBIDDEN if answer.asks else HTTPStatus.NOT_FOUND, answer.message)
            answers.append(
                outcome_of(answer, ident, lambda commanded: commanded.name if device is None else commanded.part)
            )
        except ProblemError as exc:
            problems.append(exc)
            answers.append(shapes.OutcomeAnswer(id=ident, outcome="refused", text=str(exc), reason=str(exc)))

    async with anyio.create_task_group() as tasks:
        for target, device in meant.items():
            tasks.start_soon(send, target, device)
    if len(problems) == len(answers):
        raise problems[0]
    worst = max(answers, key=lambda answer: _BEST_FIRST.index(answer.outcome))
    return worst if len(answers) == 1 else worst.model_copy(update={"devices": tuple(answers)})


def outcome_of(
    answer: CommandDevicesResponse, ident: str, name_of: Callable[[CommandedPart], str]
) -> shapes.OutcomeAnswer:
    """Return *answer* as that to a command to *ident*; a refusal of all for want of a right is a problem."""
    results = [result.result for result in answer.results]
    worst = next(result for result in results if result.outcome == answer.outcome)
    if all(result.policy == CLIENT_RIGHTS for result in results):
        raise ProblemError(HTTPStatus.FORBIDDEN, worst.reason)
    return shapes.OutcomeAnswer(
        id=ident,
        outcome=worst.outcome,
        text=worst.text,
        evidence=Evidence(worst.evidence).text if worst.evidence else "",
        policy=worst.policy,
        reason=worst.reason,
        command_id=worst.command_id,
        parts={name_of(result): result.result.text for result in answer.results} if len(results) > 1 else {},
    )


async def why(home: HomeCalls, asked: shapes.WhyQuestion) -> shapes.WhyAnswer:
    """Return why a device is as it is, or why it is not in a state."""
    device, _ = await meant_device(home, asked.id)
    now, since, is_so = home.now(), "", None
    if asked.state:
        request = {"device": device.id, "state": asked.state}
        wanted = cast("ExplainMissingStateResponse", await call_or_fail(home, names.EXPLAIN_MISSING_STATE, request))
        is_so, (reason, steps) = wanted.is_so, _why_not(wanted, now)
    else:
        response = cast("ExplainDeviceResponse", await call_or_fail(home, names.EXPLAIN_DEVICE, {"device": device.id}))
        named = {device.id: device.name, **{name.key: name.value for name in response.names}}
        steps = [" ".join(line).strip() for line in chain_lines(chains_of(response.entries), named, now)]
        reason = finding_text(response, named, now)
        since = iso(response.changed_at) if response.changed_at.sec else ""
    return shapes.WhyAnswer(
        id=device.id,
        state=state_text(device),
        since=since,
        why=reason,
        is_so=is_so,
        steps=tuple(steps[-_MAX_STEPS:]),
        more=max(0, len(steps) - _MAX_STEPS),
    )


async def journal(home: HomeCalls, asked: shapes.JournalQuestion) -> shapes.JournalAnswer:
    """Return the commands and the changes without a command, in words."""
    now = home.now()
    since = from_seconds(max(0.0, now - parse_duration(asked.since, "since")))
    device = (await meant_device(home, asked.device)).device.id if asked.device else ""
    request = {"device": device, "since": since, "limit": asked.limit}
    response = cast("ReadJournalResponse", await call_or_fail(home, names.READ_JOURNAL, request))
    named = {name.key: name.value for name in response.names}
    lines = [
        f"{clock_text(entry.at, now)} {name_text(entry.device, named, entry.part)}: {caused_text(entry, named)}"
        for before, entry in pairwise([None, *response.entries])
        if entry is not None and entry.kind not in _STEPS and not repeats(entry, before)
    ]
    return shapes.JournalAnswer(entries=tuple(lines), has_more=not response.complete)


def _why_not(wanted: ExplainMissingStateResponse, now: float) -> tuple[str, list[str]]:
    """Return why a device is not in a state, and the commands that asked for it."""
    if wanted.is_so:
        return "it is so; a question without a state has the reason", []
    chains = chains_of(wanted.entries)
    steps = [
        f"{clock_text(chain[0].at, now)} {issuer_text(chain[0].issuer)}: {result_text(chain, now)}" for chain in chains
    ]
    reason = wanted.problem or (steps[-1] if steps else "no command asked for that")
    if chains and was_obeyed(chains[-1]):
        reason += "; it changed after that: a question without a state has the reason"
    return reason, steps


async def call_or_fail(home: HomeCalls, service: str, request: Mapping[str, object]) -> JsonMessage:
    """Return the answer of *service*; a failure is a problem."""
    answer = await home.call(service, request)
    if not answer.success:
        raise ProblemError(HTTPStatus.BAD_REQUEST, str(answer.message))
    return answer


def _line(device: ListedDevice) -> shapes.DeviceLine:
    often = Counter(state.capability for state in device.states)
    values: dict[str, shapes.ShortValue] = {}
    for state in device.states:
        name = "on" if state.capability == "on_off" else state.capability
        value = short_value(state.value)
        if value is not None and name not in shapes.DeviceLine.model_fields:
            values[name if often[state.capability] == 1 else f"{state.part}.{name}"] = value
    return shapes.DeviceLine(
        id=device.id,
        type=device.type,
        room=printable(device.room, _WIDEST),
        name="" if device.id.endswith(device.name) else printable(device.name, _WIDEST),
        reachable=device.is_reachable,
        freshness=device.freshness,
        waits_for_approval=device.waits,
        **values,
    )


def short_value(value: object) -> shapes.ShortValue | None:
    """Return *value*, as JSON has it, with two decimal places at most; None for an unknown one."""
    match value:
        case bool() | None:
            return value
        case int() | float():
            return int(value) if value == int(value) else round(value, 2)
        case list():
            return [round(number, 2) for number in value]
    return printable(str(value), _WIDEST)


def _takes(device: Device) -> dict[str, str]:
    accepted: dict[str, str] = {}
    for capability in (
        capability for part in main_parts(device) for capability in part.part.capabilities if capability.settable
    ):
        accepted[capability.name] = span(capability) or (
            "on, off" if CAPABILITIES.get(capability.name, OWN).kind == "bool" else "any"
        )
    return accepted
