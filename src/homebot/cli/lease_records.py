"""Records of leases: the fields of their messages, as JSON has them; see :mod:`homebot.cli.records`."""

from __future__ import annotations

from typing import TypedDict

from homebot.cli.command_records import SettingRecord
from homebot.cli.records import TimeRecord

__all__ = ["HeldPartRecord", "HolderRecord", "LeasesRecord"]


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
