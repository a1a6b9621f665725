"""Difference between the commands of a recording and those of its replay. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Literal

from homebot.recording.recording import TimedCommand
from homebot.replay.command_matcher import TOLERANCE, CommandMatcher, is_carried_out, without_repeats

__all__ = ["CommandDiff", "DifferentCommand", "command_diff"]


@dataclass(frozen=True, slots=True)
class DifferentCommand:
    """A command that is only in the recording, or only in the replay.

    Attributes:
        kind: ``added``: only the replay has it; ``gone``: only the recording has it.
        given: The command.
        refused: Why the other of the two refused it, as text; empty where the other does not have it at all.
    """

    kind: Literal["added", "gone"]
    given: TimedCommand
    refused: str = ""


@dataclass(frozen=True, slots=True)
class CommandDiff:
    """The difference.

    Attributes:
        different: The commands that differ, in the order of time.
        same: The number of those that both have; repeats within 1 s count once.
    """

    different: tuple[DifferentCommand, ...]
    same: int


def command_diff(
    recorded: Iterable[TimedCommand], replayed: Iterable[TimedCommand], issuers: Collection[str], ends_at: float
) -> CommandDiff:
    """Return the difference between the commands that *issuers* gave.

    Args:
        recorded: The commands of the recording, in the order of time.
        replayed: Those of the replay, likewise.
        issuers: The full names of the nodes that are compared.
        ends_at: Where the recording ends, in seconds since its start. What is within 1 s before that and has no
            counterpart may have one that came too late, and is no difference.
    """
    before = [one for one in recorded if one.command.issuer in issuers]
    now = [one for one in replayed if one.command.issuer in issuers]
    sent_before = without_repeats(filter(is_carried_out, before))
    matcher = CommandMatcher(sent_before)
    added = [one for one in without_repeats(filter(is_carried_out, now)) if matcher.take(one) is None]
    gone = matcher.left
    different = [DifferentCommand("added", one, _refusal(one, before)) for one in added]
    different += [DifferentCommand("gone", one, _refusal(one, now)) for one in gone]
    kept = sorted((one for one in different if one.given.at <= ends_at - TOLERANCE), key=_order)
    return CommandDiff(tuple(kept), len(sent_before) - len(gone))


def _order(one: DifferentCommand) -> tuple[float, str, str, str]:
    command = one.given.command
    return round(one.given.at, 3), command.device, command.part, one.kind


def _refusal(given: TimedCommand, others: Iterable[TimedCommand]) -> str:
    """Return why the same command among *others* was refused; empty where there is none."""
    wanted = given.command
    for one in others:
        command = one.command
        is_near = abs(one.at - given.at) <= TOLERANCE
        is_same = (command.issuer, command.device, command.part, command.settings) == (
            *(wanted.issuer, wanted.device, wanted.part),
            wanted.settings,
        )
        if is_near and is_same and one.result is not None and not is_carried_out(one):
            return f"{one.result.policy}: {one.result.reason}"
    return ""
