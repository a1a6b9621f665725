"""Explanations of a device in words. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, TypeAlias

from homebot.devices.wording.journal_words import (
    ago_text,
    clock_text,
    denial_text,
    entry_text,
    issuer_text,
    repeats,
    settings_text,
    trigger_text,
)
from homebot.devices.wording.time_format import to_seconds
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.journal_messages import ExplainDeviceResponse, JournalEntry

__all__ = ["Chain", "chain_lines", "chains_of", "finding_text", "reason_text", "result_text"]

Chain: TypeAlias = "list[JournalEntry]"
"""The entries of a command, oldest first, or the entry of a change."""

_LONGEST = 900.0
"""Seconds after which a command has its outcome, unless it was given with a very long transition."""

_UNEXPLAINED = "no command explains it: somebody did it by hand, or it did so by itself"

_FINDINGS = {
    "command": "It changed {ago}: {reason}.",
    "change": "It changed {ago}: {reason}.",
    "heard": "It has been so since homebot first heard of it, {ago}.",
    "retained": "It was so already {ago}; a retained value does not tell since when.",
    "first": "It was so already {ago}, when it first told how it is.",
}


def chains_of(entries: Iterable[JournalEntry]) -> list[Chain]:
    """Return *entries* by command: those of one command follow each other, and a change is alone."""
    found: list[Chain] = []
    for entry in entries:
        if found and entry.command and found[-1][0].command == entry.command:
            found[-1].append(entry)
        else:
            found.append([entry])
    return found


def reason_text(chain: Chain, names: Mapping[str, str]) -> str:
    """Return in a clause why the device changed."""
    last, first = chain[-1], chain[0]
    if first.kind == "changed":
        return _UNEXPLAINED
    issuer = issuer_text(first.issuer)
    if last.kind == "reverted":
        wanted = settings_text(first.settings)
        return f"it changed back, by a hand or by itself, after {issuer} had asked for {wanted}"
    asked = f"{issuer} {'published' if first.kind == 'published' else 'asked for'} {_wanted(first)}"
    cause = trigger_text(first.trigger, names)
    reason = f"{asked}, because {cause}" if cause else asked
    if last.kind == "reported" and any(one.kind == "outcome" for one in chain):
        return f"{reason}; it answered late, or somebody did it by hand"
    doubt = _doubt(chain)
    return f"{reason}; it reported that, but {doubt}" if doubt else reason


def finding_text(found: ExplainDeviceResponse, names: Mapping[str, str], now: float) -> str:
    """Return in a sentence since when and why a device is as it is."""
    chains = chains_of(found.entries)
    if found.finding == "none":
        no_change = "It reported no change after the newest command."
        return no_change if chains else "Nobody commanded it, and it reported no change."
    reason = reason_text(chains[-1], names) if chains else _UNEXPLAINED
    return _FINDINGS[found.finding].format(ago=ago_text(to_seconds(found.changed_at), now), reason=reason)


def chain_lines(chains: Iterable[Chain], names: Mapping[str, str], now: float) -> Iterator[tuple[str, str]]:
    """Yield the steps of *chains*, each with its time; the report that led to the first of them is one."""
    for number, chain in enumerate(chains):
        trigger = chain[0].trigger
        if number == 0 and (cause := trigger_text(trigger, names)):
            yield clock_text(trigger.at, now) if trigger.at.sec else "", cause
        for entry in _informative(chain):
            yield clock_text(entry.at, now), entry_text(entry, names)


def result_text(chain: Chain, now: float) -> str:
    """Return the outcome of a command, as it is known at *now*, in seconds since 1970."""
    decided = [one for one in chain if one.kind in {"outcome", "reverted"}]
    if decided:
        return entry_text(decided[-1], {})
    if chain[0].kind == "denied":
        return f"refused: {denial_text(chain[0])}"
    if would := [one for one in chain if one.kind == "would"]:
        return entry_text(would[-1], {})
    if any(one.kind == "published" for one in chain):
        return _report_text([one for one in chain if one.kind == "reported"])
    if now - to_seconds(chain[0].at) > _LONGEST:
        return "its outcome is not known: homebot stopped before it was"
    return "its outcome is not known yet"


def _report_text(reports: Chain) -> str:
    return f"it reported {settings_text(reports[-1].settings)}" if reports else "it reported nothing new"


def _doubt(chain: Chain) -> str:
    """Return the observation of a witness against the report of the device; empty if none contradicted it."""
    results = [one.results[0] for one in chain if one.kind == "outcome"]
    return next((printable(one.saw) for one in results if one.saw and one.witness), "")


def _wanted(entry: JournalEntry) -> str:
    return repr(entry.text) if entry.kind == "published" else settings_text(entry.settings)


def _informative(entries: Iterable[JournalEntry]) -> Iterator[JournalEntry]:
    """Yield the informative entries: an acceptance only by a route or without a report, and a no once."""
    shown = list(entries)
    has_report = any(one.kind == "reported" for one in shown)
    for before, one in zip([None, *shown], shown, strict=False):
        if (one.kind != "acknowledged" or one.text or not has_report) and not repeats(one, before):
            yield one
