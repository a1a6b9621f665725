"""What must hold of a day, by the truth of the house; written anew, without the functions of the policies."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from typing import Final

from tests.days.closed_rooms import closed_room_refusals
from tests.days.living import LivedDay
from tests.days.random_day import GRANTS, RandomDay
from tests.days.truth import TruthfulCommand, annoys, heats, is_off, is_on

from homebot.devices.command_messages import CommandResult
from homebot.devices.journal_messages import JournalEntry

_CLIENT: Final = "client:"
_LIMITED: Final = 10.0 - 1e-6
"""Seconds for which the rate limit of random days counts, but for what clocks round off."""

_QUIET_FROM: Final = 22
_QUIET_UNTIL: Final = 7


@dataclass(frozen=True, slots=True)
class Violation:
    """One violation of a policy.

    Attributes:
        policy: The name of the policy.
        what: What happened, in words.
    """

    policy: str
    what: str


def violations(day: RandomDay, lived: LivedDay) -> list[Violation]:
    """Return each violation of a policy by a command that reached its device, and each refusal for a wrong reason."""
    issuers = issuers_of(lived)
    found = [Violation("crash", one) for one in lived.crashed]
    for command in lived.commands:
        issuer = issuers.get(command.id, "")
        if not issuer:
            found.append(Violation("journal", f"nobody gave {command}"))
            continue
        found += [Violation(policy, f"{issuer}: {command}") for policy in _violated(command, issuer, day, lived)]
    found += [
        Violation("closed_room", f"nobody is there: {one}") for one in closed_room_refusals(day, lived) if one.is_wrong
    ]
    return found + [Violation("rate_limit", one) for one in _strobes(lived, day.control["rate_limit"]["changes"])]


def unseen(lived: LivedDay) -> list[TruthfulCommand]:
    """Return each command of an app that annoyed people whom no sensor told of: no policy can know of them."""
    issuers = issuers_of(lived)
    return [
        one
        for one in lived.commands
        if one.awake and annoys(one) and is_unseen(one, lived) and not is_wish(one, issuers)
    ]


def is_unseen(command: TruthfulCommand, lived: LivedDay) -> bool:
    """Return whether nobody can know of those who are awake where *command* arrives.

    A hand that switches the device in the same moment is known to who answers that, and to nobody else yet.
    """
    return command.is_unseen and not (command.is_switched and _answers_device(command, lived))


def _answers_device(command: TruthfulCommand, lived: LivedDay) -> bool:
    """Return whether *command* was given because of what its own device said."""
    return any(
        one.command == command.id and lived.names.get(one.trigger.device) == command.device for one in lived.entries
    )


def unseen_open(lived: LivedDay) -> list[TruthfulCommand]:
    """Return each command that heated while a window or door was open whose contact said that it is closed."""
    return [one for one in lived.commands if heats(one) and one.is_open and not one.is_told_open]


def issuers_of(lived: LivedDay) -> dict[str, str]:
    """Return who gave each command, by its id."""
    return {one.command: one.issuer for one in lived.entries if one.kind in {"requested", "published"}}


def is_wish(command: TruthfulCommand, issuers: Mapping[str, str]) -> bool:
    """Return whether a person gave *command*, at a client of the door."""
    return issuers.get(command.id, "").startswith(_CLIENT)


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


def _violated(command: TruthfulCommand, issuer: str, day: RandomDay, lived: LivedDay) -> Iterator[str]:
    """Yield the policies that *command* violates."""
    is_by_person = issuer.startswith(_CLIENT)
    if heats(command) and command.is_told_open:
        yield "interlock"
    if command.kind == "lock" and command.command == "unlock" and (is_by_person or not _is_granted("lock", issuer)):
        yield "rights"  # no client of these days has one that names a lock
    if is_by_person:
        return
    if command.awake and annoys(command) and not is_unseen(command, lived):
        yield "presence_guard"
    local = datetime.fromtimestamp(lived.midnight + command.at, UTC)
    is_quiet = day.control["quiet_hours"] and (local.hour >= _QUIET_FROM or local.hour < _QUIET_UNTIL)
    if is_quiet and (is_on(command) or command.kind == "thermostat"):
        yield "quiet_hours"
    if not _is_granted(command.kind, issuer):
        yield "grants"


def _is_granted(kind: str, issuer: str) -> bool:
    granted = GRANTS.get(issuer.removeprefix("/"), ())
    return not granted or {"lamp": "light", "lock": "door lock"}.get(kind) in granted


def _strobes(lived: LivedDay, changes: int) -> Iterator[str]:
    """Yield where a lamp was switched to and fro more often than it may be, whoever did it."""
    switched: dict[str, list[TruthfulCommand]] = {}
    for one in lived.commands:
        if is_on(one) or is_off(one):
            switched.setdefault(one.device, []).append(one)
    for device, own in switched.items():
        turns = [later.at for one, later in pairwise(own) if is_on(one) != is_on(later)]
        for number, at in enumerate(turns):
            within = sum(at - one < _LIMITED for one in turns[: number + 1])
            if within > changes:
                yield f"{device} was switched to and fro {within} times up to {at}"


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
    is_old = trigger.kind in {"report", "device"} and int(number) < min(
        lived.reports, default=math.inf
    )  # before anybody looked
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
