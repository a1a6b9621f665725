"""Cause of a report: a command to the part or to one near it, a device by itself, a person, or unknown. Pure."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple, TypeAlias

from homebot.control import durations
from homebot.control.timeline.facts import Attribution, Cause, PartRef, Reported, ReportRole
from homebot.control.timeline.goal import side_role
from homebot.control.timeline.profile import ENOUGH, DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.device import target_of
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import STOPPED, departs, fits

_RESTS: Final = frozenset({"open", "closed", STOPPED})
"""States of a motor at rest."""

Roles: TypeAlias = Iterable[tuple[CommandProgress, ReportRole]]
"""The role of one report for each command that may have caused it, newest first."""


def judge(fact: Reported, roles: Roles) -> Attribution:
    """Return the cause of a report: the only answer to this question; it is stored in the report."""
    if fact.set_by:
        return _told_by_gateway(fact, roles)
    answered, is_led_away = "", False
    for command, role in roles:
        cause = explanation(role, fact, command)
        if cause is not None and not (answered and cause is Cause.TRANSITION):  # it leads away from what is newer
            order, role_told = command.order, None if command.is_raw else role
            return Attribution(cause, order.id, role_told, order.is_foreign, fact.was_absent)
        if role is ReportRole.UNRELATED and command.is_open:
            answered = answered or command.order.id
            is_led_away = command.motion.is_led_away(fact.capability, fact.value)
    cause, along = _cause_without_command(fact)
    if answered and not along and cause is not Cause.DEVICE:  # a person, or the device's own answer
        cause = Cause.PERSON if is_led_away and cause is Cause.PERSON else Cause.UNKNOWN
        return Attribution(cause, answered, ReportRole.UNRELATED, was_absent=fact.was_absent)
    return Attribution(cause, along, was_absent=fact.was_absent)


@dataclass(slots=True, eq=False)
class HeldValue:
    """Value that a lease holds: a fold of the reports and commands of its part as long as the lease lasts.

    Attributes:
        on_report: Called with each report of the value and None, with the first report of another one and its cause.
        is_so: Whether the part is known to have it.
        is_by_hand: Whether the newest report is another value, by a hand.
    """

    capability: str
    value: PlainValue
    profile: DeviceProfile
    on_report: Callable[[PlainValue, Attribution | None], None]
    is_so: bool = False
    is_by_hand: bool = False

    def confirm(self, settings: Mapping[str, PlainValue]) -> None:
        """Record that a command with *settings* has succeeded."""
        self.is_so = self.is_so or settings.get(self.capability) == self.value

    def report(self, capability: str, value: PlainValue, attribution: Attribution) -> None:
        """Record a report and its cause; an intermediate step says nothing."""
        if capability != self.capability or attribution.cause is Cause.TRANSITION:
            return
        has_departed = self.profile.departs(capability, self.value, value)
        self.is_by_hand = has_departed and attribution.is_hand
        if self.profile.fits(capability, self.value, value):
            self.is_so = self.is_so or attribution.cause is not Cause.ECHO
            self.on_report(value, None)
        elif self.is_so and has_departed:
            self.is_so = False
            self.on_report(value, attribution)


def _told_by_gateway(fact: Reported, roles: Roles) -> Attribution:
    """Return the cause that the gateway knows, with the command whose value it ended."""
    cause = Cause.PERSON if fact.set_by == "person" else Cause.PROGRAM
    undone = [command for command, role in roles if role is ReportRole.UNDONE and not command.is_raw]
    return Attribution(cause, undone[0].order.id, ReportRole.UNDONE) if undone else Attribution(cause)


def _cause_without_command(fact: Reported) -> tuple[Cause, str]:
    """Return the cause of a report that no command to its part explains, and the command to another part behind it."""
    if fact.value is None or fact.is_first or fact.is_after_loss or fact.was_absent:
        return Cause.UNKNOWN, ""
    if fact.drifted_from:
        return Cause.DEVICE, fact.drifted_from
    if fact.along:
        return Cause.COMMAND if fact.is_usual else Cause.UNKNOWN, fact.along if fact.is_usual else ""
    if fact.timed >= ENOUGH:
        return Cause.DEVICE, ""
    if fact.by_program is not None:
        return fact.by_program, ""
    return Cause.UNKNOWN if fact.timed and fact.at - fact.since > durations.HASTY else Cause.PERSON, ""


def explanation(role: ReportRole, fact: Reported, command: CommandProgress) -> Cause | None:
    """Return the cause of a report with *role* for *command*; None if the command does not explain it."""
    if role is ReportRole.ECHO:
        return Cause.COMMAND if command.is_raw else Cause.ECHO
    if role is ReportRole.EFFECT:
        return Cause.COMMAND
    if role is ReportRole.STEP:
        return Cause.TRANSITION
    if fact.is_after_loss or fact.was_absent:
        return None
    if role is ReportRole.UNDONE:
        return _cause_of_undoing(fact, command)
    if role is ReportRole.DEVIATES:
        return Cause.UNKNOWN
    if role is ReportRole.MATCHES:
        return Cause.COMMAND if _came_along(fact, command) else None
    return Cause.COMMAND if role is ReportRole.SIDE_EFFECT and rests_where_sent(fact, command) else None


def _cause_of_undoing(fact: Reported, command: CommandProgress) -> Cause:
    """Return the cause of the end of a commanded value."""
    if fact.timed >= ENOUGH or fact.capability in command.suspected:
        return Cause.DEVICE
    is_by_hand = fact.was_kept and not (fact.timed or fact.along or command.may_be_taken_back(fact))
    return Cause.PERSON if is_by_hand else Cause.UNKNOWN


def _came_along(fact: Reported, command: CommandProgress) -> bool:
    """Return whether a value that is consistent with a command came while it was open, or soon after a sign of it."""
    if command.is_open:
        return True
    sendings, is_unread = command.transmission, command.is_raw and not command.wanted
    signs = (sendings.sent_at, command.motion.moved_at, *command.met_times, *sendings.accepted.values())
    return fact.at - max(signs) <= (durations.UNREAD if is_unread else durations.CAME_ALONG)


def rests_where_sent(fact: Reported, command: CommandProgress) -> bool:
    """Return whether a cover arrived: halfway it reports open, stopped, or closed until it reports its position."""
    return fact.value in _RESTS and any(abs(fact.at - met) <= durations.CAME_ALONG for met in command.met_times)


MAX_NEARBY: Final = 32
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
                order, sendings = command.order, command.transmission
                is_own = order.place == place or order.id == fact.attribution.command  # or that to its group
                if is_own or not sendings.count or fact.at < sendings.first_sent_at:
                    continue
                is_open = known is self.device and command.is_open  # it may answer slowly
                signs = (sendings.first_sent_at, sendings.sent_at, *command.met_times)
                if is_open or any(abs(fact.at - at) <= durations.CAME_ALONG for at in signs):
                    fact.along = order.id
                    fact.is_usual = _is_usual(fact, place, command, known, profile)
                    return


NOWHERE: Final = Nearby(deque(maxlen=0), deque(maxlen=0))


def _is_usual(
    fact: Reported, place: PartRef, command: CommandProgress, known: NearbyCommands, profile: DeviceProfile
) -> bool:
    """Return whether the part usually changes along with commands to that other part; learn that it did."""
    order, capability = command.order, fact.capability
    wanted = order.settings.get(capability)
    if wanted is None and side_role(order, capability, fact.value) is not ReportRole.MATCHES:
        return False
    if wanted is not None and not fits(capability, wanted, fact.value):
        return False
    is_missed = False
    for earlier in known:  # to the same part, since it had the value before
        if earlier.order.place == order.place and fact.since < earlier.given_at < command.given_at:
            wanted = earlier.order.settings.get(capability)
            did_not_follow = wanted is not None and departs(capability, wanted, fact.previous)
            is_missed = is_missed or (did_not_follow and place not in earlier.followers)
    command.followers |= {place}
    return profile.learn_pair(target_of(*order.place), is_missed=is_missed)
