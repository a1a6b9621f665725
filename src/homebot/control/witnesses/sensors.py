"""The sensors of a home that may witness commands, and which of them may witness a certain part. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias, final

from homebot.control.command import IssuedCommand
from homebot.control.witnesses.effect import SENSED, seen_by
from homebot.control.witnesses.sensor_history import SensorHistory
from homebot.control.witnesses.sensor_resolution import Step
from homebot.devices import Device, DevicePart
from homebot.devices.query import PartFacets, Query, fits
from homebot.devices.value import PlainValue
from homebot.folding import fold

__all__ = ["MOST_FOR_ONE", "Sensor", "SensorPlace", "WitnessSensors", "reading_of"]

MOST_FOR_ONE = 4
"""Sensors that are compared for one part: of more, those of its room, and those whose ids come first."""

_MOST_REMEMBERED = 1000
"""Sensors of an earlier run that are not there yet; of more, those remembered first are forgotten."""

SensorPlace: TypeAlias = tuple[str, str, str]
"""The ids of a device and of its part, and a capability."""

_METER = "electrical_meter"


@dataclass(slots=True, eq=False)
class Sensor:
    """One value of a device that nobody sets.

    Attributes:
        device: The device, as it was last described.
        part: Its part.
        capability: The capability.
        history: What it reported.
        accused: The part that it contradicted last, and how many readings it had told by then.
        stuck_at: How many it had told when it showed nothing of two parts; -1 where it never did.
    """

    device: Device
    part: DevicePart
    capability: str
    history: SensorHistory = field(default_factory=SensorHistory)
    accused: tuple[str, int] = ("", 0)
    stuck_at: int = -1

    @property
    def place(self) -> SensorPlace:
        """The ids of its device and part, and the capability."""
        return self.device.id, self.part.id, self.capability

    @property
    def is_for_the_house(self) -> bool:
        """True if it is a meter that measures more than its room may have."""
        switches = any(one.settable for one in self.part.part.capabilities)
        return self.capability == "power" and self.part.part.service_type == _METER and not switches


@final
class WitnessSensors:
    """The sensors, by room.

    Args:
        named: Queries, each with the sensor that the owner names for the parts that fit: its id or name, folded; an
            empty one is none. The first that fits counts.

    Attributes:
        ids: The ids of their devices.
    """

    def __init__(self, named: Iterable[tuple[Query, str]]) -> None:
        self._named = tuple(named)
        self._sensors: dict[SensorPlace, Sensor] = {}
        self.ids: set[str] = set()
        self._remembered: dict[SensorPlace, SensorHistory] = {}
        self._rooms: dict[str, list[Sensor]] = {}
        self._meters: list[Sensor] = []

    def __getitem__(self, place: SensorPlace) -> Sensor | None:
        return self._sensors.get(place)

    def put(self, device: Device, now: float) -> None:
        """Add the sensors of *device*, or what is new of them; what it had reported live counts from *now* on."""
        old = {place: one for place, one in self._sensors.items() if place[0] == device.id}
        for place in old:
            del self._sensors[place]
        for part in device.parts:
            for capability in part.part.capabilities:
                place = (device.id, part.id, capability.name)
                if capability.name in SENSED and capability.readable and not capability.settable:
                    sensor = old.get(place)
                    if sensor is None:
                        history = self._remembered.pop(place, None) or SensorHistory()
                        sensor = Sensor(device, part, capability.name, history)
                    sensor.device, sensor.part = device, part
                    self._sensors[place] = sensor
                    _begin(sensor, now)
        self._arrange()

    def remember(self, place: SensorPlace, steps: Iterable[Step], levels: Iterable[float]) -> None:
        """Take over how finely the sensor at *place* reported in an earlier run, also of one that is not there yet."""
        known = self._sensors.get(place)
        history = self._remembered.setdefault(place, SensorHistory()) if known is None else known.history
        history.resolution.restore(steps, levels)
        if len(self._remembered) > _MOST_REMEMBERED:
            del self._remembered[next(iter(self._remembered))]

    def remove(self, device_id: str) -> None:
        """Forget the sensors of a device."""
        for place in [one for one in self._sensors if one[0] == device_id]:
            del self._sensors[place]
        self._arrange()

    def candidates(self, command: IssuedCommand) -> list[Sensor]:
        """Return the sensors of other devices that may see what *command* does.

        They are in its room, in a room that nobody said, or meters of the house, in this order.
        """
        wanted = seen_by(command.settings)
        if not wanted:
            return []
        name = self._name_for(command)
        if name is not None:
            found: Iterable[Sensor] = (one for one in self._sensors.values() if name in _names(one.device))
        else:
            found = (*self._rooms.get(fold(command.device.area), ()), *self._rooms.get("", ()), *self._meters)
        fitting = (one for one in found if one.capability in wanted and _is_independent(one, command))
        return list(dict.fromkeys(fitting))[:MOST_FOR_ONE]

    def _name_for(self, command: IssuedCommand) -> str | None:
        if not self._named:
            return None
        facets = PartFacets(command.device)
        facets.part = command.part
        return next((name for query, name in self._named if fits(query, facets)), None)

    def _arrange(self) -> None:
        self.ids = {one[0] for one in self._sensors}
        self._rooms, self._meters = {}, []
        for _, sensor in sorted(self._sensors.items()):
            self._rooms.setdefault(fold(sensor.device.area), []).append(sensor)
            if sensor.is_for_the_house:
                self._meters.append(sensor)


def reading_of(value: PlainValue) -> float | None:
    """Return what a sensor measured as a number; None where it is none."""
    return float(value) if isinstance(value, bool | float) else None


def _begin(sensor: Sensor, now: float) -> None:
    if sensor.history.count:
        return
    for state in sensor.device.states:
        is_its = state.part == sensor.part.id and state.capability == sensor.capability and state.live
        if is_its and (value := reading_of(state.value.plain())) is not None:
            sensor.history.note(value, now)


def _is_independent(sensor: Sensor, command: IssuedCommand) -> bool:
    """Return whether a sensor is no part of the commanded device, and no reading of what that reports itself."""
    own = frozenset(address for part in command.device.parts for address in part.part.reads)
    return sensor.device.id != command.device.id and own.isdisjoint(sensor.part.part.reads)


def _names(device: Device) -> Iterator[str]:
    return (fold(one) for one in (device.id, device.name, *device.names))
