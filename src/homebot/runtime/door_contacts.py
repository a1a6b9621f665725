"""The contacts on doors that the presence guard is told of, held against the plan of the house. Pure."""

from __future__ import annotations

from collections.abc import Mapping

from homebot.errors import ConfigError
from homebot.places import HousePlan
from homebot.support.similar import did_you_mean

__all__ = ["check_door_contacts"]

_KEY = "control.presence_guard.doors"


def check_door_contacts(doors: Mapping[str, tuple[str, ...]], plan: HousePlan, source: str) -> None:
    """Check that each room is in *plan*, where that has rooms, and that no door of it is without a contact.

    Raises:
        ConfigError: One is not; names the key and the reason.
    """
    if not plan.rooms:
        return
    for name, contacts in doors.items():
        room = plan.room(name)
        if room is None:
            known = [one.name for one in plan.rooms]
            hint = did_you_mean(name, known, f"rooms are {', '.join(known)}")
            raise ConfigError(source, f"{_KEY}.{name}", f"there is no room {name!r}; {hint}")
        if len(contacts) < len(room.doors):
            joined = f"{len(room.doors)} doors (to {', '.join(room.doors)})"
            problem = f"{room.name} has {joined}, and only {len(contacts)} of them a contact; it takes one on each"
            raise ConfigError(source, f"{_KEY}.{name}", problem)
