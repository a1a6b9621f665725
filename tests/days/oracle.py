"""What must hold of a day, by the truth of the house; written anew, without the functions of the policies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from itertools import pairwise
from typing import Final

from tests.days.living import LivedDay
from tests.days.random_day import GRANTS, RandomDay
from tests.days.truth import TruthfulCommand, is_off

from homebot.devices.command_messages import CommandResult
from homebot.devices.journal_messages import JournalEntry

__all__ = ["broken_chains", "is_wish", "violations"]

_DELIVERED_WITHIN: Final = 130.0
"""Seconds from when a command was sent to when it reaches the device at the latest."""

_SAME_MOMENT: Final = 0.01
_CLIENT: Final = "client:"


def violations(day: RandomDay, lived: LivedDay) -> list[str]:
    """Return each violation of a policy, in words."""
    sent = [one for one in lived.entries if one.kind in {"sent", "published"}]
    found = [f"{one} crashed" for one in lived.crashed]
    for command in lived.commands:
        issuers = _issuers(command, sent, lived)
        if not issuers:
            found.append(f"nobody sent {command}")
        elif all(one.startswith(_CLIENT) for one in issuers):
            found += _of_person(command)
        elif not any(one.startswith(_CLIENT) for one in issuers):
            found += _of_app(command, issuers, day, lived)
        if command.kind == "thermostat" and command.command == "25" and command.is_open:
            found.append(f"heated with a contact open: {command}")
    found += _strobes(lived.commands, day.control["rate_limit"]["changes"])
    found += _ungranted(sent, lived)
    return found


def broken_chains(lived: LivedDay) -> list[str]:
    """Return each command whose chain in the journal is not complete, in words."""
    chains: dict[str, list[JournalEntry]] = {}
    for one in lived.entries:
        if one.command:
            chains.setdefault(one.command, []).append(one)
    found: list[str] = []
    for name, chain in chains.items():
        for problem in _problems(chain, chains, lived):
            kinds = " ".join(one.kind for one in chain)
            found.append(f"{name} for {chain[0].device} ({kinds}): {problem}")
    return found


def is_wish(command: TruthfulCommand, lived: LivedDay) -> bool:
    """Return whether a person gave *command*, at a client of the door."""
    sent = [one for one in lived.entries if one.kind in {"sent", "published"}]
    issuers = _issuers(command, sent, lived)
    return bool(issuers) and all(one.startswith(_CLIENT) for one in issuers)


def _issuers(command: TruthfulCommand, sent: Iterable[JournalEntry], lived: LivedDay) -> set[str]:
    """Return who may have sent it: by the journal, in the time that a delivery takes."""
    at = lived.midnight + command.at
    return {
        one.issuer
        for one in sent
        if lived.names.get(one.device) == command.device
        and at - _DELIVERED_WITHIN <= one.at.to_seconds() <= at + _SAME_MOMENT
    }


def _of_person(command: TruthfulCommand) -> Iterator[str]:
    if command.kind == "lock" and command.command == "unlock":
        yield f"a client unlocked without a right that names it: {command}"


def _of_app(command: TruthfulCommand, issuers: set[str], day: RandomDay, lived: LivedDay) -> Iterator[str]:
    if command.awake and (is_off(command) or (command.kind == "cover" and command.command in {"0", "close"})):
        yield f"done over {command.awake} awake: {command} by {issuers}"
    if day.control["quiet_hours"]:
        local = datetime.fromtimestamp(lived.midnight + command.at, UTC)
        is_on = command.kind == "lamp" and command.command not in {"off", "0"} and not command.command.endswith("K")
        if (local.hour >= 22 or local.hour < 7) and (is_on or command.kind == "thermostat"):
            yield f"done in quiet hours: {command} by {issuers}"
    if command.kind == "lock" and command.command == "unlock" and "/lamps_only" in issuers and len(issuers) == 1:
        yield f"unlocked without a right: {command} by {issuers}"


def _strobes(commands: Sequence[TruthfulCommand], changes: int) -> Iterator[str]:
    """Yield where a lamp was switched to and fro more often than it may be within ten seconds."""
    by_device: dict[str, list[TruthfulCommand]] = {}
    for one in commands:
        if one.command in {"on", "off"}:
            by_device.setdefault(one.device, []).append(one)
    for device, own in by_device.items():
        turns = [later.at for one, later in pairwise(own) if one.command != later.command]
        for number, at in enumerate(turns):
            within = [one for one in turns[: number + 1] if at - one < 10.0 - _SAME_MOMENT]
            if len(within) > changes:
                yield f"{device} was switched to and fro {len(within)} times up to {at}"


def _ungranted(sent: Iterable[JournalEntry], lived: LivedDay) -> Iterator[str]:
    """Yield what an app sent to a device of a kind that it is not granted."""
    kinds = {one.device: one.kind for one in lived.commands}
    for one in sent:
        granted = GRANTS.get(one.issuer.removeprefix("/"), ())
        kind = kinds.get(lived.names.get(one.device, ""), "")
        if granted and kind and not _is_granted(kind, granted):
            yield f"{one.issuer} commanded the {kind} {one.device}"


def _is_granted(kind: str, granted: Iterable[str]) -> bool:
    return any(one in {"lamp": ("light",), "lock": ("door lock",)}.get(kind, ()) for one in granted)


def _problems(
    chain: Sequence[JournalEntry], chains: Mapping[str, Sequence[JournalEntry]], lived: LivedDay
) -> Iterator[str]:
    kinds = [one.kind for one in chain]
    first = chain[0]
    if kinds[0] not in {"requested", "published"}:
        yield "it does not begin with a request"
    if not first.issuer or any(one.issuer not in {first.issuer, ""} for one in chain):
        yield "its issuer is not known"
    if first.device not in lived.names:
        yield "its device is not known"
    times = [one.at.to_seconds() for one in chain if one.kind != "reported"]
    if times != sorted(times):
        yield "its times are not in order"
    yield from _dangling(first, lived)
    ends = [one for one in chain if one.kind in {"outcome", "published"}]
    if first.at.to_seconds() < lived.end and len(ends) != 1:
        yield f"it has {len(ends)} ends"
    if ends and ends[0].kind == "outcome":
        yield from _problems_of_outcome(chain, ends[0], chains)


def _dangling(first: JournalEntry, lived: LivedDay) -> Iterator[str]:
    """Yield a cause that nobody knows."""
    trigger = first.trigger
    kind, _, number = trigger.id.partition("-")
    is_old = trigger.kind in {"report", "device"} and int(number) < min(lived.reports)  # before anybody looked
    if trigger.kind in {"report", "device"} and not is_old and int(number) not in lived.reports:
        yield f"its cause {trigger.id} is not known"
    if trigger.kind and (kind != trigger.kind or (trigger.device and trigger.device not in lived.names)):
        yield f"its cause {trigger.id} is of a device that is not known"


def _problems_of_outcome(
    chain: Sequence[JournalEntry], end: JournalEntry, chains: Mapping[str, Sequence[JournalEntry]]
) -> Iterator[str]:
    kinds = [one.kind for one in chain]
    result = end.results[0]
    if set(kinds[kinds.index("outcome") + 1 :]) - {"reverted", "reported"}:
        yield "something else comes after its outcome"
    match result.outcome:
        case "confirmed" if "acknowledged" not in kinds or ("reported" in kinds) < (result.evidence >= 3):
            yield "it is confirmed by nothing"
        case "refused":
            yield from _problems_of_refusal(chain, result)
        case "superseded" if result.by not in chains:
            yield f"{result.by}, which took its place, is not known"
        case "contradicted" if "reported" not in kinds:
            yield "it is contradicted by nothing"
        case "no_answer" if "sent" not in kinds and not result.reason:
            yield "it was never sent"
        case _:
            return


def _problems_of_refusal(chain: Sequence[JournalEntry], result: CommandResult) -> Iterator[str]:
    verdicts = [one.verdicts[0] for one in chain if one.kind == "judged"]
    is_policy = result.policy not in {"rights", "lease", "gateway", "device", "control"}
    if is_policy and not any(one.policy == result.policy and not one.allowed for one in verdicts):
        yield f"{result.policy} gave no verdict"
    if not result.reason:
        yield "it is refused without a reason"
    if any(one.kind == "sent" for one in chain) and is_policy:
        yield "it was sent and refused"
