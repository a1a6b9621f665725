"""The message that carries the outcome of a command, and back."""

from __future__ import annotations

from dataclasses import fields
from typing import Final

from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.outcomes import OUTCOMES, Evidence, Outcome

__all__ = ["outcome_of", "result_of"]

_FIELDS: Final = {
    kind: tuple((one.name, kind.wire.get(one.name, one.name)) for one in fields(kind)) for kind in OUTCOMES.values()
}
"""The attributes of each outcome, with their fields on the wire."""


def result_of(outcome: Outcome, reported: tuple[Setting, ...] = ()) -> CommandResult:
    """Return the message that carries *outcome*, and the reported values of the device."""
    facts = {wire: getattr(outcome, name) for name, wire in _FIELDS[type(outcome)]}
    return CommandResult(outcome=outcome.kind, text=outcome.text, reported=reported, **facts).slimmed()


def outcome_of(result: CommandResult) -> Outcome:
    """Return the outcome that *result* carries."""
    kind = OUTCOMES[result.outcome]
    facts = {name: getattr(result, wire) for name, wire in _FIELDS[kind]}
    if "evidence" in facts:
        facts["evidence"] = Evidence(facts["evidence"])
    return kind(**facts)
