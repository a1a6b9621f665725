"""Recent changes of what sensors may see in place of the effect of a command. Pure."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator
from typing import Final, TypeAlias, final

__all__ = ["Place", "RecentActivity"]

_KEPT: Final = 512

Place: TypeAlias = tuple[str, str]
"""The ids of a device and of a part."""


@final
class RecentActivity:
    """The last 512 changes of parts that act, and the commands on their way; of older changes nothing is known.

    Attributes:
        commands: The ids of the commands on their way, each with its part.
        known_since: The time before which changes were forgotten.
    """

    def __init__(self) -> None:
        self._changes: deque[tuple[float, Place]] = deque(maxlen=_KEPT)
        self.commands: dict[str, Place] = {}
        self._under_way: Counter[Place] = Counter()
        self.known_since = -float("inf")

    def note(self, place: Place, at: float) -> None:
        """Note that a part changed."""
        if len(self._changes) == _KEPT:
            self.known_since = self._changes[0][0]
        self._changes.append((at, place))

    def begin(self, command_id: str, place: Place) -> bool:
        """Note that a command is on its way: the part may change at any time; return whether no other is."""
        self.commands[command_id] = place
        self._under_way[place] += 1
        return self._under_way[place] == 1

    def end(self, command_id: str, at: float) -> None:
        """Note that a command is over."""
        if (place := self.commands.pop(command_id, None)) is None:
            return
        self._under_way[place] -= 1
        if not self._under_way[place]:
            del self._under_way[place]
        self.note(place, at)

    def since(self, at: float, but: str) -> Iterator[tuple[float, Place]]:
        """Yield the changes since *at*, and the other commands than *but* on their way, with the time of each.

        What is on its way has the time infinity.
        """
        yield from ((changed_at, place) for changed_at, place in self._changes if changed_at >= at)
        yield from ((float("inf"), place) for name, place in self.commands.items() if name != but)
