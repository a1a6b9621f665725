"""A command in the control layer, with its part and the values that are certain for it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from math import inf
from operator import attrgetter
from typing import TYPE_CHECKING, Final

from homebot.control import durations
from homebot.control.journal.given_codes import MAX_NOTED_CHARACTERS, UNREAD, public_text, without_codes
from homebot.control.timeline.facts import Order
from homebot.devices import Device, DevicePart, State
from homebot.devices.always_ask import why_it_asks
from homebot.devices.capabilities import EVENTS, LIGHTS_UP, MOMENTARY, is_told_once
from homebot.devices.client_rights import CLIENT
from homebot.devices.command_messages import Setting
from homebot.devices.device import is_commanded, target_of
from homebot.devices.part import Part
from homebot.devices.text.commands import decode_command, part_at
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import COLORS, END_POSITIONS, POWERS, STOPPED, fits, is_same
from homebot.devices.wording.journal_words import settings_text
from homebot.errors import RefusedError

if TYPE_CHECKING:
    from homebot.clock import Clock
    from homebot.control.shared_sending import SharedSending
    from homebot.control.timeline.part_timeline import PartTimeline
    from homebot.devices.client_rights import ClientRights
    from homebot.devices.command_sender import TextTarget

_LIT: Final = POWERS | COLORS
"""Capabilities that turn a lamp on."""

_MOTIONS: Final = frozenset({"movement", "position", "tilt", "floor"})
"""Capabilities of motors."""

_LEVELS: Final = ("level", "fan_speed")
"""Capabilities whose value 0 is off."""

_SETPOINTS: Final = ("heating_setpoint", "cooling_setpoint")
"""Sent last, as some thermostats have others in each mode."""

_NO_ECHO: Final[frozenset[str]] = frozenset()


@dataclass(slots=True, eq=False)
class IssuedCommand:
    """Command to one part of a device, with the state known before it is sent; immutable.

    Attributes:
        id: The id of the command, unique in the home.
        settings: The wanted values by capability, in the order of sending.
        in_order: The same as they are sent: at the end again a mode that many thermostats leave for a setpoint.
        issuer: The name of a node, or ``client:NAME`` for a client of the door.
        issued_at: Seconds since the Unix epoch.
        transition: Seconds that the change takes.
        nearest: The numbers of *settings* that the device can do in place of those asked, as a clause for the outcome.
        scope: The rights of a client of the door, by its token.
        text: The raw text that is sent for its settings, once and unverified; None for a command by values.
        has_code: Whether one of *settings* is a code, which nothing shows.
        states: The states of the part at the time of the command, by capability.
        values: Their values.
        why_it_asks: Why the part is one that always asks; empty if it is not.
        warnings: By policy, the reasons why it might better not be given; the outcome shows them.
        shared: The message to a group that may take the place of its first sending; None for none.
        members: The parts that it sets too, as a command to a group does.
    """

    id: str
    device: Device
    part: DevicePart
    settings: Mapping[str, PlainValue]
    issuer: str
    rights: ClientRights
    trigger: Trigger = NO_TRIGGER
    issued_at: float = 0.0
    scope: tuple[str, ...] = ()
    text: TextTarget | None = field(default=None, repr=False)
    transition: float = 0.0
    override: bool = False
    code: str = field(default="", repr=False)
    nearest: str = ""
    is_client: bool = field(init=False)
    in_order: Sequence[tuple[str, PlainValue]] = field(init=False)
    place: tuple[str, str] = field(init=False)
    states: dict[str, State] = field(init=False)
    values: dict[str, PlainValue] = field(init=False)
    why_it_asks: str = field(init=False)
    warnings: dict[str, str] = field(default_factory=dict)
    shared: SharedSending | None = field(default=None, repr=False)
    members: Sequence[tuple[Device, DevicePart]] = ()
    has_code: bool = False

    def __post_init__(self) -> None:
        self.place = self.device.id, self.part.id
        self.states, self.values = {}, {}
        for state in self.device.states:
            if state.part == self.part.id:
                self.states[state.capability], self.values[state.capability] = state, state.value.plain()
        if len(self.settings) > 1:
            self.settings = _order(self.settings, self.values)
        mode = self.settings.get("thermostat_mode")
        is_left = mode not in {None, "off", "heat", "cool"} and not self.settings.keys().isdisjoint(_SETPOINTS)
        self.in_order = [*self.settings.items(), *([("thermostat_mode", mode)] if is_left else [])]
        self.why_it_asks = why_it_asks(self.device, self.part)
        self.is_client = self.issuer.startswith(CLIENT)

    @property
    def target(self) -> str:
        """The id of the device, with ``#`` and the id of the part if it has one."""
        return target_of(*self.place)

    @property
    def is_by_person(self) -> bool:
        """True if a client gave it, or an app in response to a press, a scan or a client's call in the last minute."""
        return self.is_client or is_by_hand(self.trigger, self.issued_at)

    @property
    def label(self) -> str:
        """The commanded device for people; see :func:`label_of`."""
        return label_of(self.device, self.part.id)

    def public(self, values: Mapping[str, PlainValue] | None = None) -> tuple[Setting, ...]:
        """Return *values* of the part, by default the wanted ones, for people: without codes."""
        values = self.settings if values is None else values
        return without_codes(tuple(map(Setting.of, values, values.values())), self.device, self.part)


