"""The message that carries the outcome of a command, and back."""

from __future__ import annotations

from typing import Any, Final

from homebot.devices import outcomes
from homebot.devices.command_messages import CommandResult, OutcomeKind, Setting
from homebot.devices.outcomes import Evidence, Outcome

__all__ = ["outcome_of", "result_of"]

_GRADES: Final = {int(grade): grade for grade in Evidence}


def result_of(outcome: Outcome, reported: tuple[Setting, ...] = ()) -> CommandResult:
    """Return the message that carries *outcome*, and the reported values of the device."""
    kind: OutcomeKind = "gone"
    facts: dict[str, Any] = {}
    match outcome:
        case outcomes.Confirmed(latency, evidence, witness):
            kind, facts = "confirmed", {"latency": latency, "evidence": int(evidence), "witness": witness}
        case outcomes.AlreadySo():
            kind = "already_so"
        case outcomes.Contradicted(saw, witness):
            kind, facts = "contradicted", {"saw": saw, "witness": witness}
        case outcomes.Reverted(after, cause):
            kind, facts = "reverted", {"latency": after, "reason": cause}
        case outcomes.NoAnswer(waited, reason):
            kind, facts = "no_answer", {"latency": waited, "reason": reason}
        case outcomes.Superseded(by):
            kind, facts = "superseded", {"by": by}
        case outcomes.Refused(policy, reason):
            kind, facts = "refused", {"policy": policy, "reason": reason}
    return CommandResult(command_id=outcome.command_id, outcome=kind, text=outcome.text, reported=reported, **facts)


def outcome_of(result: CommandResult) -> Outcome:
    """Return the outcome that *result* carries."""
    name = result.command_id
    match result.outcome:
        case "confirmed":
            return outcomes.Confirmed(result.latency, _GRADES[result.evidence], result.witness, command_id=name)
        case "already_so":
            return outcomes.AlreadySo(command_id=name)
        case "contradicted":
            return outcomes.Contradicted(result.saw, result.witness, command_id=name)
        case "reverted":
            return outcomes.Reverted(result.latency, result.reason or "unknown", command_id=name)
        case "no_answer":
            return outcomes.NoAnswer(result.latency, result.reason, command_id=name)
        case "superseded":
            return outcomes.Superseded(result.by, command_id=name)
        case "refused":
            return outcomes.Refused(result.policy, result.reason, command_id=name)
        case "gone":
            return outcomes.Gone(command_id=name)
