"""Client of the journal of a running homebot; its entries as JSON for other programs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, cast, final

from homebot.cli.door_client import DoorClient
from homebot.devices.names import READ_JOURNAL
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.devices.wording.time_format import iso
from homebot.devices.wording.values import plain_value

if TYPE_CHECKING:
    from homebot.devices import Device, KeyValue
    from homebot.devices.command_messages import CommandResult, Setting
    from homebot.devices.journal_messages import (
        JournalEntry,
    )
    from homebot.devices.trigger import Trigger
    from homebot.devices.value import Reading


@final
class JournalClient:
    """Reads the journal of a running homebot."""

    def __init__(self, door: DoorClient, *known: Device) -> None:
        self._door = door
        self.names = {device.id: device.name for device in known}

    def ask(self, service: str, request: Mapping[str, object]) -> JsonMessage:
        """Return the answer of a *service* of the journal.

        Raises:
            PeerError: The journal cannot be read; the message says why.
        """
        response = self._door.ask(service, request)
        names = cast("list[KeyValue]", response.names)
        self.names.update({name.key: name.value for name in names})
        return response

    def read_name(self, device: str) -> None:
        """Read the name of the device of an entry, unless it is known."""
        if device and device not in self.names:
            self.names[device] = device
            self.ask(READ_JOURNAL, {"device": device, "limit": 1})


def chain_json(entries: Iterable[JournalEntry], names: Mapping[str, str]) -> list[dict[str, object]]:
    """Return *entries* as JSON objects, see :func:`entry_json`."""
    return [entry_json(entry, names) for entry in entries]


def entry_json(entry: JournalEntry, names: Mapping[str, str]) -> dict[str, object]:
    """Return *entry* as a JSON object for other programs: plain values, times in ISO 8601, no empty fields."""
    fields: dict[str, object] = {"kind": entry.kind, "at": iso(entry.at), "device": entry.device}
    if name := names.get(entry.device):
        fields["name"] = name
    texts = fields_of(entry)
    fields |= {key: texts[key] for key in ("part", "command", "issuer", "text", "cause") if texts[key]}
    if entry.trigger.kind:
        fields["trigger"] = _trigger_json(entry.trigger)
    if entry.settings:
        fields["settings"] = _settings_json(entry.settings)
    for verdict in entry.verdicts:
        fields["verdict"] = {
            "policy": verdict.policy,
            "allowed": verdict.allowed,
            "reason": verdict.reason,
            "facts": {fact.name: plain_value(fact.value) for fact in verdict.facts},
        }
    for result in entry.results:
        fields["outcome"] = _outcome_json(result)
    if entry.folded:
        fields["folded"] = entry.folded
    return fields


def _trigger_json(trigger: Trigger) -> dict[str, object]:
    fields: dict[str, object] = {"kind": trigger.kind, "id": trigger.id}
    texts = fields_of(trigger)
    fields |= {key: texts[key] for key in ("device", "text") if texts[key]}
    if trigger.readings:
        fields["readings"] = _settings_json(trigger.readings)
    if trigger.at.sec:
        fields["at"] = iso(trigger.at)
    return fields


def _settings_json(settings: Iterable[Setting | Reading]) -> dict[str, object]:
    return {setting.capability: plain_value(setting.value) for setting in settings}


def _outcome_json(result: CommandResult) -> dict[str, object]:
    fields: dict[str, object] = {"outcome": result.outcome, "text": result.text}
    values = fields_of(result)
    return fields | {
        key: values[key] for key in ("latency", "evidence", "saw", "witness", "by", "policy", "reason") if values[key]
    }
