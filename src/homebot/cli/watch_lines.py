"""Lines about events in the house: one for each change and each command. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias, final

from homebot.devices.capabilities import EVENTS
from homebot.devices.outcomes import cause_text, has_succeeded
from homebot.devices.wording.journal_words import entry_text, issuer_text, name_text, settings_text, trigger_text
from homebot.devices.wording.values import plain_value
from homebot.support.bounded_map import BoundedMap
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import State, StateChange
    from homebot.devices.journal_messages import JournalEntry
    from homebot.devices.value import Reading
    from homebot.messages import Time

EXPLAINED_WITHIN: Final = 0.8
"""Seconds after which the journal has the cause of a change: the directory gathers settings for half a second."""

_DEVICE: Final = 18
_VALUE: Final = 16
_WHY: Final = 32
"""Columns of a line; longer texts push the following ones to the right."""

_OWN_CAUSES: Final = frozenset({"", "command", "transition", "echo"})
"""Causes of a report that are the command itself; the others are a hand, another program or the device."""

_MAX_VALUES: Final = 10_000
"""The limit of known values, and of commands; the oldest are dropped."""

_Place: TypeAlias = tuple[str, str, str]
_Value: TypeAlias = tuple[str, str, str, str]
"""Device, part, capability, and the value as text."""


@dataclass(slots=True)
class WatchLine:
    """One line.

    Attributes:
        kind: ``change``, ``command``, or the ``outcome`` of a command without a change.
        part: The id of the part; empty for a device with one part.
        values: The values as text, by capability.
        why: The cause of a change or command, or the outcome, in words.
        issuer: The issuer of the command, in words; empty for none.
    """

    at: Time
    kind: Literal["change", "command", "outcome"]
    device: str
    part: str
    values: Mapping[str, object]
    value: str
    why: str = ""
    issuer: str = ""


@dataclass(slots=True)
class _WaitingLine:
    line: WatchLine
    due: float
    keys: tuple[_Value, ...] = ()


class _Reason(NamedTuple):
    why: str
    issuer: str
    until: float
    """For a change up to this time; a later one to the same value has another reason."""


@dataclass(slots=True)
class _Command:
    settings: Mapping[str, object]
    words: str
    is_seen: bool = False


@final
class HouseLines:
    """Lines from changed values and journal entries, in order of arrival.

    Args:
        names: The names of devices, by id, and of their parts by ``ID#PART``; may grow.
    """

    def __init__(self, names: Mapping[str, str]) -> None:
        self._names = names
        self._values: BoundedMap[_Place, str] = BoundedMap(_MAX_VALUES)
        self._commands: BoundedMap[str, _Command] = BoundedMap(_MAX_VALUES)
        self._explained: BoundedMap[_Value, _Reason] = BoundedMap(_MAX_VALUES)
        self._waiting: deque[_WaitingLine] = deque()

    def learn(self, device: str, readings: Iterable[Reading | State]) -> None:
        """Record known values, which are not changes."""
        for reading in readings:
            self._values[device, reading.part, reading.capability] = str(plain_value(reading.value))

    def add_change(self, change: StateChange, now: float) -> None:
        """Add a line for the values of *change* that differ from the known ones, and for each event."""
        changed = []
        for reading in change.readings:
            place, text = (change.device, reading.part, reading.capability), str(plain_value(reading.value))
            if reading.capability in EVENTS or self._values.get(place) != text:
                self._values[place] = text
                changed.append(reading)
        if not changed:
            return
        keys = tuple(
            (change.device, reading.part, reading.capability, str(plain_value(reading.value))) for reading in changed
        )
        known = [reason for key in keys if (reason := self._explained.pop(key, None)) and now <= reason.until]
        why, issuer = known[0][:2] if known else ("", "")
        values = {reading.capability: plain_value(reading.value) for reading in changed}
        part = changed[0].part
        line = WatchLine(change.told_at, "change", change.device, part, values, settings_text(changed), why, issuer)
        self._waiting.append(_WaitingLine(line, now if why else now + EXPLAINED_WITHIN, keys))

    def add_entry(self, entry: JournalEntry, now: float) -> None:
        """Add a line for a command, or the cause of a change."""
        match entry.kind:
            case "requested" | "published":
                self._add_command(entry, now)
            case "reported" | "changed":
                self._explain(entry, now)
            case "outcome" | "reverted":
                command = self._commands.get(entry.command) or _Command({}, "")
                result = entry.results[0]
                if not (has_succeeded(result.outcome) and command.is_seen and entry.kind == "outcome"):
                    self._add(entry, "outcome", command.settings, f"→ {command.words}", printable(result.text), now)
            case "denied":
                self._add(entry, "outcome", {}, "", entry_text(entry, self._names), now)

    def pop(self, now: float) -> Iterator[WatchLine]:
        """Remove and yield the lines that no longer wait for a cause."""
        while self._waiting and self._waiting[0].due <= now:
            yield self._waiting.popleft().line

    def _add_command(self, entry: JournalEntry, now: float) -> None:
        if entry.kind == "published" and entry.command in self._commands:
            self._commands[entry.command].is_seen = True
            return  # a text of an app, which is already a request
        values = {setting.capability: plain_value(setting.value) for setting in entry.settings}
        words = settings_text(entry.settings) if entry.settings else repr(printable(entry.text, 60))
        self._commands[entry.command] = _Command(values, words)
        cause = trigger_text(entry.trigger, self._names)
        self._add(entry, "command", values, f"→ {words}", f"because {cause}" if cause else "", now)

    def _explain(self, entry: JournalEntry, now: float) -> None:
        command = self._commands.get(entry.command)
        if command is not None:
            command.is_seen = True
        if entry.cause in _OWN_CAUSES:
            why = "as commanded" if entry.kind == "reported" else "raw text"
            issuer = issuer_text(entry.issuer) if entry.issuer else ""
        else:
            why, issuer = cause_text(entry.cause), ""
        for setting in entry.settings:
            key = (entry.device, entry.part, setting.capability, str(plain_value(setting.value)))
            waiting = next((change for change in self._waiting if key in change.keys and not change.line.why), None)
            if waiting is None:
                self._explained[key] = _Reason(why, issuer, now + EXPLAINED_WITHIN)
            else:
                waiting.line.why, waiting.line.issuer, waiting.due = why, issuer, 0.0

    def _add(
        self,
        entry: JournalEntry,
        kind: Literal["command", "outcome"],
        values: Mapping[str, object],
        words: str,
        why: str,
        now: float,
    ) -> None:
        issuer = issuer_text(entry.issuer) if entry.issuer else ""
        line = WatchLine(entry.at, kind, entry.device, entry.part, values, words, why, issuer)
        self._waiting.append(_WaitingLine(line, now))


def line_cells(line: WatchLine, names: Mapping[str, str], time: str) -> tuple[str, ...]:
    """Return time, device, value, why and issuer."""
    return time, name_text(line.device, names, line.part), line.value, printable(line.why), line.issuer


def fitted(cells: tuple[str, ...], width: int | None) -> str:
    """Return *cells* in columns; if *width* is given, the line is cut to fit: first the cause, then the issuer."""
    time, device, value, why, issuer = cells
    begin = f"{time}  {device:<{_DEVICE}}  {value:<{_VALUE}}"
    end = len(time) + _DEVICE + _VALUE + _WHY + 6  # of the cause, also after a long value
    if width is None:
        return f"{f'{begin}  {why}':<{end}}  {issuer}".rstrip()
    room = max(0, width - len(begin) - 2)
    issuer = printable(issuer, room) if len(issuer) > room and room else issuer[:room]
    left = room - len(issuer) - 2
    cut = printable(why, left) if left > 0 else ""
    return f"{f'{begin}  {cut}':<{min(end, width - len(issuer) - 2)}}  {issuer}".rstrip()[:width]
