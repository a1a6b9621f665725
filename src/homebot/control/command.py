"""A command on its way through the control layer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Final, TypeAlias

from homebot.control import durations
from homebot.control.held_values import COLORS, END_POSITIONS, POWERS, STOPPED, is_on
from homebot.control.timeline.facts import Order
from homebot.control.tolerance import fits
from homebot.devices import Device, DevicePart
from homebot.devices.capabilities import CAPABILITIES, EVENTS, MOMENTARY
from homebot.devices.client_rights import is_client
from homebot.devices.part import Part
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue

if TYPE_CHECKING:
    from homebot.devices.client_rights import ClientRights

__all__ = ["POWER", "IssuedCommand", "order_of", "zero_as_off"]

_LIT: Final = POWERS | COLORS
"""What turns a lamp on."""

_MOTIONS: Final = frozenset({"movement", "position", "tilt"})
"""What sends something with a motor on its way."""

_LEVELS: Final = ("level", "fan_speed")
"""Of these 0 is off."""

_NAME, _READABLE = attrgetter("name"), attrgetter("readable")

POWER: Final = "power_state"
"""Stands for whether a part is on, in the place of a capability."""

_Place: TypeAlias = tuple[str, str, str]


@dataclass(slots=True, eq=False)
class IssuedCommand:
    """Command to one part of a device, with all that is known of it before it is sent; not changed any more.

    Attributes:
        id: The id of the command, unique in the home.
        device: The device, as the directory knew it when the command was given.
        part: The part.
        settings: The wanted values by capability, in the order in which they are sent.
        issuer: Who gave it: the name of a node, or ``client:NAME`` for a client of the door.
        rights: The devices that the issuer may command.
        cause: The id of what led to it; empty for a person's wish.
        trigger: The same with its facts.
        issued_at: Seconds since the Unix epoch.
        transition: Seconds that the change takes.
        code: The code of an alarm or a lock.
        scope: The rights of a client of the door, by its token.
        is_client: Whether a client of the door gave it.
        is_wish: Whether a person wants it: a client gave it, or an app answers a press or a scan of the last minute.
        is_momentary: Whether it presses or starts something, so that to send it again would do it again.
        place: The ids of the device and of the part.
        places: The same with each capability that it sets.
        effects: These, each with the value, and :data:`POWER` with whether that is on, by whichever capability: level 0
            is off.
        target: The id of the device, with ``#`` and the id of the part where it has one.
        moves: Whether it sends something with a motor on its way.
    """

    id: str
    device: Device
    part: DevicePart
    settings: Mapping[str, PlainValue]
    issuer: str
    rights: ClientRights
    cause: str = ""
    trigger: Trigger = NO_TRIGGER
    issued_at: float = 0.0
    transition: float = 0.0
    code: str = field(default="", repr=False)
    scope: tuple[str, ...] = ()
    is_client: bool = field(init=False)
    is_wish: bool = field(init=False)
    is_momentary: bool = field(init=False)
    place: tuple[str, str] = field(init=False)
    places: list[_Place] = field(init=False)
    effects: list[tuple[_Place, PlainValue]] = field(init=False)
    target: str = field(init=False)
    moves: bool = field(init=False)

    def __post_init__(self) -> None:
        """Work out what it is about: everybody on its way asks for that."""
        device, part = self.place = self.device.id, self.part.id
        self.is_client = is_client(self.issuer)
        self.is_wish = self.is_client or _is_by_hand(self.trigger, self.issued_at)
        self.is_momentary = not MOMENTARY.isdisjoint(self.settings)
        self.places, self.effects, self.moves = [], [], False
        for capability, value in self.settings.items():
            place = device, part, capability
            self.places.append(place)
            self.effects.append((place, value))
            if capability in _MOTIONS and value != STOPPED:
                self.moves = True
            if capability in POWERS:
                self.effects.append(((device, part, POWER), is_on(value)))
        self.target = f"{device}#{part}" if part else device

    @property
    def label(self) -> str:
        """The commanded device for people: its id, with the part where several parts take commands."""
        parts = [one for one in self.device.parts if any(can.settable for can in one.part.capabilities)]
        return self.device.id if len(parts) < 2 else self.target

    @property
    def is_always_sent(self) -> bool:
        """True if no report shows that it was done before: a stop, the latch of an unlocked door, a press."""
        return self.is_momentary or any(_is_always_sent(*one) for one in self.settings.items())

    @property
    def opens_further(self) -> bool:
        """True if it opens what is open, but by its own position not all the way."""
        if self.settings.get("movement") != "open":
            return False
        for one in self.device.states:
            if one.capability == "position" and one.part == self.place[1]:
                position = one.value.plain()
                return isinstance(position, float) and not fits("position", END_POSITIONS["open"], position)
        return False

    @property
    def turns_on(self) -> bool:
        """True if the part reports that it is off, and a level, a speed or, for a lamp, a colour turns it on."""
        settings, part = self.settings, self.part.part
        if "on_off" in settings or settings.keys().isdisjoint(_LIT if part.service_type == "light" else POWERS):
            return False
        if settings.get("level") == 0 or settings.get("fan_speed") == 0:
            return False
        for one in self.device.states:
            if one.capability == "on_off" and one.part == self.place[1]:
                return one.live and one.value.plain() is False
        return False

    @property
    def last_reported(self) -> dict[str, PlainValue]:
        """The values that the part had reported last when the command was given, by capability."""
        return {one.capability: one.value.plain() for one in self.device.states if one.part == self.place[1]}

    @property
    def expected(self) -> dict[str, PlainValue]:
        """The values that the part is to report, of those that it reports as lasting ones.

        One that is told to open or to close, and does not report whether it is open, is to report the position.
        """
        told = set(map(_NAME, filter(_READABLE, self.part.part.capabilities)))
        found = {name: value for name, value in self.settings.items() if name in told and name not in MOMENTARY}
        movement = self.settings.get("movement")
        if movement in END_POSITIONS and "position" in told and found.keys().isdisjoint({"movement", "position"}):
            found["position"] = END_POSITIONS[movement]
        return found


def _is_always_sent(capability: str, value: PlainValue) -> bool:
    known = CAPABILITIES.get(capability)
    return known is not None and value in known.always_sent


def _is_by_hand(trigger: Trigger, now: float) -> bool:
    """Return whether *trigger* is a recent press of a button or a scan of a tag."""
    if trigger.kind != "report" or abs(now - trigger.at.to_seconds()) > durations.WISH:
        return False
    return any(one.capability in EVENTS for one in trigger.readings)


def order_of(command: IssuedCommand) -> Order:
    """Return what *command* wants of its part."""
    settings, capabilities = command.settings, command.part.part.capabilities
    return Order(
        command.id,
        settings,
        command.expected,
        command.transition,
        moves=command.moves,
        is_momentary=command.is_momentary,
        opens_further=command.opens_further,
        turns_on=command.turns_on,
        has_ramp=any(one.name == "level" and one.settable for one in capabilities),
        echoed=frozenset([one.name for one in capabilities if one.echoed and one.name in settings]),
        issuer=command.issuer,
        label=command.label,
    )


def zero_as_off(settings: Mapping[str, PlainValue], part: Part) -> Mapping[str, PlainValue]:
    """Return *settings* with ``on_off`` false in place of a level or a speed of 0, where *part* takes that.

    Most lamps that are off report the brightness that they will have, so that they would never report a level of 0.
    """
    if settings.get("level") != 0.0 and settings.get("fan_speed") != 0.0:
        return settings  # as nearly always
    if not any(one.name == "on_off" and one.settable for one in part.capabilities):
        return settings
    others = {name: value for name, value in settings.items() if name not in _LEVELS or value != 0.0}
    return {**others, "on_off": False}  # at last, as to set a colour turns most lamps on
