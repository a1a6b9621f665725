"""Records of commands, leases and the journal: the fields of messages as JSON; see :mod:`homebot.cli.records`."""

from __future__ import annotations

from typing import TypedDict

from homebot.cli.records import KeyValueRecord, TimeRecord, ValueRecord

__all__ = [
    "CommandDevicesRecord",
    "CommandResultRecord",
    "CommandedPartRecord",
    "ExplanationRecord",
    "HeldPartRecord",
    "HolderRecord",
    "JournalEntryRecord",
    "JournalRecord",
    "JournalVerdictRecord",
    "LeasesRecord",
    "MissingStateRecord",
    "SettingRecord",
    "TriggerRecord",
]


class SettingRecord(TypedDict):
    """:class:`homebot.devices.command_messages.Setting`."""

    capability: str
    value: ValueRecord


class CommandResultRecord(TypedDict):
    """:class:`homebot.devices.command_messages.CommandResult`."""

    command_id: str
    outcome: str
    text: str
    latency: float
    evidence: int
    saw: str
    witness: str
    by: str
    policy: str
    reason: str
    reported: list[SettingRecord]


class CommandedPartRecord(TypedDict):
    """:class:`homebot.devices.command_messages.CommandedPart`."""

    device: str
    name: str
    part: str
    result: CommandResultRecord


class CommandDevicesRecord(TypedDict):
    """:class:`homebot.devices.command_messages.CommandDevicesResponse`."""

    success: bool
    message: str
    outcome: str
    results: list[CommandedPartRecord]


class HolderRecord(TypedDict):
    """:class:`homebot.devices.lease_messages.HolderOfPart`."""

    by: str
    issuer: str
    until: TimeRecord


class HeldPartRecord(TypedDict):
    """:class:`homebot.devices.lease_messages.HeldPart`."""

    device: str
    part: str
    setting: SettingRecord
    holders: list[HolderRecord]
    outranked_until: TimeRecord
    saw: str


class LeasesRecord(TypedDict):
    """:class:`homebot.devices.lease_messages.LeasesResponse`."""

    parts: list[HeldPartRecord]


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
    cause: str
    folded: int


class ExplanationRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.ExplainDeviceResponse`."""

    success: bool
    message: str
    finding: str
    changed_at: TimeRecord
    entries: list[JournalEntryRecord]
    names: list[KeyValueRecord]


class MissingStateRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.ExplainMissingStateResponse`."""

    success: bool
    message: str
    is_so: bool
    problem: str
    word: str
    entries: list[JournalEntryRecord]
    begins: TimeRecord
    names: list[KeyValueRecord]


class JournalRecord(TypedDict):
    """:class:`homebot.devices.journal_messages.ReadJournalResponse`."""

    success: bool
    message: str
    entries: list[JournalEntryRecord]
    complete: bool
    begins: TimeRecord
    names: list[KeyValueRecord]
