"""Log lines: each command with its outcome, each change that no command explains, each fight of apps."""

import asyncio
from collections import deque
from dataclasses import dataclass
from functools import partial
from typing import Final, final

from homebot.control.command import is_by_hand, label_of
from homebot.control.journal.fights import Fights, Turn
from homebot.devices import Device
from homebot.devices.client_rights import is_client
from homebot.devices.device import ChangedSetting
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.outcomes import AlreadySo, Gone, Refused, cause_text
from homebot.devices.wording.journal_words import settings_text
from homebot.devices.wording.values import value_text
from homebot.graph import Node
from homebot.journal.store import JournalNote
from homebot.log import LogLimit, more_like_this

COMMAND: Final = "control.command"
CHANGED: Final = "control.changed"
FIGHT: Final = "control.fight"

_INTERVAL: Final = 60.0
_LINES: Final = 60
"""Lines a minute for the commands of one issuer, or for changes; the next minute's line counts the others."""

_DELAY: Final = 0.05
"""Seconds after which lines are written, so that commands do not wait for them."""


@dataclass(slots=True, eq=False)
class CommandChain:
    """The entries of a command until now, oldest first, and its device.

    Attributes:
        filed: How many of them are stored or folded.
    """

    notes: list[JournalNote]
    device: Device | None = None
    filed: int = 0


@final
class CommandLog:
    """Logs each command once, from the entries of the journal."""

    def __init__(self, node: Node, lookup: DeviceLookup) -> None:
        self._node = node
        self._lookup = lookup
        self._ended: deque[CommandChain] = deque()
        self._limit = LogLimit(node.graph.clock, _INTERVAL, _LINES)
        self.fights = Fights()

    def end(self, command: CommandChain) -> None:
        """Log, after a short delay, a command that has ended."""
        if not self._ended:
            asyncio.get_running_loop().call_later(_DELAY, self.write)
        self._ended.append(command)

    def write(self) -> None:
        """Write the pending lines."""
        while self._ended:
            command = self._ended.popleft()
            asked, ended = command.notes[0], command.notes[-1]
            if any(note.kind == "would" for note in command.notes):  # already logged
                continue
            if not isinstance(ended.outcome, AlreadySo):  # else nothing was sent
                self._log(command, ended)
            if asked.kind == "requested" and not isinstance(ended.outcome, AlreadySo | Refused | Gone):
                self._add_turn(asked, command.device)

    def log_change(self, change: ChangedSetting, cause: str) -> None:
        """Log a change that no command explains."""
        if (held_back := self._limit.allows("")) is not None:
            self._node.create_task(partial(self._log_change, change, cause, more_like_this(held_back)))

    async def _log_change(self, change: ChangedSetting, cause: str, end: str) -> None:
        device, before = await self._lookup.known(change.device), change.before.plain()
        label = _label(change, device)
        values = " → ".join(value_text(change.capability, value) for value in (before, change.value.plain()))
        what = values if isinstance(before, bool) else f"{change.capability.replace('_', ' ')} {values}"
        text = f"{label}: {what}, {cause_text(cause)}{end}"
        self._node.log.info(CHANGED, message=text, device=change.device, cause=cause)

    def _log(self, command: CommandChain, ended: JournalNote) -> None:
        """Log a command, unless its issuer has too many lines; then no text is built."""
        note, device = command.notes[0], command.device
        if (held_back := self._limit.allows(note.issuer)) is None:
            return
        outcome = ended.outcome
        by = note.issuer.removeprefix("/").replace("client:", "client ") or "another program"
        wanted = settings_text(note.settings) if note.settings else "a code"
        what = f"text {ended.text!r}, by {by}" if outcome is None else f"{wanted}, by {by}: {outcome.text}"
        text = f"{_label(note, device)} → {what}{more_like_this(held_back)}"
        log = self._node.log.warning if outcome is not None and outcome.is_failure else self._node.log.info
        log(COMMAND, message=text, device=note.device, issuer=note.issuer, command=note.command)

    def _add_turn(self, note: JournalNote, device: Device | None) -> None:
        """Record a command of an app, unless it carries out a person's request."""
        if not note.issuer or is_client(note.issuer) or is_by_hand(note.trigger, note.at):
            return
        wanted = {setting.capability: setting.value.plain() for setting in note.settings}
        sensor = note.trigger.device
        readings = () if sensor == note.device else note.trigger.readings
        sensed = {(sensor, reading.part, reading.capability): reading.value.plain() for reading in readings}
        turn = Turn(note.at, note.issuer, wanted, _label(note, device), sensed)
        fight = self.fights.add((note.device, note.part), turn)
        if fight is not None:
            self._node.log.warning(FIGHT, message=f"{fight.text}; see homebot why {fight.device}", device=note.device)


def _label(place: JournalNote | ChangedSetting, device: Device | None) -> str:
    return place.device if device is None else label_of(device, place.part)
