"""The history of one device as the journal has it: its last change, and the chain of its causes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import final

from homebot.cli.command_records import JournalEntryRecord, SettingRecord, TriggerRecord
from homebot.cli.journal_client import JournalClient
from homebot.cli.journal_words import settings_text
from homebot.cli.late_effects import failed_command_of
from homebot.cli.records import DeviceRecord, StateRecord, TimeRecord
from homebot.cli.time_format import to_seconds
from homebot.cli.values import PlainValue, plain_value

__all__ = [
    "COMMANDED_STATES",
    "Chain",
    "DeviceHistory",
    "as_state",
    "asks_for",
    "changed_at",
    "is_first",
    "is_live",
    "means",
    "settable_states",
]

COMMANDED_STATES = {"close": "closed", "lock": "locked", "unlock": "unlocked"}
"""The states that commands with other words lead to."""

_DEEPEST = 5
"""Commands of one chain: a report that led to a command may have been the effect of another."""

_SAME_TIME = 2.0
"""Seconds between a report in the journal and the same one as the trigger of a command."""

_LATE = 3.0
"""Seconds after an entry that the directory may know of the change."""

_WISHES = frozenset({"requested", "published", "denied"})
_TRACES = frozenset({"reported", "changed"})


@final
@dataclass(frozen=True, slots=True)
class Chain:
    """A command, or a change that none explains, and its causes.

    Attributes:
        entries: Its entries, oldest first; of a change the one alone.
        before: The chain of the report that led to it; None if that has no explanation in the journal.
        late: The values that the device took on although the command failed; none in other chains.
    """

    entries: tuple[JournalEntryRecord, ...]
    before: Chain | None = None
    late: tuple[StateRecord, ...] = ()

    @property
    def first(self) -> JournalEntryRecord:
        """The command, or the change."""
        return self.entries[0]

    @property
    def changed_at(self) -> float:
        """The time of the change, in seconds since 1970."""
        return min((to_seconds(one["since"]) for one in self.late), default=to_seconds(self.entries[-1]["at"]))

    @property
    def all_entries(self) -> tuple[JournalEntryRecord, ...]:
        """The entries of all that led to it, and its own."""
        return (*(self.before.all_entries if self.before is not None else ()), *self.entries)

    @property
    def trigger(self) -> TriggerRecord:
        """The report, message or timer that led to the command; its kind is empty if that is not known."""
        return self.first["trigger"]


@final
class DeviceHistory:
    """Reads the journal entries of a device.

    Args:
        client: Reads the journal.
    """

    def __init__(self, client: JournalClient) -> None:
        self._client = client
        self.begins: TimeRecord = {"sec": 0, "nanosec": 0}

    def last_change(self, device: DeviceRecord) -> Chain | None:
        """Return the chain of the last change of *device*; None if the journal has none, or an older one.

        A later report of the same value, as after a restart, is no change.
        """
        found = self._client.read(device=device["id"])
        self.begins = found["begins"]
        entries = found["entries"]
        last = next((one for one in reversed(entries) if _is_change(one, entries)), None)
        until = to_seconds(last["at"]) + _LATE if last is not None else 0.0
        newer = [one for one in settable_states(device) if to_seconds(one["since"]) > until]
        if last is None or (newer and not _knows(entries, newer, last)):
            return self._late_effect(newer, entries)
        if last["kind"] == "changed" and (late := self._late_effect(_states_of(last), entries)) is not None:
            return late
        return self._chain(last, _DEEPEST)

    def newest_command(self, device: DeviceRecord) -> Chain | None:
        """Return the newest command to *device* that was sent; None if the journal has none."""
        entries = self._client.read(device=device["id"])["entries"]
        sent = next((one for one in reversed(entries) if one["kind"] == "sent"), None)
        return self._chain(sent, 1) if sent is not None else None

    def asked(self, device: DeviceRecord, state: str) -> Sequence[Chain]:
        """Return the commands for *state* in the journal, and the requests for it that were denied, newest last."""
        found = self._client.read(device=device["id"])
        self.begins = found["begins"]
        entries = found["entries"]
        wanted = [one for one in entries if one["kind"] in _WISHES and asks_for(one, state)]
        commands = {one["command"] or number: one for number, one in enumerate(wanted)}
        return [self._chain(one, 1) for one in commands.values()]

    def _late_effect(self, states: Sequence[StateRecord], entries: Sequence[JournalEntryRecord]) -> Chain | None:
        """Return the chain of the command that failed, and to which the newest of *states* is due all the same."""
        newest = max((to_seconds(one["since"]) for one in states), default=0.0)
        late = [one for one in states if newest and newest - to_seconds(one["since"]) <= _LATE]
        requests = [(one, failed_command_of(one, entries)) for one in late]
        found = next((request for _, request in requests if request is not None), None)
        if found is None:
            return None
        due = tuple([state for state, request in requests if request is not None])
        return replace(self._chain(found, _DEEPEST), late=due)

    def _chain(self, entry: JournalEntryRecord, deepest: int) -> Chain:
        if not entry["command"]:
            return Chain((entry,))
        entries = tuple(self._client.read(command=entry["command"])["entries"]) or (entry,)
        before = self._before(entries[0]) if deepest > 1 else None
        return Chain(entries, self._chain(before, deepest - 1) if before is not None else None)

    def _before(self, command: JournalEntryRecord) -> JournalEntryRecord | None:
        """Return the entry that tells of the report that was the trigger of *command*; None if none does."""
        trigger = command["trigger"]
        at = to_seconds(trigger["at"])
        if not trigger["device"] or trigger["kind"] not in {"report", "message"} or not at:
            return None
        found = self._client.read(device=trigger["device"], since=at - _SAME_TIME, until=at + _SAME_TIME)
        reports = [
            one
            for one in found["entries"]
            if one["kind"] in _TRACES and one["command"] != command["command"] and _tells_of(one, trigger)
        ]
        return min(reports, key=lambda one: abs(to_seconds(one["at"]) - at), default=None)


def changed_at(device: DeviceRecord) -> float:
    """Return when a state of *device* that can be set was last reported as new, in seconds since 1970; 0 for never."""
    return max((to_seconds(one["since"]) for one in settable_states(device)), default=0.0)


def is_live(device: DeviceRecord) -> bool:
    """Return whether :func:`changed_at` is from a report of the device itself, rather than the memory of a broker."""
    newest = _newest(device)
    return newest is not None and newest["live"]


def is_first(device: DeviceRecord) -> bool:
    """Return whether :func:`changed_at` is from the first report that homebot got since it was started."""
    newest = _newest(device)
    return newest is not None and newest["is_first"]


def settable_states(device: DeviceRecord) -> Iterable[StateRecord]:
    """Yield the states of *device* that a command could have changed."""
    settable = {
        (part["id"], one["name"])
        for part in device["parts"]
        for one in part["part"]["capabilities"]
        if one["settable"] and not part["part"]["category"]
    }
    return (one for one in device["states"] if (one["part"], one["capability"]) in settable)


def _newest(device: DeviceRecord) -> StateRecord | None:
    return max(settable_states(device), key=lambda one: to_seconds(one["since"]), default=None)


def as_state(text: str) -> str:
    """Return *text* as a state, folded: ``closed`` also for the command ``close``."""
    folded = text.strip().casefold()
    return COMMANDED_STATES.get(folded, folded)


def asks_for(entry: JournalEntryRecord, state: str) -> bool:
    """Return whether a command asks for *state*, as people say it: a lamp at 40 % is on."""
    wanted = as_state(state)
    if entry["kind"] != "requested" and not entry["settings"]:  # a raw command, or one that the door refused
        word = entry["text"].strip().casefold()
        return wanted in {word, COMMANDED_STATES.get(word)}
    return any(means(one, wanted) for one in entry["settings"])


def means(setting: SettingRecord, wanted: str) -> bool:
    """Return whether a setting is *wanted*, as ``on``, ``40``, ``40 %`` or, as `homebot do` takes it, ``level 40``."""
    name, told = _squeezed(setting["capability"]), _squeezed(settings_text([setting]))
    value = plain_value(setting["value"])
    match value:
        case bool():
            return wanted in (("on", "true", "yes") if value else ("off", "false", "no"))
        case str():
            return value.casefold() == wanted
        case float() | int():
            if setting["capability"] in {"level", "fan_speed"} and wanted in {"on", "off"}:
                return (value > 0) is (wanted == "on")
            if setting["capability"] == "position" and wanted in {"open", "closed"}:
                return (value > 0) is (wanted == "open")
            return _squeezed(wanted) in {f"{value:g}", f"{name}{value:g}", told, told.removeprefix(name)}
    return False


def _knows(entries: Iterable[JournalEntryRecord], states: Iterable[StateRecord], last: JournalEntryRecord) -> bool:
    """Return whether *entries*, with the change *last*, tell of the values of *states*, and of no others."""
    known: dict[tuple[str, str], PlainValue] = {}
    for entry in entries:
        for one in entry["settings"] if entry["kind"] in _TRACES else ():
            known[entry["part"], one["capability"]] = plain_value(one["value"])
    told = {(one["part"], one["capability"]): plain_value(one["value"]) for one in states}
    shared = known.keys() & told.keys()
    if last["kind"] == "reverted":  # to the state before, which is not known
        return all(known[one] != told[one] for one in shared)
    return bool(shared) and all(known[one] == told[one] for one in shared)


def _states_of(change: JournalEntryRecord) -> Sequence[StateRecord]:
    """Return the states of a change that no command explains."""
    at, part = change["at"], change["part"]
    return [
        {**one, "part": part, "since": at, "told_at": at, "live": True, "is_first": False} for one in change["settings"]
    ]


def _squeezed(text: str) -> str:
    """Return *text* without the characters that differ between two spellings."""
    return text.casefold().replace(" ", "").replace("_", "")


def _tells_of(entry: JournalEntryRecord, trigger: TriggerRecord) -> bool:
    """Return whether an entry of a report has a value of *trigger*; those in a structured raw message are not known."""
    if trigger["kind"] == "message":
        text = trigger["text"].strip().casefold()
        return text.startswith("{") or any(means(one, text) for one in entry["settings"])
    values = {one["capability"]: plain_value(one["value"]) for one in trigger["readings"]}
    return any(
        one["capability"] in values and values[one["capability"]] == plain_value(one["value"])
        for one in entry["settings"]
    )


def _is_change(entry: JournalEntryRecord, entries: Sequence[JournalEntryRecord]) -> bool:
    """Return whether *entry* tells that the device is another way than before."""
    if entry["kind"] in {"changed", "reverted"}:
        return True
    if entry["kind"] == "outcome":  # of a device that reports nothing, the acknowledgement is all there is
        return entry["results"][0]["outcome"] == "confirmed"
    if entry["kind"] == "reported":
        outcomes = [one for one in entries if one["command"] == entry["command"] and one["kind"] == "outcome"]
        if not outcomes:
            return True
        result = outcomes[0]["results"][0]
        return result["outcome"] in {"confirmed", "superseded"} or bool(
            result["witness"]
        )  # it reported it all the same
    return False
