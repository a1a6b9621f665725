"""A device as the handles of one application know it: always the newest that was heard. Pure."""

from __future__ import annotations

from homebot.devices.capabilities import EVENTS
from homebot.devices.device import Device, DevicePart, State, StateChange
from homebot.devices.value import PlainValue

__all__ = ["TrackedDevice"]


class TrackedDevice:
    """The known state of one device, shared by all handles of its parts.

    Args:
        device: The device.
        sequence: Number of the last change that is in there; see :class:`DeviceChange`.
        is_gone: Whether it was removed.

    Attributes:
        device: Its newest description.
        is_gone: Whether it was removed.
    """

    def __init__(self, device: Device, sequence: int, *, is_gone: bool = False) -> None:
        self.device = device
        self.is_gone = is_gone
        self._sequence = sequence
        self._states = {(one.part, one.capability): (sequence, one) for one in device.states}

    def take(self, device: Device, sequence: int, *, is_gone: bool = False) -> None:
        """Take a description; an older one than is known changes nothing."""
        if sequence < self._sequence:
            return
        self._sequence, self.device, self.is_gone = sequence, device, is_gone
        parts = {one.id for one in device.parts}
        self._states = {name: one for name, one in self._states.items() if one[1].part in parts}
        for state in device.states:
            self._put(state, sequence)

    def take_state(self, change: StateChange) -> None:
        """Take a state; one that was told before what is known changes nothing. An event is no state."""
        if change.state.capability not in EVENTS:
            self._put(change.state, change.sequence)

    def part(self, part_id: str) -> DevicePart | None:
        """Return the part, or None where it has none of that id, or no more."""
        return next((one for one in self.device.parts if one.id == part_id), None)

    def value(self, part_id: str, capability: str) -> PlainValue:
        """Return what the part last told; None where it told nothing, or that it does not know."""
        state = self._states.get((part_id, capability))
        return None if state is None else state[1].value.plain()

    def only_value(self, capability: str) -> PlainValue:
        """Return what the part last told that alone tells *capability*; None where there is none, or are several."""
        telling = [
            one.id for one in self.device.parts if any(found.name == capability for found in one.part.capabilities)
        ]
        return self.value(telling[0], capability) if len(telling) == 1 else None

    def current(self) -> Device:
        """Return the device with the newest that its parts told."""
        return self.device.model_copy(update={"states": tuple(state for _, state in self._states.values())})

    def _put(self, state: State, sequence: int) -> None:
        """By its number: its stamp is that of a clock that may have been set back."""
        known = self._states.get((state.part, state.capability))
        if known is None or known[0] <= sequence:
            self._states[state.part, state.capability] = sequence, state
