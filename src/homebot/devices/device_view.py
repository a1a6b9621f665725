"""Newest description and values of one device. Pure."""

from __future__ import annotations

from typing import NamedTuple, final

from homebot.devices.device import Device, State, StateChange
from homebot.devices.value import PlainValue, Value
from homebot.messages import Time

__all__ = ["DeviceView"]


class _NewValue(NamedTuple):
    """A value that is newer than the description; `sequence` orders it among the changes of the directory."""

    sequence: int
    value: Value
    told_at: Time
    live: bool


@final
class DeviceView:
    """The newest description and values of one device, shared by its handles and live queries.

    Args:
        sequence: The number of the last change in it; see :class:`homebot.devices.DeviceChange`.

    Attributes:
        device: The newest description; use :meth:`current` for the newest values.
        sequence: The number of the last change in it.
    """

    __slots__ = ("__weakref__", "_newer", "device", "is_gone", "sequence")

    def __init__(self, device: Device, sequence: int) -> None:
        self.device = device
        self.is_gone = False
        self.sequence = sequence
        self._newer: dict[tuple[str, str], _NewValue] = {}

    def update(self, device: Device, sequence: int, *, is_gone: bool = False) -> None:
        """Store a description, unless it is older than the stored one."""
        if sequence < self.sequence:
            return
        self.sequence, self.device, self.is_gone = sequence, device, is_gone
        if self._newer:
            parts = {part.id for part in device.parts}
            self._newer = {
                place: new for place, new in self._newer.items() if new.sequence > sequence and place[0] in parts
            }

    def record_values(self, change: StateChange) -> None:
        """Store new values, ordered by their number: the clock of their stamps may have been set back."""
        sequence = change.sequence
        for reading in change.readings:
            place = reading.part, reading.capability
            known = self._newer.get(place)
            if sequence >= (self.sequence if known is None else known.sequence):
                self._newer[place] = _NewValue(sequence, reading.value, change.told_at, change.live)

    def record_result(self, part_id: str, capability: str, value: PlainValue, now: float) -> None:
        """Store a value from an outcome, reported *now* in seconds since the Unix epoch, until a newer one comes."""
        place = part_id, capability
        if self.value(*place) == value:
            return  # it has been so since it was reported
        known = self._newer.get(place)
        sequence = self.sequence if known is None else known.sequence
        self._newer[place] = _NewValue(sequence, Value.of(value), Time.from_seconds(now), live=True)

    def value(self, part_id: str, capability: str) -> PlainValue:
        """Return the latest value of the part; None if it is unknown."""
        new = self._newer.get((part_id, capability))
        if new is not None:
            return new.value.plain()
        state = self._described(part_id, capability)
        return None if state is None else state.value.plain()

    def state(self, part_id: str, capability: str) -> State | None:
        """Return the latest value of the part with its times; None if it reported none."""
        new = self._newer.get((part_id, capability))
        return self._described(part_id, capability) if new is None else _state((part_id, capability), new)

    def only_value(self, capability: str) -> PlainValue:
        """Return the latest value of the only part with *capability*; None if none or several have it."""
        parts = [part.id for part in self.device.parts if any(one.name == capability for one in part.part.capabilities)]
        return self.value(parts[0], capability) if len(parts) == 1 else None

    def current(self) -> Device:
        """Return the device with the newest values of its parts."""
        if not self._newer:
            return self.device
        newer = dict(self._newer)
        states = []
        for state in self.device.states:
            new = newer.pop((state.part, state.capability), None)
            states.append(state if new is None else _state((state.part, state.capability), new))
        states += [_state(place, new) for place, new in newer.items()]
        return self.device.model_copy(update={"states": tuple(states)})

    def _described(self, part_id: str, capability: str) -> State | None:
        for state in self.device.states:
            if state.capability == capability and state.part == part_id:
                return state
        return None


def _state(place: tuple[str, str], new: _NewValue) -> State:
    part, capability = place
    return State(
        part=part,
        capability=capability,
        value=new.value,
        since=new.told_at,
        told_at=new.told_at,
        live=new.live,
        is_first=False,
    )