def _order(settings: Mapping[str, PlainValue], values: Mapping[str, PlainValue]) -> Mapping[str, PlainValue]:
    """Return *settings* in an order in which no thermostat is to heat to more than it cools to.

    A lamp or fan gets its level first, so that it never is as bright or fast as before, and is turned on last.
    """
    wanted, before = settings.get("heating_setpoint"), values.get("heating_setpoint")
    rises = isinstance(wanted, float) and isinstance(before, float) and wanted > before
    last = _SETPOINTS[::-1] if rises else _SETPOINTS
    is_last = settings.get("on_off") is True and not (LIGHTS_UP | {"fan_speed"}).isdisjoint(settings)
    order = ("level", "", *(("on_off",) if is_last else ()), *last)
    return dict(sorted(settings.items(), key=lambda one: order.index(one[0] if one[0] in order else "")))


def is_by_hand(trigger: Trigger, now: float) -> bool:
    """Return whether *trigger* is a recent press of a button, scan of a tag or call of a client."""
    if trigger.kind not in {"report", "client"} or abs(now - trigger.at.to_seconds()) > durations.WISH:
        return False
    return trigger.kind == "client" or any(reading.capability in EVENTS for reading in trigger.readings)


def label_of(device: Device, part_id: str) -> str:
    """Return the id of the device for people, plus that of the part if others, except settings, take commands."""
    if len(device.parts) < 2 or not part_id:
        return device.id
    takes = [part for part in device.parts if part.id == part_id or is_commanded(part.part)]
    return device.id if len(takes) < 2 else f"{device.id}#{part_id}"


def order_of(command: IssuedCommand) -> Order:
    """Return *command* as an order for the timeline."""
    settings, wanted, part = command.settings, dict[str, PlainValue](), command.part.part
    echoed, has_ramp, moves, opens_further = _NO_ECHO, False, False, False
    is_told = bool(command.text or command.code or command.why_it_asks)  # a second attempt with its code may count
    for capability in part.capabilities:
        name = capability.name
        if name in settings:
            if capability.readable and name not in MOMENTARY:
                wanted[name] = settings[name]
            if capability.echoed:
                echoed |= {name}
        if name == "level":
            has_ramp = capability.settable
    if not _MOTIONS.isdisjoint(settings):
        moves, opens_further = (
            any(settings.get(capability, STOPPED) != STOPPED for capability in _MOTIONS),
            _opens_further(command),
        )
        if wanted.keys().isdisjoint(_MOTIONS):
            wanted |= _end_position(settings, part)
    return Order(
        command.id,
        settings,
        wanted,
        command.transition,
        moves=moves,
        is_told_once=is_told or is_told_once(part.service_type, settings),
        opens_further=opens_further,
        turns_on=command.values.get("on_off") is False and _turns_on(command),
        has_ramp=has_ramp,
        echoed=echoed,
        place=command.place,
        issuer=command.issuer,
        label=label_of(command.device, command.part.id),
        trigger=command.trigger,
    )


def _opens_further(command: IssuedCommand) -> bool:
    """Return whether *command* opens a part that is open already, but not fully."""
    position = command.values.get("position")
    if command.settings.get("movement") != "open" or not isinstance(position, float):
        return False
    return not fits("position", END_POSITIONS["open"], position)


def _end_position(settings: Mapping[str, PlainValue], part: Part) -> Mapping[str, PlainValue]:
    """Return the position that shows the end of a movement, if *part* does not report the movement itself."""
    position = END_POSITIONS.get(settings.get("movement"))
    is_reported = any(capability.name == "position" and capability.readable for capability in part.capabilities)
    return {"position": position} if is_reported and position is not None else {}


def _turns_on(command: IssuedCommand) -> bool:
    """Return whether a level, a speed or, for a lamp, a colour turns on the part, which reports that it is off."""
    settings = command.settings
    if "on_off" in settings or not command.states["on_off"].live:
        return False
    if settings.get("level") == 0 or settings.get("fan_speed") == 0:
        return False
    return not settings.keys().isdisjoint(_LIT if command.part.part.service_type == "light" else POWERS)


