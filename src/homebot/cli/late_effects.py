"""Changes of a device that are due to a command which failed: it was slow, or did something like it. Pure."""

from __future__ import annotations

from collections.abc import Sequence

from homebot.cli.command_records import JournalEntryRecord
from homebot.cli.records import StateRecord
from homebot.cli.time_format import to_seconds
from homebot.cli.values import PlainValue, plain_value

__all__ = ["failed_command_of"]

_FAILED = frozenset({"no_answer", "contradicted"})

_LATEST = 60.0
"""Seconds after the outcome in which a change to the commanded value is taken for the effect of the command."""

_EARLY = 2.0
"""Seconds that a device may tell of the effect before the journal has the command."""

_ROUNDING = 1.5
"""Of a number that a device was set to."""


def failed_command_of(state: StateRecord, entries: Sequence[JournalEntryRecord]) -> JournalEntryRecord | None:
    """Return the request of the command, which failed, that explains since when *state* is so; None if none does.

    It is the last one that was sent to the part before. Either it asked for that, or the device answered it so. The
    first report of a device may be about an earlier state.
    """
    at, value = to_seconds(state["since"]), plain_value(state["value"])
    sent = (one for one in reversed(entries) if one["kind"] == "sent" and one["part"] == state["part"])
    last = next((one for one in sent if to_seconds(one["at"]) <= at + _EARLY), None)
    if last is None:
        return None
    chain = [one for one in entries if one["command"] == last["command"]]
    outcome = next((one for one in chain if one["kind"] == "outcome"), None)
    request = next((one for one in chain if one["kind"] == "requested"), None)
    if outcome is None or request is None or at > to_seconds(outcome["at"]) + _LATEST:
        return None
    result = outcome["results"][0]
    if result["outcome"] not in _FAILED or result["witness"]:
        return None
    answers = [] if state["is_first"] else [one for one in chain if one["kind"] == "reported"]
    settings = [setting for one in (request, *answers) for setting in one["settings"]]
    is_so = any(
        one["capability"] == state["capability"] and _is_near(plain_value(one["value"]), value) for one in settings
    )
    return request if is_so else None


def _is_near(wanted: PlainValue, value: PlainValue) -> bool:
    if isinstance(wanted, float) and isinstance(value, float):
        return abs(wanted - value) <= _ROUNDING
    return wanted == value
