"""A house in which devices, directory and gateways do exactly what a test says; in virtual time."""

from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager

import pytest
from tests.one_task import in_one_task

from homebot.devices import (
    DEVICE_CHANGES,
    DEVICE_STATES,
    FIND_DEVICES,
    Device,
    DeviceChange,
    DevicePart,
    Devices,
    Endpoint,
    FindDevices,
    GatewayNames,
    Route,
    State,
    StateChange,
)
from homebot.devices.device import ChangeKind
from homebot.devices.gateway_messages import Command, SendCommand, SendCommandResponse
from homebot.devices.part import Capability, Part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.term_messages import read_terms
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.devices.value import PlainValue, Reading, Value
from homebot.graph import Graph, Node
from homebot.messages import Time


def moment(second: int) -> Time:
    return Time(sec=second, nanosec=0)


def part(
    service_type: str,
    *settable: str,
    part_id: str = "",
    reads: Iterable[str] = (),
    gateways: Iterable[str] = ("mqtt",),
    **more: object,
) -> DevicePart:
    """A part that is told *settable* and says that as well as *reads*."""
    capabilities = [Capability(name=name, settable=True) for name in settable]
    capabilities += [Capability(name=name) for name in reads]
    made = Part(id=part_id, service_type=service_type, capabilities=tuple(capabilities))
    return DevicePart(
        id=part_id,
        part=made.model_copy(update=more),
        routes=tuple(Route(gateway=one, key=f"{one}-key", part=part_id) for one in gateways),
    )


def device(
    device_id: str,
    *parts: DevicePart,
    area: str = "",
    word: str = "",
    states: Mapping[str, PlainValue] | None = None,
    **told: PlainValue,
) -> Device:
    """A device whose first part told *states* and *told*."""
    return Device(
        id=device_id,
        name=device_id.title(),
        service_type=word or (parts[0].part.service_type if parts else ""),
        endpoints=(Endpoint(gateway="mqtt", key=device_id, address="out", command_address="in"),),
        metadata=(),
        first_seen=moment(0),
        last_seen=moment(0),
        expires=moment(3600),
        freshness="fresh",
        area=area,
        parts=parts,
        states=tuple(state(parts[0].id, name, value) for name, value in {**(states or {}), **told}.items()),
    )


def state(part_id: str, capability: str, value: PlainValue, told_at: int = 0) -> State:
    told = moment(told_at)
    return State(part=part_id, capability=capability, value=Value.of(value), since=told, told_at=told, live=True)


class House:
    """The outside of an app.

    Attributes:
        devices: What the app uses.
        node: The app's node.
        told: What the gateways were told: gateway, part, capability, value, transition.
        codes: The codes that came with that.
        failing: Gateways whose service raises.
        answers: What a gateway answers instead of yes.
    """

    part = staticmethod(part)
    device = staticmethod(device)
    state = staticmethod(state)

    def __init__(self, graph: Graph, node: Node, directory: Node) -> None:
        self.graph = graph
        self.node = node
        self.devices = Devices(node)
        self.told: list[tuple[str, str, str, PlainValue, float]] = []
        self.codes: list[str] = []
        self.failing: set[str] = set()
        self.answers: dict[str, SendCommandResponse] = {}
        self._gateways: list[Node] = []
        self._directory = directory
        self._known: dict[str, Device] = {}
        self._sequence = 0
        self._service = directory.create_service(FindDevices, FIND_DEVICES, self._find)
        self._changes = self._directory.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        self._states = self._directory.create_publisher(StateChange, DEVICE_STATES, 10)

    def gateway(self, name: str) -> Node:
        """Let there be a gateway that takes commands; closing the node takes it away."""
        node = Node(self.graph, name, namespace="/gateway")
        self._gateways.append(node)

        def send(command: Command) -> SendCommandResponse:
            if name in self.failing:
                raise ValueError("the test says so")
            if name in self.answers:
                return self.answers[name]
            self.told.append((name, command.part, command.capability, command.value.plain(), command.transition))
            self.codes.append(command.code)
            return SendCommandResponse(success=True)

        node.create_service(SendCommand, GatewayNames(name).send_command, send)
        return node

    def restart_directory(self) -> None:
        """Close the service of the directory and offer it again."""
        self._service.close()
        self._service = self._directory.create_service(FindDevices, FIND_DEVICES, self._find)

    def end_directory(self) -> None:
        """Let there be no directory."""
        self._directory.close()

    def end(self) -> None:
        """End whatever is still there."""
        for gateway in self._gateways:
            gateway.close()

    def has(self, *devices: Device) -> None:
        """Let the directory know these, without a word."""
        self._known.update({one.id: one for one in devices})

    def tells(self, kind: ChangeKind, device: Device) -> None:
        """Let the directory tell that something happened."""
        self._sequence += 1
        self._known[device.id] = device
        if kind == "removed":
            del self._known[device.id]
        self._changes.publish(DeviceChange(kind=kind, device=device, sequence=self._sequence, why="the test says so"))

    def says(
        self,
        device_id: str,
        capability: str,
        value: PlainValue,
        *,
        part_id: str = "",
        told_at: int = 1,
        sequence: int | None = None,
    ) -> None:
        """Let a part tell a state; with a *sequence*, one that was told before and comes late."""
        self._sequence += 1
        told = state(part_id, capability, value, told_at)
        stream = f"{device_id} {part_id} {capability}"
        number = self._sequence if sequence is None else sequence
        self._states.publish(
            StateChange(
                stream=stream,
                device=device_id,
                readings=(Reading(part=told.part, capability=told.capability, value=told.value),),
                told_at=told.told_at,
                live=told.live,
                sequence=number,
            )
        )

    def _find(self, request: FindDevicesRequest) -> FindDevicesResponse:
        query = read_terms(request.query)
        found = [one for one in self._known.values() if fits(query, facets_of(one))]
        return FindDevicesResponse(devices=tuple(found), sequence=self._sequence)


@asynccontextmanager
async def open_house() -> AsyncIterator[House]:
    graph = Graph()
    async with Node(graph, "app") as node, Node(graph, "discovery") as directory:
        house = House(graph, node, directory)
        yield house
        house.end()


@pytest.fixture
async def house() -> AsyncIterator[House]:
    async with in_one_task(open_house()) as house:
        yield house