def device_settings(settings: Mapping[str, PlainValue], part: Part) -> Mapping[str, PlainValue]:
    """Return *settings* as *part* can take them: numbers of its grids, and off in place of a level or a speed of 0.

    Most lamps that are off report the brightness that they will have when turned on, and never a level of 0.
    """
    for capability in part.capabilities:
        if capability.grid and isinstance(value := settings.get(capability.name), float):
            settings = {**settings, capability.name: capability.nearest(value)}
    if 0.0 not in map(settings.get, _LEVELS):
        return settings  # as nearly always
    if not any(capability.name == "on_off" and capability.settable for capability in part.capabilities):
        return settings
    others = {name: value for name, value in settings.items() if name not in _LEVELS or value != 0.0}
    return {**others, "on_off": False}  # last, because setting a colour turns most lamps on


def rounding_text(asked: Mapping[str, PlainValue], settings: Mapping[str, PlainValue]) -> str:
    """Return a clause with the numbers of *settings* that are not those *asked*; empty if all are."""
    rounded = [
        setting
        for setting in settings.items()
        if setting[0] in asked and not is_same(setting[0], asked[setting[0]], setting[1])
    ]
    done = settings_text(map(Setting.of, *zip(*rounded, strict=True))) if rounded else ""
    return f"{done} is what the device can do" if done else ""


def commanded_part(device: Device | None, part_id: str, settings: Iterable[Setting]) -> DevicePart | None:
    """Return the part with the id *part_id*; without one, the only part that takes all *settings*, or that there is.

    A part that is a setting is returned only if no other part takes them. None if there is no such part, or several.
    """
    if device is None:
        return None
    part = device.part(part_id)
    if part is not None or part_id:
        return part
    wanted = set(map(attrgetter("capability"), settings))
    able = [part for part in device.parts if wanted <= {can.name for can in part.part.capabilities if can.settable}]
    parts = [part for part in able or device.parts if not part.part.category] or able
    return parts[0] if len(parts) == 1 else None


def read_text(device: Device | None, text: TextTarget) -> tuple[DevicePart, Setting]:
    """Return the part of *device* at the address of *text*, or a stand-in for it, and the setting that *text* means.

    The case and surrounding spaces of a word may differ. Of a long text, and of one that is not understood, the setting
    is what the journal may show.
    """
    part = None if device is None else part_at(device, text.gateway, text.address)
    if part is None:
        kind = "" if device is None else device.service_type
        part = DevicePart(id="", part=Part(id="", service_type=kind), routes=())
    for words in (text.payload, text.payload.strip().casefold()):
        with suppress(RefusedError):
            capability, value = decode_command(words, part.part)
            return part, Setting.of(capability, value[:MAX_NOTED_CHARACTERS] if isinstance(value, str) else value)
    return part, Setting.of(UNREAD, public_text(text.payload, text.address)[:MAX_NOTED_CHARACTERS])


def certain_values(
    command: IssuedCommand, asked: Iterable[str], timeline: PartTimeline, lost_at: float, clock: Clock
) -> tuple[dict[str, PlainValue], bool]:
    """Return the values of the capabilities *asked* that are certain for the commanded part, and if all are recent.

    Recent values were reported live within the last minute, since the connection was lost.

    Nothing is certain of an unreachable device. If one is online by its last will, retained values are certain, and so
    are those from before the connection was lost: many devices report only changes. They are not recent if the device
    has come back since, because it may have lost power. See also
    :meth:`PartTimeline.certain`.

    Args:
        lost_at: The time of the last loss of the connection, in seconds since the Unix epoch.
    """
    is_online = command.device.reachable.state == "yes"
    if command.device.reachable.state == "no" or not (is_online or command.device.freshness == "fresh"):
        return {}, False
    back_at = command.device.reachable.since.to_seconds() if is_online else -inf
    values: dict[str, PlainValue] = {}
    are_recent, now = list[bool](), clock.monotonic()
    ahead = clock.now() - now
    for capability in asked:
        state = command.states.get(capability)
        if state is None or not (state.live or is_online):
            continue
        told_at = state.told_at.to_seconds()
        is_fresh = state.live and abs(command.issued_at - told_at) <= durations.FRESH
        are_recent.append(is_fresh and lost_at < told_at >= back_at)
        value = timeline.certain(capability, command.values[capability], told_at - ahead, now)
        if value is not None and (is_online or told_at > lost_at):
            values[capability] = value
    return values, all(are_recent)
