"""Difference between the commands of a recording and those of its replay, matched by content and time. Pure."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Literal

from homebot.devices.capabilities import MOMENTARY
from homebot.recording.recording import TimedCommand
from homebot.replay.command_matcher import ROUNDED, TOLERANCE, CommandMatcher, command_key, is_carried_out


@dataclass(frozen=True, slots=True)
class DifferentCommand:
    """A command that is only in the recording, or only in the replay.

    Attributes:
        kind: ``added``: only the replay has it; ``gone``: only the recording has it.
        refused: Why the other one refused it, as text; empty if the other does not have it.
    """

    kind: Literal["added", "gone"]
    given: TimedCommand
    refused: str = ""


@dataclass(frozen=True, slots=True)
class CommandDiff:
    """The differences between the commands of two runs.

    Attributes:
        different: The commands that differ, in order of time.
        same: The number of common commands; repeats within 1 s count once.
    """

    different: tuple[DifferentCommand, ...]
    same: int


def command_diff(
    recorded: Iterable[TimedCommand], replayed: Iterable[TimedCommand], issuers: Collection[str], ends_at: float
) -> CommandDiff:
    """Return the difference between the commands that *issuers* gave.

    Args:
        recorded: The commands of the recording, in the order of time.
        ends_at: The end of the recording, in seconds since its start. An unmatched command in its last second is not a
            difference: its counterpart may have come too late.
    """
    before = [command for command in recorded if command.command.issuer in issuers]
    now = [command for command in replayed if command.command.issuer in issuers]
    sent_before, repeated_before = _split_repeats(filter(is_carried_out, before))
    sent_now, repeated_now = _split_repeats(filter(is_carried_out, now))
    matcher = CommandMatcher(sent_before)
    added = [command for command in sent_now if matcher.pop(command) is None]
    gone = matcher.left
    different = [
        DifferentCommand("added", command, _refusal(command, before)) for command in _missing(added, repeated_before)
    ]
    different += [DifferentCommand("gone", command, _refusal(command, now)) for command in _missing(gone, repeated_now)]
    kept = sorted((difference for difference in different if difference.given.at <= ends_at - TOLERANCE), key=_order)
    return CommandDiff(tuple(kept), len(sent_before) - len(gone))


def _order(one: DifferentCommand) -> tuple[float, str, str, str]:
    command = one.given.command
    return round(one.given.at, 3), command.device, command.part, one.kind


def _refusal(given: TimedCommand, others: Iterable[TimedCommand]) -> str:
    """Return why the same command among *others* was refused; empty if there is none."""
    wanted = command_key(given.command)
    for other in others:
        is_same = abs(other.at - given.at) <= TOLERANCE and command_key(other.command) == wanted
        if is_same and other.result is not None and not is_carried_out(other):
            return f"{other.result.policy}: {other.result.reason}"
    return ""


def _missing(commands: Iterable[TimedCommand], repeats: Iterable[TimedCommand]) -> list[TimedCommand]:
    """Return the *commands* that are not among the other's *repeats* either: 0.99 s there may be 1.01 s here."""
    matcher = CommandMatcher(repeats)
    return [command for command in commands if matcher.pop(command) is None]


def _split_repeats(commands: Iterable[TimedCommand]) -> tuple[list[TimedCommand], list[TimedCommand]]:
    """Return *commands*, in order of time, and separately the repetitions by their app within 1 s.

    Their number depends on the load of the computer: a lamp may report the same three times while an app still reacts
    to the first report. Commands that act each time, such as a press, and raw texts do not count as repetitions.
    """
    kept: list[TimedCommand] = []
    repeats: list[TimedCommand] = []
    latest: dict[tuple[str, str, str], TimedCommand] = {}
    for timed in commands:
        command = timed.command
        place = command.issuer, command.device, command.part
        before = latest.get(place)
        is_repeatable = not command.text and not any(setting.capability in MOMENTARY for setting in command.settings)
        is_same = before is not None and command_key(before.command) == command_key(command)
        if before is not None and is_same and is_repeatable and timed.at <= before.at + TOLERANCE + ROUNDED:
            repeats.append(timed)
            continue
        latest[place] = timed
        kept.append(timed)
    return kept, repeats
