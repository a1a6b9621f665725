"""The message that carries the outcome of a command, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from homebot.devices import outcomes
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.outcomes import Evidence, Outcome

__all__ = ["outcome_of", "result_of"]

_NO_FACTS: Final[Mapping[str, object]] = {
    "latency": 0.0,
    "evidence": 0,
    "saw": "",
    "witness": "",
    "by": "",
    "policy": "",
    "reason": "",
}
"""Defaults of the fields that belong to another outcome."""

_GRADES: Final = {int(grade): grade for grade in Evidence}


def result_of(outcome: Outcome, reported: tuple[Setting, ...] = ()) -> CommandResult:
    """Return the message that carries *outcome*, and the reported values of the device."""
    fields: dict[str, Any] = {  # in the order in which programs are shown them
        "command_id": outcome.command_id,
        "outcome": "gone",
        "text": outcome.text,
        "reported": reported,
        **_NO_FACTS,
    }
    match outcome:
        case outcomes.Confirmed():
            fields |= {
                "outcome": "confirmed",
                "latency": outcome.latency,
                "evidence": int(outcome.evidence),
                "witness": outcome.witness,
            }
        case outcomes.AlreadySo():
            fields["outcome"] = "already_so"
        case outcomes.Contradicted():
            fields |= {"outcome": "contradicted", "saw": outcome.saw, "witness": outcome.witness}
        case outcomes.Reverted():
            fields |= {"outcome": "reverted", "latency": outcome.after, "reason": outcome.cause}
        case outcomes.NoAnswer():
            fields |= {"outcome": "no_answer", "latency": outcome.waited, "reason": outcome.reason}
        case outcomes.Superseded():
            fields |= {"outcome": "superseded", "by": outcome.by}
        case outcomes.Refused():
            fields |= {"outcome": "refused", "policy": outcome.policy, "reason": outcome.reason}
    return CommandResult(**fields)


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
