"""Records of commands and outcomes: the fields of their messages, as JSON has them; see :mod:`homebot.cli.records`."""

from __future__ import annotations

from typing import TypedDict

from homebot.cli.records import ValueRecord

__all__ = ["CommandDevicesRecord", "CommandResultRecord", "CommandedPartRecord", "SettingRecord"]


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
