"""Values of the devices of a house in the words of routines; each text is read back, and must mean that value. Pure."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Final, NamedTuple, final

from homebot.devices import Device, DevicePart
from homebot.devices.always_ask import always_asks
from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.devices.command_messages import CommandDevicesRequest
from homebot.devices.device import State
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.value import PlainValue, Value
from homebot.devices.wording.values import value_text
from homebot.errors import UsageError
from homebot.messages.builtin_interfaces import Time
from homebot.support.folding import fold
from homebot.words.conditions import Matches, read_condition
from homebot.words.queries import parse_query
from homebot.words.steps import Do, read_step
from homebot.words.suitable_parts import settings_by_part
from homebot.words.triggers import Becomes, PersonMoves, Press, read_trigger

_MAX_CHARACTERS: Final = 80
_STEPS: Final = {"%": 5.0, "°C": 0.5}
_PEOPLE: Final = {"x_person": ("{} has left", "{} arrives"), "x_household": ("everybody has left", "somebody arrives")}
_PRESENCE: Final[Mapping[str, Sequence[tuple[str, str, bool]]]] = {
    "x_person": (("{} is home", "at_home", True), ("{} is away", "at_home", False)),
    "x_household": (
        ("somebody is home", "at_home", True),
        ("nobody is home", "at_home", False),
        ("everybody is home", "all_at_home", True),
    ),
}
_NO_TIME: Final = Time(sec=0, nanosec=0)


class WatchedRoom(NamedTuple):
    """A room with a sensor of presence.

    Attributes:
        texts: The conditions that somebody is there, and that nobody is.
        sensors: The ids of the sensors.
        devices: The ids of all devices there.
    """

    texts: tuple[str, str]
    sensors: tuple[str, ...]
    devices: frozenset[str]


@final
class DeviceWords:
    """The words for *devices*. A value that no text means, or that several devices share, has an empty one.

    Attributes:
        areas: Their rooms, sorted.
    """

    def __init__(self, devices: Sequence[Device]) -> None:
        self._devices = {device.id: device for device in devices}
        self._facets = [facets_of(device) for device in devices]
        self._named = Counter(fold(name) for device in devices for name in {device.name, *device.names})
        self.areas = sorted({device.area for device in devices if device.area})
        self.reference = lru_cache(None)(self._reference)
        self.trigger = lru_cache(None)(self._trigger)
        self.press = lru_cache(None)(self._press)
        self.step = lru_cache(None)(self._step)

    def people(self) -> Mapping[str, str]:
        """Return the conditions that somebody is at home, with the device of the person or the household."""
        people = (device_id for device_id, device in self._devices.items() if device.service_type in _PRESENCE)
        return {texts[0]: device_id for device_id in people if (texts := self.presence(device_id))}

    def presence(self, device_id: str) -> Sequence[str]:
        """Return the conditions about a person or the household: at home, and away; none for another device."""
        device = self._devices[device_id]
        rows = _PRESENCE.get(device.service_type, ())
        texts = ((text.format(device.name), capability, value) for text, capability, value in rows)
        return [text for text, capability, value in texts if _holds(text, device, capability, value=value)]

    def rooms(self) -> Sequence[WatchedRoom]:
        """Return the rooms with sensors of presence."""
        rooms: list[WatchedRoom] = []
        for area in dict.fromkeys(device.area for device in self._devices.values() if device.area):
            texts = f"somebody in {area}", f"nobody in {area}"
            there = [device for device in self._devices.values() if fold(device.area) == fold(area)]
            if sensors := tuple(device.id for device in there if _holds(texts[0], device, "occupancy", value=True)):
                rooms.append(WatchedRoom(texts, sensors, frozenset(device.id for device in there)))
        return rooms

    def _reference(self, device_id: str) -> str:
        """Return the words that mean this device alone: its name if that is clear, or ``name="…"``."""
        device = self._devices.get(device_id)
        name = "" if device is None else " ".join(device.name.split())
        if (
            not name
            or len(name) > _MAX_CHARACTERS
            or '"' in name
            or not name.isprintable()
            or self._named[fold(name)] != 1
        ):
            return ""
        try:
            query = parse_query(name)
        except UsageError:
            return f'name="{name}"'
        ids = [facets.id for facets in self._facets if fits(query, facets)]
        return name if ids == [device_id] else f'name="{name}"'

    def _trigger(self, device_id: str, part: str, capability: str, value: PlainValue) -> str:
        """Return the trigger that this value starts."""
        device = self._devices.get(device_id)
        if device is None or not self._is_clear(device, part, capability):
            return ""
        if (moves := _PEOPLE.get(device.service_type)) is not None and capability == "at_home":
            text = moves[bool(value)].format(device.name)
            return text if isinstance(_read(text), PersonMoves) else ""
        for text in _texts(self.reference(device_id), capability, value, " = "):
            read = _read(text)
            if isinstance(read, Becomes) and _means(read, device, part, capability, value=value):
                return text
        return ""

    def limit(self, device_id: str, part: str, capability: str, number: float, sign: str) -> str:
        """Return the trigger that a value ``below`` or ``above`` *number* starts, as *sign* says."""
        device, reference = self._devices.get(device_id), self.reference(device_id)
        if device is None or not reference or not self._is_clear(device, part, capability):
            return ""
        name, limit = capability.replace("_", " "), value_text(capability, number)
        beyond, within = (number - 1.0, number + 1.0) if sign == "below" else (number + 1.0, number - 1.0)
        for text in (f"{name} of {reference} {sign} {limit}", f"{reference} {name} {sign} {limit}"):
            read = _read(text)
            if (
                isinstance(read, Becomes)
                and _means(read, device, part, capability, value=beyond)
                and not _means(read, device, part, capability, value=within)
            ):
                return text
        return ""

    def _press(self, device_id: str, part: str, value: str) -> str:
        """Return the trigger that the press *value* starts; it names the button if there are several."""
        device, reference = self._devices.get(device_id), self.reference(device_id)
        if device is None or not (reference and value and value.isprintable()):
            return ""
        buttons = [button for button in device.parts if any(can.name in EVENTS for can in button.part.capabilities)]
        button = f"{reference}#{part}" if len(buttons) > 1 else reference
        for text in (f"{button} press {value}", f'{button} press "{value}"'):
            read = _read(text)
            if isinstance(read, Press) and read.value == value.casefold() and fits(read.query, facets_of(device)):
                return text if [button.id for button in read.buttons(buttons)] == [part] else ""
        return ""

    def command(self, device_id: str, part: str, capability: str, value: PlainValue) -> str:
        """Return the step that sets this value, rounded; of one of several parts that have it, by their ids."""
        device = self._devices.get(device_id)
        own = next((candidate for candidate in device.parts if candidate.id == part), None) if device else None
        if device is None or own is None or own.part.category or _is_passing(own, capability, value):
            return ""
        is_clear = self._is_clear(device, part, capability)
        reference, parts = (self.reference(device_id), device.parts) if is_clear else (f"{device_id}#{part}", (own,))
        value = rounded(capability, value)
        verbs = CAPABILITIES.get(capability, OWN).words.items() if not isinstance(value, float) else ()
        done = next((verb for verb, result in verbs if result == value), value)
        for text in _texts(reference, capability, done, " "):
            if _sets(text, reference, device, parts) == (part, {capability: value}):
                return text
        return ""

    def _step(self, device_id: str, part: str, capability: str, value: PlainValue) -> str:
        """Return the same; none for a part that always asks."""
        device = self._devices.get(device_id)
        own = next((candidate for candidate in device.parts if candidate.id == part), None) if device else None
        is_free = device is not None and own is not None and not always_asks(device, own)
        return self.command(device_id, part, capability, value) if is_free else ""

    @staticmethod
    def _is_clear(device: Device, part: str, capability: str) -> bool:
        """Return whether only this main part of *device* has the capability."""
        having = [
            candidate.id
            for candidate in device.parts
            if any(can.name == capability for can in candidate.part.capabilities)
        ]
        return having == [part] and not any(
            candidate.id == part and candidate.part.category for candidate in device.parts
        )


def rounded(capability: str, value: PlainValue) -> PlainValue:
    """Return a number that people mean: percentages in steps of 5, degrees of 0.5."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    step = _STEPS.get(CAPABILITIES.get(capability, OWN).unit)
    return value if step is None else round(value / step) * step


