"""Log lines: each command with its outcome, each change that no command explains, each fight of apps."""

import asyncio
from collections import deque
from contextlib import suppress
from functools import partial
from typing import Final, TypeAlias, final

from homebot.control.command import is_by_hand, label_of
from homebot.control.journal.fights import Fights, Turn
from homebot.devices import Device
from homebot.devices.client_rights import is_client
from homebot.devices.device import ChangedSetting
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.outcomes import AlreadySo, Gone, Refused
from homebot.devices.value import PlainValue
from homebot.devices.wording.journal_words import settings_text
from homebot.devices.wording.values import value_text
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.journal.store import JournalNote
from homebot.log import LogLimit, more_like_this

__all__ = ["CommandLog"]

COMMAND: Final = "control.command"
CHANGED: Final = "control.changed"
FIGHT: Final = "control.fight"

_MOST_OPEN: Final = 10_000
_INTERVAL: Final = 60.0
_LINES: Final = 60
"""Lines a minute for the commands of one issuer, or for changes; the next minute's line counts the others."""

_CAUSES: Final = {"person": "by hand", "device": "by itself"}

_Asked: TypeAlias = tuple[JournalNote, Device | None]
"""The first entry of a command, and its device."""

_DELAY: Final = 0.05
"""Seconds after which lines are written, so that commands do not wait for them."""

ENDS: Final = frozenset({"would", "published", "outcome"})
"""Kinds of entries that end a command."""


@final
class CommandLog:
    """Logs each command once, from the entries of the journal.

    Attributes:
        open: The first entry, and the device, of each command without an end.
    """

    def __init__(self, node: Node, lookup: DeviceLookup) -> None:
        self._node = node
        self._lookup = lookup
        self.open: dict[str, _Asked] = {}
        self._ended: deque[tuple[JournalNote, _Asked | None]] = deque()
        self._limit = LogLimit(node.graph.clock, _INTERVAL, _LINES)
        self.fights = Fights()

    def end(self, note: JournalNote) -> None:
        """Log, after a short delay, the command that ends with *note*, which is one of :data:`ENDS`."""
        if not self._ended:
            asyncio.get_running_loop().call_later(_DELAY, self.write)
        self._ended.append((note, self.open.pop(note.command, None)))

    def write(self) -> None:
        """Write the pending lines."""
        while self._ended:
            self._write(*self._ended.popleft())
        while len(self.open) > _MOST_OPEN:
            del self.open[next(iter(self.open))]

    def _write(self, note: JournalNote, asked: _Asked | None) -> None:
        if note.kind == "published":
            self._log(asked or (note, None), note)
        if note.kind == "would" or asked is None:  # already logged
            return
        outcome = note.outcome
        if outcome is not None and not isinstance(outcome, AlreadySo):  # nothing was sent
            self._log(asked, note)
        if not isinstance(outcome, AlreadySo | Refused | Gone):
            self._add_turn(*asked)

    def log_change(self, change: ChangedSetting, before: PlainValue, cause: str) -> None:
        """Log a change that no command explains."""
        if (held_back := self._limit.allows("")) is not None:
            self._node.create_task(partial(self._log_change, change, before, cause, more_like_this(held_back)))

    async def _log_change(self, change: ChangedSetting, before: PlainValue, cause: str, end: str) -> None:
        device = None
        with suppress(ServiceError):
            device = await self._lookup.device(change.device)
        label = _label(change, device)
        values = " → ".join(value_text(change.capability, one) for one in (before, change.value.plain()))
        what = values if isinstance(before, bool) else f"{change.capability.replace('_', ' ')} {values}"
        why = _CAUSES.get(cause, "by hand or by itself")
        self._node.log.info(CHANGED, message=f"{label}: {what}, {why}{end}", device=change.device, cause=cause)

    def _log(self, asked: _Asked, ended: JournalNote) -> None:
        """Log a command, unless its issuer has too many lines; then no text is built."""
        note, device = asked
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
        wanted = {one.capability: one.value.plain() for one in note.settings}
        sensor = note.trigger.device
        readings = () if sensor == note.device else note.trigger.readings
        sensed = {(sensor, one.part, one.capability): one.value.plain() for one in readings}
        turn = Turn(note.at, note.issuer, wanted, _label(note, device), sensed)
        fight = self.fights.add((note.device, note.part), turn)
        if fight is not None:
            self._node.log.warning(FIGHT, message=f"{fight.text}; see homebot why {fight.device}", device=note.device)


def _label(place: JournalNote | ChangedSetting, device: Device | None) -> str:
    return place.device if device is None else label_of(device, place.part)
