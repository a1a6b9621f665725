"""Rooms of apps that act room by room."""

from collections.abc import Iterable
from typing import TypeVar

from homebot.devices.handles import Handle, HandleChange
from homebot.support.folding import fold

HandleT = TypeVar("HandleT", bound=Handle)


def per_handle(change: HandleChange[Handle]) -> Handle:
    """Return the handle of *change*: the key of a reaction whose handles are independent."""
    return change.handle


def per_room(change: HandleChange[Handle]) -> str:
    """Return the room of *change*: the key of a reaction whose rooms are independent."""
    return fold(change.handle.area)


def in_room(handles: Iterable[HandleT], room: str) -> list[HandleT]:
    """Return the *handles* in *room* itself; for a floor, those in none of its rooms.

    Case and accents do not matter. A device without a room is never in *room*.
    """
    return [handle for handle in handles if room and fold(handle.area) == fold(room)]
