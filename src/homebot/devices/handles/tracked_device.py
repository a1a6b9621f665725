"""The known state of one device, for those that follow it. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple, TypeAlias, cast

from homebot.devices.device import Device, State, StateChange
from homebot.devices.value import PlainValue, Reading, Value
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.devices.command_messages import Setting

__all__ = ["TrackedDevice"]


class TrackedDevice:
    """The known state of one device, shared by all handles of its parts.

    Args:
        device: The device.
        sequence: Number of the last change in it; see :class:`DeviceChange`.
        is_gone: Whether it was removed.

    Attributes:
        device: Its newest description.
        is_gone: Whether it was removed.
    """

    def __init__(self, device: Device, sequence: int, *, is_gone: bool = False) -> None:
        self.device = device
        self.is_gone = is_gone
        self._sequence = sequence
        self._values: dict[tuple[str, str], _Told] = {}
        self._take_states(device.states, sequence)

    def update(self, device: Device, sequence: int, *, is_gone: bool = False) -> None:
        """Store a description; one older than the stored one changes nothing."""
        if sequence < self._sequence:
            return
        self._sequence, self.device, self.is_gone = sequence, device, is_gone
        parts = {part.id for part in device.parts}
        self._values = {place: told for place, told in self._values.items() if place[0] in parts}
        self._take_states(device.states, sequence)

    def take(self, change: StateChange) -> None:
        """Store new values in place of older ones by their number: the clock of their stamps may have been set back."""
        values, sequence = self._values, change.sequence
        for reading in change.readings:
            place = reading.part, reading.capability
            known = values.get(place)
            if known is None or known[0] <= sequence:
                values[place] = sequence, reading, change

    def take_reported(self, part_id: str, reported: Setting, now: float) -> None:
        """Store a value that the part reported just *now*, in seconds since the Unix epoch.

        It stands until the directory publishes it, or a newer value.
        """
        place = part_id, reported.capability
        known = self._values.get(place)
        self._values[place] = (
            self._sequence if known is None else known[0],
            _JustReported(*place, reported.value, now),
            None,
        )

    def value(self, part_id: str, capability: str) -> PlainValue:
        """Return the latest value of the part; None if it reported none, or that it does not know."""
        told = self._values.get((part_id, capability))
        return None if told is None else told[1].value.plain()

    def state(self, part_id: str, capability: str) -> State | None:
        """Return the latest value of the part with its times; None if it reported none."""
        told = self._values.get((part_id, capability))
        return None if told is None else _state_of(*told[1:])

    def only_value(self, capability: str) -> PlainValue:
        """Return the latest value of the only part with *capability*; None if there is none, or are several."""
        parts = [part.id for part in self.device.parts if any(one.name == capability for one in part.part.capabilities)]
        return self.value(parts[0], capability) if len(parts) == 1 else None

    def current(self) -> Device:
        """Return the device with the newest values of its parts."""
        states = tuple([_state_of(*told[1:]) for told in self._values.values()])
        return self.device.model_copy(update={"states": states})

    def _take_states(self, states: Iterable[State], sequence: int) -> None:
        for state in states:
            place = state.part, state.capability
            known = self._values.get(place)
            if known is None or known[0] <= sequence:
                self._values[place] = sequence, state, None


class _JustReported(NamedTuple):
    """A value from a command's result; most are replaced before their times are asked for."""

    part: str
    capability: str
    value: Value
    at: float

    def state(self) -> State:
        at = Time.from_seconds(self.at)
        return State(
            part=self.part,
            capability=self.capability,
            value=self.value,
            since=at,
            told_at=at,
            live=True,
            is_first=False,
        )


_Told: TypeAlias = tuple[int, State | Reading | _JustReported, StateChange | None]
"""Number of the change, the value, and the change that a reading is from."""


def _state_of(told: State | Reading | _JustReported, change: StateChange | None) -> State:
    if isinstance(told, _JustReported):
        return told.state()
    return change.state_of(told) if change is not None and isinstance(told, Reading) else cast("State", told)
