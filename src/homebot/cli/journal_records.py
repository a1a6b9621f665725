"""Records of the journal: the fields of its messages, as JSON has them; see :mod:`homebot.cli.records`."""

from __future__ import annotations

from typing import TypedDict

from homebot.cli.command_records import CommandResultRecord, SettingRecord
from homebot.cli.records import KeyValueRecord, TimeRecord, ValueRecord

__all__ = [
    "JournalEntryRecord",
    "JournalRecord",
    "JournalVerdictRecord",
    "TriggerRecord",
]


class ReadingRecord(TypedDict):
    """:class:`homebot.devices.value.Reading`."""

    part: str
    capability: str
    value: ValueRecord


class TriggerRecord(TypedDict):
    """:class:`homebot.devices.trigger.Trigger`."""

    kind: str
    id: str
    device: str
    readings: list[ReadingRecord]
    text: str
    at: TimeRecord


class JournalFactRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.JournalFact`."""

    name: str
    value: ValueRecord
    since: TimeRecord


class JournalVerdictRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.JournalVerdict`."""

    policy: str
    allowed: bool
    reason: str
    facts: list[JournalFactRecord]


class JournalEntryRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.JournalEntry`."""

    kind: str
    at: TimeRecord
    device: str
    part: str
    command: str
    issuer: str
    trigger: TriggerRecord
    settings: list[SettingRecord]
    text: str
    verdicts: list[JournalVerdictRecord]
    results: list[CommandResultRecord]


class JournalRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.ReadJournalResponse`."""

    success: bool
    message: str
    entries: list[JournalEntryRecord]
    complete: bool
    begins: TimeRecord
    names: list[KeyValueRecord]
