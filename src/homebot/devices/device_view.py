"""The newest description and values of one device. Pure."""

from typing import final

from homebot.devices.device import Device, State, StateChange
from homebot.devices.value import UNKNOWN, PlainValue, Reading, Value
from homebot.messages import Time


@final
class DeviceView:
    """The newest description and values of one device, shared by its handles and live queries.

    Attributes:
        device: The newest description; use :meth:`current` for the newest values.
        sequence: The number of the last change that it includes.
        replaced: The values that the last change replaced, by part and capability.
    """

    __slots__ = ("__weakref__", "_held", "_newer", "device", "is_gone", "replaced", "sequence")

    def __init__(self, device: Device, sequence: int) -> None:
        self.device = device
        self.is_gone = False
        self.sequence = sequence
        self.replaced: dict[tuple[str, str], Value] = {}
        self._newer: dict[tuple[str, str], tuple[StateChange, Reading, bool, Value]] = {}
        self._held: dict[tuple[str, str], State] = {}  # the last values before those that are unknown

    def update(self, device: Device, sequence: int, *, is_gone: bool = False) -> None:
        """Store a description unless it is older than the stored one."""
        if sequence < self.sequence:
            return
        known = {(state.part, state.capability): state.value for state in self.device.states}
        known |= {place: _value_before(new) for place, new in self._newer.items()}
        self.replaced = {}
        for state in device.states:
            if (before := known.get(place := (state.part, state.capability), UNKNOWN)) != state.value:
                self.replaced[place] = before
            if not state.value.type or self._held:
                self._hold(state.part, state.capability, state.value)
        self.sequence, self.device, self.is_gone = sequence, device, is_gone
        if self._newer:
            parts = {part.id for part in device.parts}
            self._newer = {
                place: new for place, new in self._newer.items() if new[0].sequence > sequence and place[0] in parts
            }

    def record_values(self, change: StateChange) -> None:
        """Store new values, ordered by sequence number, because the clock may have been set back."""
        self.replaced = {}
        for reading in change.readings:
            known = self._newer.get(place := (reading.part, reading.capability))
            if change.sequence >= (self.sequence if known is None else known[0].sequence):
                if not reading.value.type or self._held:
                    self._hold(*place, reading.value)
                if known is None:
                    state = self.state(*place)
                    before = UNKNOWN if state is None else state.value
                    is_first = state is None or (state.is_first and _tells_no_other(state.value, reading.value))
                else:
                    before = _value_before(known)
                    is_first = known[2] and _tells_no_other(known[1].value, reading.value)
                self._newer[place], self.replaced[place] = (change, reading, is_first, before), before

    def record_result(self, part_id: str, capability: str, value: PlainValue, now: float) -> None:
        """Store a value from an outcome, reported at *now* in seconds since the Unix epoch, until a newer one comes."""
        if self.value(part_id, capability) == value:
            return  # unchanged since it was reported
        known = self._newer.get((part_id, capability))
        reading = Reading(part=part_id, capability=capability, value=Value.of(value))
        self.record_values(
            StateChange(
                stream="",
                device=self.device.id,
                readings=(reading,),
                told_at=Time.from_seconds(now),
                live=True,
                sequence=self.sequence if known is None else known[0].sequence,
            )
        )

    def value(self, part_id: str, capability: str) -> PlainValue:
        """Return the latest value of the part; None if it is unknown."""
        if (new := self._newer.get((part_id, capability))) is not None:
            return new[1].value.plain()
        state = self.state(part_id, capability)
        return None if state is None else state.value.plain()

    def state(self, part_id: str, capability: str) -> State | None:
        """Return the latest value of the part, with its times; None if it has reported none."""
        if (new := self._newer.get((part_id, capability))) is not None:
            change, reading, is_first, _ = new
            state, held = change.state_of(reading, is_first=is_first), self._held.get((part_id, capability))
            is_back = held is not None and held.value == state.value
            return state.model_copy(update={"since": held.since}) if held is not None and is_back else state
        for state in self.device.states:
            if state.capability == capability and state.part == part_id:
                return state
        return None

    def value_before(self, change: StateChange, reading: Reading) -> PlainValue:
        """Return the value that *reading* of *change* replaced; None if it was unknown, or has changed again since."""
        new = self._newer.get((reading.part, reading.capability))
        return None if new is None or new[0].sequence != change.sequence else new[3].plain()

    def only_value(self, capability: str) -> PlainValue:
        """Return the latest value of the only part with *capability*; None if none or several have it."""
        parts = [
            part.id
            for part in self.device.parts
            if any(offered.name == capability for offered in part.part.capabilities)
        ]
        return self.value(parts[0], capability) if len(parts) == 1 else None

    def current(self) -> Device:
        """Return the device with the newest values of its parts."""
        if not self._newer:
            return self.device
        newer = {place: new[0].state_of(new[1], is_first=new[2]) for place, new in self._newer.items()}
        states = [newer.pop((state.part, state.capability), state) for state in self.device.states]
        return self.device.model_copy(update={"states": (*states, *newer.values())})

    def settled(self) -> Device:
        """Return it as :meth:`current` does, but values that are unknown, as after a restart of its program, as before.

        To be unknown is no move: a wait for a value compares with this.
        """
        device = self.current()
        if not self._held:
            return device
        states = (
            held
            if (held := self._held.get((state.part, state.capability))) is not None and not state.value.type
            else state
            for state in device.states
        )
        return device.model_copy(update={"states": tuple(states)})

    def _hold(self, part_id: str, capability: str, value: Value) -> None:
        """Store the value before *value* if that is unknown, until another one comes."""
        place = part_id, capability
        if value.type:
            if (held := self._held.get(place)) is not None and held.value != value:
                del self._held[place]
        elif place not in self._held and (state := self.state(part_id, capability)) is not None and state.value.type:
            self._held[place] = state


def _tells_no_other(known: Value, value: Value) -> bool:
    return not known.type or known == value


def _value_before(new: tuple[StateChange, Reading, bool, Value]) -> Value:
    """Return the value that a newer one replaces: what an outcome said was no change yet."""
    change, reading, _, before = new
    return reading.value if change.stream else before
