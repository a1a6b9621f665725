"""The one writer of reports: each answer to a command, and each change that no command has recorded, with its cause."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

from homebot.control.timeline.facts import NOT_JUDGED, Cause, Reported, ReportRole
from homebot.devices.client_rights import is_from_person
from homebot.devices.command_messages import Setting
from homebot.devices.journal_messages import (
    GetCausesRequest,
    JournalEntry,
    KnownCause,
    KnownCauses,
    ReadJournalRequest,
)
from homebot.devices.outcomes import Contradicted

if TYPE_CHECKING:
    from homebot.control.journal.journal import CommandJournal
    from homebot.control.open_command import OpenCommand
    from homebot.control.timeline.progress import CommandProgress
    from homebot.control.timelines import Timelines
    from homebot.devices.device import ChangedSetting

_LATE_ROLES: Final = (ReportRole.EFFECT, ReportRole.UNDONE, ReportRole.DEVIATES)

_MAX_ENTRIES: Final = 200
"""Entries of one device that are read: some twenty commands."""


@final
class ReportLog:
    """Records reports in the journal."""

    def __init__(self, journal: CommandJournal, timelines: Timelines) -> None:
        self._journal = journal
        self._timelines = timelines

    async def causes(self, request: GetCausesRequest) -> KnownCauses:
        """Return the causes of the newest changes of some devices."""
        known = list(self._timelines.causes(frozenset(request.devices)))
        places = {(cause.device, cause.part, cause.capability) for cause in known}
        for device in request.devices if request.from_journal else ():
            entries = (await self._journal.read(ReadJournalRequest(device=device, limit=_MAX_ENTRIES))).entries
            requests = {entry.command: entry for entry in entries if entry.kind == "requested"}
            for entry in reversed(entries):
                place = device, entry.part, entry.settings[0].capability if entry.settings else ""
                if entry.kind not in {"reported", "changed", "reverted"} or not entry.cause or place in places:
                    continue
                places.add(place)
                if entry.command not in requests:  # to another device, such as a group, or past homebot
                    requests |= await self._request(entry.command)
                asked = requests.get(entry.command)
                known.append(
                    KnownCause(
                        device=device,
                        part=entry.part,
                        capability=place[2],
                        value=entry.settings[0].value,
                        command=entry.command,
                        issuer=asked.issuer if asked else "",
                        cause=entry.cause,
                        may_be_person=entry.cause in {"person", "unknown"}
                        or (is_from_person(asked.issuer, asked.trigger) if asked else bool(entry.command)),
                    )
                )
        return KnownCauses(causes=tuple(known))

    async def _request(self, command: str) -> dict[str, JournalEntry]:
        """Return the request of a command by its id; nothing if it was given past homebot."""
        if not command:
            return {}
        entries = (await self._journal.read(ReadJournalRequest(command=command))).entries
        return {entry.command: entry for entry in entries if entry.kind == "requested"}

    def on_report(self, progress: CommandProgress, fact: Reported, opened: OpenCommand | None) -> None:
        """Record a report that answers a command, also after its outcome, when there is no *opened* command."""
        order, attribution = progress.order, fact.attribution
        is_answer = fact.capability in progress.wanted and opened.is_news(fact) if opened else _is_late(progress, fact)
        if not is_answer or (opened is None and attribution.command != order.id):
            return
        is_told = attribution.role is ReportRole.EFFECT or fact.is_change
        setting, text = Setting.of(fact.capability, fact.value), attribution.cause.value if is_told else ""
        self._journal.record_report(order.place, setting, fact.stamp, text, order.id, order.issuer)

    def on_change(self, change: ChangedSetting) -> None:
        """Record and log a change, unless it has a role for a command to its part: then that command recorded it."""
        place, at = (change.device, change.part), change.told_at.to_seconds()
        attribution = self._timelines.cause(change) or NOT_JUDGED
        if attribution.role is not None:
            return
        setting = Setting(capability=change.capability, value=change.value)
        command = "" if attribution.cause in {Cause.PERSON, Cause.UNKNOWN} else attribution.command
        self._journal.record_report(place, setting, at, attribution.cause.value, command)
        if not command:
            self._journal.log.log_change(change, attribution.cause.value)


def _is_late(progress: CommandProgress, fact: Reported) -> bool:
    """Return whether the device obeyed a command after its failure or undoing, or no longer does; no raw text."""
    outcome, is_again = progress.outcome, progress.undoing is not None and fact.attribution.role is ReportRole.EFFECT
    if outcome is None or not (outcome.may_obey_later or is_again):
        return False
    if isinstance(outcome, Contradicted) and outcome.witness:
        return False
    is_change = fact.is_change or (fact.is_first and progress.last.get(fact.capability, fact.value) != fact.value)
    return not progress.is_raw and is_change and fact.attribution.role in _LATE_ROLES
