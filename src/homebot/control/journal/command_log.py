"""Lines of the log: each command with its outcome, each change that no command explains, each fight of apps."""

from __future__ import annotations

from functools import partial
from typing import Final, TypeAlias, final

from homebot.control.command import is_by_hand, label_of
from homebot.control.device_lookup import DeviceLookup
from homebot.control.journal.fights import Fights, Turn
from homebot.control.journal.store import JournalNote
from homebot.control.values import settings_text, value_text
from homebot.devices.client_rights import is_client
from homebot.devices.device import ChangedSetting
from homebot.devices.outcomes import AlreadySo, Gone, Refused, Superseded
from homebot.devices.value import PlainValue
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.log import LogLimit, more_like_this
from homebot.support.bounded_map import BoundedMap

__all__ = ["CommandLog"]

COMMAND: Final = "control.command"
CHANGED: Final = "control.changed"
FIGHT: Final = "control.fight"

_MOST_OPEN: Final = 10_000
_INTERVAL: Final = 60.0
_LINES: Final = 60
"""Lines for the commands of one issuer, or for changes, in a minute; further ones are counted in the next."""

_CAUSES: Final = {"person": "by hand", "device": "by itself"}

_Asked: TypeAlias = tuple[JournalNote, str]
"""The first entry of a command, and its part for people."""


@final
class CommandLog:
    """Logs each command once, from the entries of the journal.

    Args:
        node: For its log and clock.
        lookup: Looks the devices up.

    Attributes:
        fights: The fights of apps.
    """

    def __init__(self, node: Node, lookup: DeviceLookup) -> None:
        self._node = node
        self._lookup = lookup
        self._open: BoundedMap[str, _Asked] = BoundedMap(_MOST_OPEN)
        self._limit = LogLimit(node.graph.clock, _INTERVAL, _LINES)
        self.fights = Fights()

    def begin(self, note: JournalNote, label: str) -> None:
        """Record the first entry of a command, with its part for people."""
        self._open[note.command] = note, label

    def add(self, note: JournalNote) -> None:
        """Log the command that ends with *note*: its outcome is known, or its text was handed to the gateway."""
        match note.kind:
            case "would":  # is logged already
                self._open.pop(note.command, None)
            case "published":
                asked = self._open.pop(note.command, None)
                self._log(asked or (note, note.device), f"text {note.text!r}", "")
                if asked is not None:
                    self._add_turn(*asked)
            case "outcome" if (asked := self._open.pop(note.command, None)) is not None:
                outcome = note.outcome
                if outcome is not None and not isinstance(outcome, AlreadySo):  # nothing was sent
                    is_failure = not outcome.succeeded and not isinstance(outcome, Superseded)
                    self._log(asked, _wanted_text(asked[0]), f": {outcome.text}", is_failure=is_failure)
                if not isinstance(outcome, AlreadySo | Refused | Gone):
                    self._add_turn(*asked)

    def log_change(self, change: ChangedSetting, before: PlainValue, cause: str) -> None:
        """Log a change that no command explains."""
        if (held_back := self._limit.allows("")) is not None:
            self._node.create_task(partial(self._log_change, change, before, cause, more_like_this(held_back)))

    async def _log_change(self, change: ChangedSetting, before: PlainValue, cause: str, end: str) -> None:
        try:
            device = await self._lookup.device(change.device)
        except ServiceError:
            device = None
        label = change.device if device is None else label_of(device, change.part)
        values = f"{value_text(before)} → {value_text(change.value.plain())}"
        what = values if change.capability == "on_off" else f"{change.capability.replace('_', ' ')} {values}"
        why = _CAUSES.get(cause, "by hand or by itself")
        self._node.log.info(CHANGED, message=f"{label}: {what}, {why}{end}", device=change.device, cause=cause)

    def _log(self, asked: _Asked, what: str, end: str, *, is_failure: bool = False) -> None:
        note, label = asked
        if (held_back := self._limit.allows(note.issuer)) is None:
            return
        by = note.issuer.removeprefix("/").replace("client:", "client ") or "another program"
        text = f"{label} → {what}, by {by}{end}{more_like_this(held_back)}"
        log = self._node.log.warning if is_failure else self._node.log.info
        log(COMMAND, message=text, device=note.device, issuer=note.issuer, command=note.command)

    def _add_turn(self, note: JournalNote, label: str) -> None:
        """Record a command of an app, unless it carries out the wish of a person."""
        if not note.issuer or is_client(note.issuer) or is_by_hand(note.trigger, note.at):
            return
        turn = Turn(note.at, note.issuer, {one.capability: one.value.plain() for one in note.settings}, label)
        fight = self.fights.add((note.device, note.part), turn)
        if fight is not None:
            self._node.log.warning(FIGHT, message=f"{fight.text}; see homebot why {fight.device}", device=note.device)


def _wanted_text(note: JournalNote) -> str:
    return settings_text({one.capability: one.value.plain() for one in note.settings}) or "a code"
