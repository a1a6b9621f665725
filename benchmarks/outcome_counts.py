"""What became of commands to lamps with faults, counted."""

from __future__ import annotations

from dataclasses import dataclass, field

from homebot.devices.outcomes import NoAnswer, Outcome

__all__ = ["FAULTS", "HEADINGS", "OutcomeCount", "row"]

FAULTS = {
    "none": "",
    "lossy, 20 %": "lossy = { share = 0.2 }",
    "slow, 5 to 7.5 s": "slow = {}",
    "deaf": "deaf = {}",
    "liar": "liar = {}",
    "stuck": "stuck = {}",
    "stuck, echoing": "stuck = {}, echoing_bridge = {}",
    "slow, echoing": "slow = {}, echoing_bridge = {}",
    "reverter, 5 s": "reverter = { after = 5.0 }",
}
"""The faults of a simulated lamp, as a house describes them."""

HEADINGS = (
    "fault",
    "commands",
    "silent, forgotten",
    "silent, homebot",
    "detected",
    "false alarms",
    "no answer, but so",
    "told after",
)


@dataclass
class OutcomeCount:
    """What became of the commands to lamps with one fault.

    Attributes:
        commands: How many there were.
        failed: Those that the lamp did not obey.
        silent: Those of them of which nothing said so.
        false_alarms: Commands after which the lamp was as wanted although something said that it was not.
        unanswered: Those after which it was as wanted and nothing came from it, which was said and is true.
        told_after: Seconds until each failure was told.
    """

    commands: int = 0
    failed: int = 0
    silent: int = 0
    false_alarms: int = 0
    unanswered: int = 0
    told_after: list[float] = field(default_factory=list)

    def note(
        self, outcome: Outcome | None, began: float, ended: float, reverted_at: float | None, *, obeyed: bool
    ) -> None:
        """Note a command: its outcome, None for one that was forgotten, and when it was reported as reverted."""
        self.commands += 1
        self.failed += not obeyed
        told = outcome is not None and (not outcome.succeeded or reverted_at is not None)
        self.silent += not obeyed and not told
        is_unanswered = isinstance(outcome, NoAnswer) and not outcome.reason
        self.unanswered += obeyed and is_unanswered
        self.false_alarms += obeyed and told and not is_unanswered
        if told and not obeyed:
            self.told_after.append((reverted_at or ended) - began)


def row(name: str, forgotten: OutcomeCount, told: OutcomeCount) -> tuple[str, ...]:
    """Return a row below :data:`HEADINGS`."""
    times = sorted(told.told_after)
    return (
        name,
        str(told.commands),
        f"{forgotten.silent / forgotten.commands:.1%}",
        f"{told.silent / told.commands:.1%}",
        f"{1 - told.silent / told.failed:.0%}" if told.failed else "-",
        str(told.false_alarms),
        str(told.unanswered),
        f"{times[len(times) // 2]:.1f} s" if times else "-",
    )