def _texts(reference: str, capability: str, value: PlainValue, between: str) -> Iterator[str]:
    word = value_text(capability, value)
    if reference and value is not None:
        yield f"{reference} {word}"
        yield f"{reference} {capability}{between}{word}"


def _is_passing(part: DevicePart, capability: str, value: PlainValue) -> bool:
    """Return whether a value is only on the way, or says the same as a word: a cover at 0 % is closed."""
    if capability == "position" and value in {0.0, 100.0}:
        return any(offered.name == "movement" for offered in part.part.capabilities)
    return capability == "movement" and value not in {"open", "closed"}


def _read(text: str) -> object:
    try:
        return read_trigger(text)
    except UsageError:
        return None


def _holds(text: str, device: Device, capability: str, *, value: bool) -> bool:
    """Return whether the condition *text* holds if a part of *device* reports this *value*."""
    try:
        read = read_condition(text)
    except UsageError:
        return False
    having = (part.id for part in device.parts if any(can.name == capability for can in part.part.capabilities))
    return isinstance(read, Matches) and any(
        _means(read.state, device, part, capability, value=value) for part in having
    )


def _means(read: Becomes, device: Device, part: str, capability: str, *, value: PlainValue) -> bool:
    """Return whether *device* matches with this value, and not without it."""
    state = State(
        part=part,
        capability=capability,
        value=Value.of(value),
        since=_NO_TIME,
        told_at=_NO_TIME,
        live=True,
        is_first=False,
    )
    with_it, without = (device.model_copy(update={"states": states}) for states in ((state,), ()))
    return fits(read.query, facets_of(with_it)) and not fits(read.query, facets_of(without)) and not read.lasting


def _sets(
    text: str, reference: str, device: Device, parts: tuple[DevicePart, ...]
) -> tuple[str, dict[str, PlainValue]] | None:
    """Return the part and the values that the step *text* sets; None if it does not set one of *parts*."""
    try:
        step = read_step(text)
    except UsageError:
        return None
    if not isinstance(step, Do) or step.target != reference or step.values:
        return None
    request = CommandDevicesRequest(target=step.target, command=step.command)
    by_part = [(part.id, parsed) for part, parsed in settings_by_part(request, device, parts)]
    if len(by_part) != 1 or not isinstance(by_part[0][1], dict):
        return None
    return by_part[0][0], by_part[0][1]
