"""Devices that policies need, by room, and motion sensors that are known to work. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Final, NamedTuple, final

from homebot.devices import Device, DevicePart, State, StateChange
from homebot.devices.device import target_of
from homebot.devices.device_view import DeviceView
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.support.bounded_map import BoundedMap
from homebot.support.folding import fold

OCCUPANCY: Final = "occupancy"
"""The capability of motion sensors."""

PRESENCE: Final = "presence"
"""The kind of sensors that also detect people sitting still: Home Assistant's device class, or the owner's tag."""

DETECTION: Final = "detection"
"""The kind of the saved rows."""

_RECORD: Final = '{"version":1}'
_MAX_SENSORS: Final = 10_000
_DAY_S: Final = 86_400.0
"""Seconds after which a row is saved again, because the store drops old rows."""


class SensorReading(NamedTuple):
    """The newest value of one sensor.

    Attributes:
        sensor: The id of the device, with ``#`` and the id of the part if it has one.
        value: The value; None if the sensor reported nothing live, or has been silent for too long.
        since: When it took that value, in seconds since the Unix epoch; 0 if unknown.
        heard_since: When the sensor's last silence ended, during which its value may have differed; 0 for none.
        is_presence: Whether it also detects people who sit still.
    """

    sensor: str
    value: PlainValue
    since: float = 0.0
    heard_since: float = 0.0
    is_presence: bool = False


@final
class House:
    """The devices that policies need, by room.

    Args:
        detections: The sensors that detected a person, kept across restarts; None to start without any.

    Attributes:
        is_known: Whether the devices have been read from the directory; until then nothing is known.
    """

    def __init__(self, detections: Detections | None = None) -> None:
        self.is_known = False
        self.detections = Detections() if detections is None else detections
        self._devices: dict[str, DeviceView] = {}
        self._room_of: dict[str, str] = {}
        self._detected_since: dict[str, float] = {}
        self._heard_since: dict[str, float] = {}  # for devices that were silent

    def put(self, view: DeviceView) -> None:
        """Add a device, or update its room."""
        device = view.device
        if not _is_heard(device):
            self._heard_since[device.id] = math.inf
        elif self._heard_since.get(device.id) == math.inf:
            self._heard_since[device.id] = device.last_seen.to_seconds()
        self._devices[device.id] = view
        self._room_of[device.id] = fold(device.area)
        self._record_detections(device.id, device.states)

    def remove(self, device_id: str) -> None:
        """Forget a device."""
        if (view := self._devices.pop(device_id, None)) is not None:
            del self._room_of[device_id]
            self._heard_since.pop(device_id, None)
            for part in view.device.parts:
                self.detections.forget(target_of(device_id, part.id))
                self._detected_since.pop(target_of(device_id, part.id), None)

    def record_values(self, change: StateChange) -> None:
        """Record the detections among new values; those of other devices are ignored."""
        if change.device in self._devices:
            self._record_detections(change.device, change.states)

    def readings(self, room: str, capability: str) -> list[SensorReading]:
        """Return the values of all sensors of *capability* in *room*, which must not be empty."""
        return self._readings(self.devices(room), capability)

    def reading_of(self, name: str, capability: str) -> SensorReading | None:
        """Return the value of the only sensor of *capability* on the device with the id or name *name*."""
        named = (
            view
            for view in self._devices.values()
            if view.device.id == name or fold(name) in map(fold, (view.device.name, *view.device.names))
        )
        readings = self._readings(named, capability)
        return readings[0] if len(readings) == 1 else None

    def detected_since(self, sensor: str) -> float | None:
        """Return when *sensor* last began to detect a person, in seconds since the Unix epoch; None for never."""
        return self._detected_since.get(sensor)

    def unproven(self) -> tuple[str, ...]:
        """Return the names of the devices in a room with a motion sensor that has never detected a person."""
        return tuple(
            view.device.name or view.device.id
            for view in self._devices.values()
            if view.device.area
            and any(
                _reports(part, OCCUPANCY) and target_of(view.device.id, part.id) not in self.detections
                for part in view.device.parts
            )
        )

    def devices(self, room: str | None = None) -> Iterable[DeviceView]:
        """Return the devices in *room*, or all."""
        if room is None:
            return self._devices.values()
        wanted = fold(room)
        return [self._devices[device_id] for device_id, its_room in self._room_of.items() if its_room == wanted]

    def _readings(self, views: Iterable[DeviceView], capability: str) -> list[SensorReading]:
        return [
            self._reading(view, part, capability)
            for view in views
            for part in view.device.parts
            if _reports(part, capability)
        ]

    def _reading(self, view: DeviceView, part: DevicePart, capability: str) -> SensorReading:
        device, is_presence = view.device, PRESENCE in (part.part.tag, *view.device.tags)
        name = target_of(device.id, part.id)
        state = view.state(part.id, capability)
        if state is None or not state.live or not _is_heard(device) or part.id in device.offline_parts:
            return SensorReading(name, None, is_presence=is_presence)
        since, heard_since = state.since.to_seconds(), self._heard_since.get(device.id, 0.0)
        return SensorReading(name, state.value.plain(), since, heard_since, is_presence)

    def _record_detections(self, device_id: str, states: Iterable[State]) -> None:
        for state in states:
            if state.capability == OCCUPANCY and state.value.plain() is True:
                sensor = target_of(device_id, state.part)
                self.detections.record(sensor, state.told_at.to_seconds())
                self._detected_since[sensor] = state.since.to_seconds()


def _is_heard(device: Device) -> bool:
    return device.freshness == "fresh" and device.reachable.state != "no"


def _reports(part: DevicePart, capability: str) -> bool:
    return any(own.name == capability and own.readable for own in part.part.capabilities)


@final
class Detections:
    """The last 10,000 motion sensors that detected a person; any other may be broken, or face a wall.

    Args:
        save: Saves a sensor across restarts: its name, and a record, empty to remove it.

    Attributes:
        forgotten: The number of sensors that were dropped because there were too many.
    """

    def __init__(self, save: Callable[[str, str], object] = lambda *_: None) -> None:
        self._save = save
        self._saved_at: BoundedMap[str, float] = BoundedMap(_MAX_SENSORS, self._on_drop)
        self.forgotten = 0

    def __contains__(self, sensor: str) -> bool:
        return sensor in self._saved_at

    def record(self, sensor: str, at: float) -> None:
        """Record that *sensor* detected a person at *at*, in seconds since the Unix epoch."""
        saved_at = self._saved_at.get(sensor)
        is_due = saved_at is None or abs(at - saved_at) >= _DAY_S
        self._saved_at[sensor] = at if saved_at is None or is_due else saved_at
        if is_due:
            self._save(sensor, _RECORD)

    def forget(self, sensor: str) -> None:
        """Forget a sensor: another one may replace it."""
        if self._saved_at.pop(sensor, None) is not None:
            self._save(sensor, "")

    @property
    def sensors(self) -> tuple[str, ...]:
        """All sensors, in the order in which they will be dropped."""
        return tuple(self._saved_at)

    def add(self, sensors: Iterable[str]) -> None:
        """Add *sensors* that detected a person in another run."""
        for sensor in sensors:
            if sensor not in self._saved_at:
                self._saved_at[sensor] = 0.0

    def restore(self, name: str, record: str) -> None:
        """Add a sensor of an earlier run.

        Raises:
            WireError: The record is of another version.
        """
        if record != _RECORD:
            raise WireError("it is not a detection of this version", record.encode())
        self.add((name,))

    def _on_drop(self, sensor: str, _saved_at: float) -> None:
        self.forgotten += 1
        self._save(sensor, "")
