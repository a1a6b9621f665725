"""Lifts: none is sent to another floor with a door that may be open, or in the session of another. Pure."""

from typing import Final

from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, FactUsed, Verdict
from homebot.devices.lift import DOOR, why_it_stays
from homebot.devices.value_comparison import fits

NAME: Final = "lift"


def check_lift(command: IssuedCommand, _facts: Facts) -> Verdict:
    """Refuse to send a lift that has to stay where it is."""
    floor = command.settings.get("floor")
    if floor is None or fits("floor", floor, command.values.get("floor")):
        return Verdict(NAME, allowed=True)
    door = {one.name: command.values.get(one.name) for one in command.part.part.capabilities if one.name in DOOR}
    why = why_it_stays(command.values, door)
    return Verdict(NAME, not why, why, tuple(FactUsed(*value) for value in door.items()) if why else ())
