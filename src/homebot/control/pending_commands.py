"""The commands whose outcome is not known yet."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.held_values import changes, related
from homebot.control.pending import PendingCommand

__all__ = ["PendingCommands"]

_Place: TypeAlias = tuple[str, str, str]


@final
class PendingCommands:
    """The commands that wait for their outcomes.

    Attributes:
        newest: The newest one of each capability of a part; for reading.
    """

    def __init__(self) -> None:
        self.newest: dict[_Place, PendingCommand] = {}

    def has_any(self, places: Iterable[_Place]) -> bool:
        """Return whether a command for one of *places* waits: a device, a part and a capability each."""
        return any(one in self.newest for one in places)

    def wants_otherwise(self, command: IssuedCommand) -> bool:
        """Return whether a command that waits would change what *command* sets."""
        for capability, value in command.settings.items():
            older = self.newest.get((*command.place, capability))
            if older is not None and changes(capability, older.command.settings[capability], capability, value):
                return True
        return False

    def put(self, pending: PendingCommand) -> None:
        """Add *pending*, after :meth:`supersede`."""
        for place in pending.command.places:
            self.newest[place] = pending

    def remove(self, pending: PendingCommand) -> None:
        """Forget *pending*; a newer one stays."""
        for place in pending.command.places:
            if self.newest.get(place) is pending:
                del self.newest[place]

    def supersede(self, command: IssuedCommand) -> None:
        """End the older commands for what *command* sets, and those whose values it changes.

        A level that is sent again would turn on a lamp that *command* turned off, and a position would open what it
        closed.
        """
        device, part = command.place
        for capability, value in command.settings.items():
            for other in related(capability):
                older = self.newest.get((device, part, other))
                if older is None:
                    continue
                if other == capability or changes(other, older.command.settings[other], capability, value):
                    older.supersede(command.id)
