"""Factory of an application's handles, and the devices that they track."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeAlias, TypeVar, cast
from weakref import WeakValueDictionary

from homebot.devices.commander import Commander
from homebot.devices.device import Device, DeviceChange, DevicePart, State, StateChange
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, DIRECTORY_NODE, FIND_DEVICES
from homebot.devices.query import query_terms
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.devices.value import PlainValue, Reading
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.devices.handles.handle import Handle
    from homebot.devices.handles.handle_query import HandleQuery

__all__ = ["Handles", "TrackedDevice", "Watcher"]

HandleT = TypeVar("HandleT", bound="Handle")
Watcher: TypeAlias = Callable[[StateChange], None]
"""Called with the new values of each message, and with each event."""


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

    def take_reported(self, state: State) -> None:
        """Store a value that is known to be reported, until the directory publishes it, or a newer one."""
        place = state.part, state.capability
        known = self._values.get(place)
        self._values[place] = (self._sequence if known is None else known[0], state, None)

    def part(self, part_id: str) -> DevicePart | None:
        """Return the part, or None where the device has none of that id, or no longer."""
        for part in self.device.parts:
            if part.id == part_id:
                return part
        return None

    def value(self, part_id: str, capability: str) -> PlainValue:
        """Return the latest value of the part; None where it reported none, or that it does not know."""
        told = self._values.get((part_id, capability))
        return None if told is None else told[1].value.plain()

    def only_value(self, capability: str) -> PlainValue:
        """Return the latest value of the only part with *capability*; None where there is none, or are several."""
        parts = [part.id for part in self.device.parts if any(one.name == capability for one in part.part.capabilities)]
        return self.value(parts[0], capability) if len(parts) == 1 else None

    def current(self) -> Device:
        """Return the device with the newest values of its parts."""
        states = tuple([_state_of(*told[1:]) for told in self._values.values()])
        return self.device.with_checked(states=states)

    def _take_states(self, states: Iterable[State], sequence: int) -> None:
        for state in states:
            place = state.part, state.capability
            known = self._values.get(place)
            if known is None or known[0] <= sequence:
                self._values[place] = sequence, state, None


_Told: TypeAlias = tuple[int, State | Reading, StateChange | None]
"""Number of the change, the value, and the change that a reading is from."""


def _state_of(told: State | Reading, change: StateChange | None) -> State:
    return change.state_of(told) if change is not None and isinstance(told, Reading) else cast("State", told)


class Handles:
    """Makes the handles of one node, and keeps them up to date for as long as somebody holds them.

    Args:
        node: The node; the handles are kept up to date until it ends.
    """

    def __init__(self, node: Node) -> None:
        self._commander = Commander(node)
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._tracked: WeakValueDictionary[str, TrackedDevice] = WeakValueDictionary()
        self._watchers: list[Watcher] = []
        node.create_subscription(DeviceChange, DEVICE_CHANGES, self._on_change, 1, from_node=DIRECTORY_NODE)
        node.create_subscription(StateChange, DEVICE_STATES, self._on_state, 1, from_node=DIRECTORY_NODE)

    async def find(self, query: HandleQuery[HandleT]) -> tuple[HandleT, ...]:
        """Return the handles that match *query*, sorted by id.

        Raises:
            ServiceError: The directory does not answer.
        """
        answer = await self._find.call(FindDevicesRequest(query=query_terms(query.search)))
        found: list[HandleT] = []
        for device in answer.devices:
            if parts := query.parts(device):
                found += self.of_parts(query.kind, self.track(device, answer.sequence), parts)
        return tuple(found)

    def of_parts(self, kind: type[HandleT], device: TrackedDevice, parts: list[str]) -> list[HandleT]:
        """Return the handles of *parts* of a device."""
        return [kind(device, part, self._commander) for part in parts]

    def track(self, device: Device, sequence: int, *, is_gone: bool = False) -> TrackedDevice:
        """Return the state that all handles of *device* share, updated with this description."""
        tracked = self._tracked.get(device.id)
        if tracked is None:
            tracked = self._tracked[device.id] = TrackedDevice(device, sequence, is_gone=is_gone)
        else:
            tracked.update(device, sequence, is_gone=is_gone)
        return tracked

    def watch(self, watcher: Watcher) -> Callable[[], None]:
        """Call *watcher* with each new value and event of a device that has a handle; return the function to stop."""
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)

    def _on_change(self, change: DeviceChange) -> None:
        if (tracked := self._tracked.get(change.device.id)) is not None:
            tracked.update(change.device, change.sequence, is_gone=change.kind == "removed")

    def _on_state(self, change: StateChange) -> None:
        if not change.is_event:
            tracked = self._tracked.get(change.device)
            if tracked is None:
                return
            tracked.take(change)
        for watcher in self._watchers:
            watcher(change)
