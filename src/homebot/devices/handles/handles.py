"""Factory of an application's handles: the devices that they track, and the sender of their commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeAlias, TypeVar, cast
from weakref import WeakValueDictionary

from homebot.devices.capabilities import MOMENTARY
from homebot.devices.device import EVERYTHING, Device, DeviceChange, DevicePart, State, StateChange
from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, DIRECTORY_NODE, FIND_DEVICES, GatewayNames
from homebot.devices.query import query_terms
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.devices.value import PlainValue, Reading, Value
from homebot.errors import InvalidNameError, LinkError, RefusedError, ServiceError, ServiceUnavailableError
from homebot.graph import Client, Node

if TYPE_CHECKING:
    from homebot.devices.handles.handle import Handle
    from homebot.devices.handles.handle_query import HandleQuery

__all__ = ["CommandSender", "Handles", "TrackedDevice", "Watcher"]

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


class CommandSender:
    """Sends commands by the best route that accepts them.

    Args:
        node: The node that sends them.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clients: dict[str, Client[Command, SendCommandResponse]] = {}

    async def send(
        self, device: Device, part: DevicePart, capability: str, value: PlainValue, transition: float, code: str = ""
    ) -> None:
        """Set *capability* to *value* within *transition* seconds; return when the network has accepted the command.

        Where a route cannot do that, and sent nothing, or cannot reach the device, the next one is tried; what a
        gateway refuses to do at all is not done by another route. A button is not pressed by a second route where the
        first may have pressed it.

        Raises:
            RefusedError: The gateway or the part refuses, or the part is disputed.
            LinkError: No gateway of the part is running and connected; it may work later.
        """
        if not part.routes:
            why = "; ".join(device.conflicts) or "it has no route for commands"
            raise RefusedError(f"a command to {device.id}", why)
        takes = [route for route in part.routes if capability in route.takes or route.takes == EVERYTHING]
        routes = takes or part.routes
        problem, unable = f"its gateway {routes[0].gateway} is not running", ""
        is_away, is_momentary = False, capability in MOMENTARY
        sent = Value.of(value)
        for route in routes:
            response = await self._call(
                route.gateway,
                Command(
                    key=route.key, part=route.part, capability=capability, value=sent, transition=transition, code=code
                ),
            )
            if response is None:
                is_away = True
            elif response.success:
                return
            elif response.problem == "unreachable":
                is_away, problem = True, response.message or problem
                if is_momentary:
                    break
            elif not response.unable:
                raise RefusedError(f"{capability} of {device.id}", response.message)
            else:
                unable = unable or response.message
        if unable and not is_away:
            raise RefusedError(f"{capability} of {device.id}", unable)
        raise LinkError(f"{capability} was not sent to {device.id}: {problem}")

    async def _call(self, gateway: str, command: Command) -> SendCommandResponse | None:
        """Return the gateway's answer; None where it is not running, so that nothing was sent."""
        client = self._clients.get(gateway)
        try:
            if client is None:
                client = self._node.create_client(SendCommand, GatewayNames(gateway).send_command)
                self._clients[gateway] = client
            if client.service_is_ready():
                return await client.call(command)
        except InvalidNameError as exc:
            return SendCommandResponse(success=False, message=str(exc), problem="refused", unable=True)
        except ServiceUnavailableError:
            return None
        except ServiceError as exc:
            return SendCommandResponse(success=False, message=str(exc), problem="unreachable")
        return None


class Handles:
    """Makes the handles of one node, and keeps them up to date for as long as somebody holds them.

    Args:
        node: The node; the handles are kept up to date until it ends.
    """

    def __init__(self, node: Node) -> None:
        self._sender = CommandSender(node)
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
        return [kind(device, part, self._sender) for part in parts]

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
