"""Commands to the parts near one part, along with which it may change: of one relay, group, scene or room. Pure."""

from collections import deque
from typing import Final, NamedTuple, TypeAlias

from homebot.control import durations
from homebot.control.timeline.facts import Order, PartRef, Reported, ReportRole
from homebot.control.timeline.goal import side_role
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.device import target_of
from homebot.devices.obedience import departs, fits

__all__ = ["MOST_NEARBY", "NOWHERE", "Nearby", "NearbyCommands"]

MOST_NEARBY: Final = 32
"""The limit of commands to one device, and to one room; older ones are dropped."""

NearbyCommands: TypeAlias = deque[CommandProgress]
"""The newest commands to one device, or to one room, oldest first."""


class Nearby(NamedTuple):
    """The commands to the device of a part, and to its room, each shared by all parts there."""

    device: NearbyCommands
    room: NearbyCommands

    def explain(self, fact: Reported, place: PartRef, profile: DeviceProfile) -> None:
        """Record in *fact*, a change of *place*, the command to another part that it came along with, and learn it."""
        for known in self:
            for command in reversed(known):
                is_open = known is self.device and command.is_open
                if command.order.place != place and _is_along(fact.at, command, is_open=is_open):
                    fact.along = command.order.id
                    fact.is_usual = _is_usual(fact, place, command, known, profile)
                    return


NOWHERE: Final = Nearby(deque(maxlen=0), deque(maxlen=0))


def _is_along(at: float, command: CommandProgress, *, is_open: bool) -> bool:
    """Return whether a change came with a sign of *command*, or, of a device that answers slowly, while it is open."""
    if not command.sendings or at < command.first_sent_at:
        return False
    signs = (command.first_sent_at, command.sent_at, *command.met_times)
    return is_open or any(abs(at - one) <= durations.CAME_ALONG for one in signs)


def _is_usual(
    fact: Reported, place: PartRef, command: CommandProgress, known: NearbyCommands, profile: DeviceProfile
) -> bool:
    """Return whether the part usually changes along with commands to that other part; learn that it did."""
    order = command.order
    if not _agrees(order, fact):
        return False
    earlier = [one for one in known if one.order.place == order.place and fact.since < one.given_at < command.given_at]
    is_missed = any(_is_missed(one, fact, place) for one in earlier)
    command.followers |= {place}
    return profile.learn_pair(target_of(*order.place), is_missed=is_missed)


def _agrees(order: Order, fact: Reported) -> bool:
    wanted = order.settings.get(fact.capability)
    if wanted is None:
        return side_role(order, fact.capability, fact.value) is ReportRole.AGREES
    return fits(fact.capability, wanted, fact.value)


def _is_missed(command: CommandProgress, fact: Reported, place: PartRef) -> bool:
    """Return whether the part did not follow an earlier *command* to the same part, since it had the value before."""
    wanted = command.order.settings.get(fact.capability)
    return place not in command.followers and wanted is not None and departs(fact.capability, wanted, fact.previous)
