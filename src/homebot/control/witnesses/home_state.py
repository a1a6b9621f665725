"""State of a home at the time at which its sensors are asked. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from homebot.control.witnesses.activity import Place, RecentActivity
from homebot.control.witnesses.command_watch import CommandWatch
from homebot.control.witnesses.finding import QUIET
from homebot.control.witnesses.sensors import Sensor, SensorPlace
from homebot.devices import Device
from homebot.folding import fold

__all__ = ["HomeState"]


class HomeState(NamedTuple):
    """Everything that is known of a home when its sensors are asked.

    Attributes:
        activity: What was switched lately.
        devices: The devices concerned, as the directory knows them now, by id.
        now: Seconds of the monotonic clock.
        wall: Seconds since the Unix epoch.
    """

    activity: RecentActivity
    devices: Mapping[str, Device]
    now: float
    wall: float

    def quiet_since(self, watch: CommandWatch, sensor: Sensor, settle: float) -> float:
        """Return since when nothing near *sensor* changed before the command, and what did has settled."""
        begins = sensor.history.begins
        oldest = max(watch.began - QUIET - settle, self.activity.known_since)
        last = max((at for at, place in self._near(watch, sensor, oldest) if at < watch.began), default=oldest)
        return max(last + settle, watch.began if begins is None else begins)

    def is_disturbed(self, watch: CommandWatch, sensor: Sensor) -> bool:
        """Return whether something else near *sensor* changed since the command, or is about to."""
        own = (watch.command.device.id, watch.command.part.id)
        if self.activity.known_since > watch.began:
            return True
        return any(place != own for _, place in self._near(watch, sensor, watch.began))

    def is_alive(self, place: SensorPlace, since: float) -> bool:
        """Return whether the device of a sensor can be reached and reported anything since *since*, monotonic."""
        device = self.devices.get(place[0])
        if device is None or not self.is_reachable(place):
            return False
        told = [one.told_at.to_seconds() for one in device.states if one.live]
        if len(device.states) == 1:  # a text that is repeated is no new report
            told.append(device.last_seen.to_seconds())
        ages = [self.wall - one for one in told]
        return any(0 <= age <= self.now - since for age in ages)

    def is_reachable(self, place: SensorPlace) -> bool:
        """Return whether nothing says that the device of a sensor, or the sensor's part, is away or stale."""
        device = self.devices.get(place[0])
        if device is None or device.freshness != "fresh" or device.reachable.state == "no":
            return False
        return place[1] not in device.offline_parts

    def _near(self, watch: CommandWatch, sensor: Sensor, since: float) -> Iterator[tuple[float, Place]]:
        changes = self.activity.since(since, watch.command.id)
        return ((at, place) for at, place in changes if self._is_near(place, watch, sensor))

    def _is_near(self, place: Place, watch: CommandWatch, sensor: Sensor) -> bool:
        """Return whether what a part does may reach a sensor: in its room or the commanded part's, or unknown."""
        if place == sensor.place[:2] and sensor.capability not in {"illuminance", "power"}:
            return False  # it was this sensor
        if place[0] == watch.command.device.id or sensor.is_for_the_house:
            return True
        device = self.devices.get(place[0])
        rooms = {fold(watch.command.device.area), fold(sensor.device.area)}
        return device is None or not device.area or "" in rooms or fold(device.area) in rooms
