"""The history of a device in words. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from homebot.cli.command_records import JournalEntryRecord
from homebot.cli.device_history import Chain
from homebot.cli.journal_words import (
    clock_text,
    denial_text,
    entry_text,
    issuer_text,
    name_text,
    repeats,
    settings_text,
    trigger_text,
)
from homebot.cli.table import printable
from homebot.cli.time_format import to_seconds

__all__ = ["UNEXPLAINED", "chain_lines", "reason_text", "result_text"]

_LONGEST = 900.0
"""Seconds after which a command has its outcome, unless it was given with a very long transition."""

UNEXPLAINED = "no command explains it: somebody did it by hand, or it did so by itself"


def reason_text(chain: Chain, names: Mapping[str, str]) -> str:
    """Return in a clause why the device changed."""
    last, first = chain.entries[-1], chain.first
    if first["kind"] == "changed":
        return UNEXPLAINED
    issuer = issuer_text(first["issuer"])
    if last["kind"] == "reverted":
        wanted = settings_text(first["settings"])
        return f"it changed back, by a hand or by itself, after {issuer} had asked for {wanted}"
    asked = f"{issuer} {'published' if first['kind'] == 'published' else 'asked for'} {_wanted(first)}"
    cause = trigger_text(chain.trigger, names)
    reason = f"{asked}, because {cause}" if cause else asked
    if _is_late(chain):
        return f"{reason}; it answered late, or somebody did it by hand"
    doubt = _doubt(chain)
    return f"{reason}; it reported that, but {doubt}" if doubt else reason


def chain_lines(chain: Chain, names: Mapping[str, str], now: float) -> Iterator[tuple[str, str]]:
    """Yield the steps of *chain* and of its causes, oldest first, each with its time."""
    trigger = chain.trigger
    if chain.before is not None:
        yield from chain_lines(chain.before, names, now)
    elif cause := trigger_text(trigger, names):
        yield clock_text(trigger["at"], now) if trigger["at"]["sec"] else "", cause
    steps = [(entry["at"], entry_text(entry, names)) for entry in _told(chain.entries)]
    if _is_late(chain):
        name = name_text(chain.first["device"], names, chain.late[0]["part"])
        steps.append((chain.late[0]["since"], f"{name} reported {settings_text(chain.late)}"))
    for at, text in steps:
        yield clock_text(at, now), text


def result_text(chain: Chain, now: float) -> str:
    """Return the outcome of a command, as it is known at *now*, in seconds since 1970."""
    decided = [one for one in chain.entries if one["kind"] in {"outcome", "reverted"}]
    if decided:
        return entry_text(decided[-1], {})
    if chain.first["kind"] == "denied":
        return f"refused: {denial_text(chain.first)}"
    if would := [one for one in chain.entries if one["kind"] == "would"]:
        return entry_text(would[-1], {})
    if any(one["kind"] == "published" for one in chain.entries):
        reports = [one for one in chain.entries if one["kind"] == "reported"]
        return f"it reported {settings_text(reports[-1]['settings'])}" if reports else "it reported nothing new"
    if now - to_seconds(chain.first["at"]) > _LONGEST:
        return "its outcome is not known: homebot stopped before it was"
    return "its outcome is not known yet"


def _is_late(chain: Chain) -> bool:
    """Return whether the device did it after the outcome; an earlier report is an entry of the command."""
    return bool(chain.late) and chain.changed_at > to_seconds(chain.entries[-1]["at"])


def _doubt(chain: Chain) -> str:
    """Return the observation of a witness against the report of the device; empty if none contradicted it."""
    results = [one["results"][0] for one in chain.entries if one["kind"] == "outcome"]
    return next((printable(one["saw"]) for one in results if one["outcome"] == "contradicted" and one["witness"]), "")


def _wanted(entry: JournalEntryRecord) -> str:
    return repr(entry["text"]) if entry["kind"] == "published" else settings_text(entry["settings"])


def _told(entries: Iterable[JournalEntryRecord]) -> Iterator[JournalEntryRecord]:
    """Yield the informative entries: an acceptance by the network only without a report, and a no once."""
    shown = list(entries)
    has_report = any(one["kind"] == "reported" for one in shown)
    for before, one in zip([None, *shown], shown, strict=False):
        if (one["kind"] != "acknowledged" or not has_report) and not repeats(one, before):
            yield one
