"""Simulated devices in the fabric of a simulated Matter server: nodes of their own, a bridge, and devices behind it."""

from collections.abc import Callable, Mapping
from typing import Final

from tests.integrations.matter.simulated.clusters import (
    SCENES,
    Attributes,
    at_endpoint,
    attributes_of,
    bridged_attributes,
    command_orders,
    root_attributes,
    scene_fields,
    scene_orders,
    state_attributes,
    write_orders,
)
from tests.integrations.matter.simulated.server import CommissionedNode, SimulatedMatterServer

from homebot.house.connected_device import HubDevice, ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo

_AGGREGATOR: Final = 1
_AGGREGATOR_TYPE: Final = 0x000E
_REACHABLE: Final = "57/17"


class ServedMatterNode(HubDevice, CommissionedNode):
    """A lamp, window, cover, lock, thermostat or sensor as a node of a Matter fabric.

    Args:
        kind: Its kind in Matter, where it is another: ``plug`` for a lamp at a plug.
        setup_code: With which it can be commissioned; empty for one that is commissioned when it has power first.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        server: SimulatedMatterServer,
        kind: str = "",
        setup_code: str = "",
    ) -> None:
        HubDevice.__init__(self, device, on_command)
        CommissionedNode.__init__(self, server)
        self.setup_code = setup_code
        self._scenes: dict[object, tuple[str, Attributes]] = {}
        self._kind = kind or device.kind

    async def join(self) -> None:
        """Have the server reach it; without a setup code it is commissioned the first time."""
        self.attributes = attributes_of(self.device, self.state, self._kind)
        self.is_available = True
        self.server.reach(self)

    def leave(self) -> None:
        """Have the server miss it."""
        self.is_available = False
        self.server.miss(self)

    def show(self) -> None:
        """Report the attributes that have changed."""
        if self.is_available:
            self.update(at_endpoint(1, state_attributes(self._kind, self.state)))

    def invoke(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Carry out a command; return false for one that it does not have."""
        if cluster == SCENES and command == "RecallScene" and payload.get("sceneID") in self._scenes:
            return _obey(self, scene_orders(self._kind, self._scenes[payload["sceneID"]][1]))
        return endpoint == 1 and _obey(self, command_orders(self._kind, cluster, command, payload))

    def store_scene(self, number: int, name: str) -> None:
        """Keep the present attributes as a scene of no group."""
        self._scenes[number] = name, state_attributes(self._kind, self.state)
        info = {"0": len(self._scenes), "1": number, "2": 0, "3": True, "4": 16 - len(self._scenes), "254": 1}
        self.change(f"1/{SCENES}/2", [info])

    def answer(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> object:
        """Return the numbers of its scenes, or one of them."""
        if (endpoint, cluster) != (1, SCENES):
            return None
        if command == "GetSceneMembership":
            return {"status": 0, "capacity": None, "groupID": 0, "sceneList": [*self._scenes]}
        if command == "ViewScene" and (number := payload.get("sceneID")) in self._scenes:
            name, attributes = self._scenes[number]
            sets = scene_fields(attributes)
            fields = {"groupID": 0, "sceneID": number, "transitionTime": 0, "sceneName": name}
            return {"status": 0, **fields, "extensionFieldSetStructs": sets}
        return None

    def write(self, path: str, value: object) -> bool:
        """Write an attribute; return false for one that cannot be written."""
        if not path.startswith("1/") or not _obey(self, write_orders(self._kind, path.removeprefix("1/"), value)):
            return False
        self.change(path, value)
        return True


class BridgedMatterDevice(HubDevice):
    """Such a device behind the bridge of the house, a node that *server* has commissioned."""

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], server: SimulatedMatterServer
    ) -> None:
        super().__init__(device, on_command)
        self._bridge = _bridge_of(server)

    async def join(self) -> None:
        """Have the bridge reach it."""
        self._bridge.reach(self)

    def leave(self) -> None:
        """Have the bridge miss it."""
        self._bridge.miss(self)

    def show(self) -> None:
        """Report the attributes that have changed."""
        if self.is_there:
            self._bridge.show(self, state_attributes(self.device.kind, self.state))


class MatterBridge(CommissionedNode):
    """A bridge, which always has power."""

    def __init__(self, info: SimulatedDeviceInfo, server: SimulatedMatterServer) -> None:
        super().__init__(server)
        self.is_bridge = self.is_available = True
        self._devices: dict[int, BridgedMatterDevice] = {}
        self.attributes = root_attributes(info, [_AGGREGATOR]) | at_endpoint(
            _AGGREGATOR, {"29/0": [{"0": _AGGREGATOR_TYPE, "1": 1}], "29/3": []}
        )

    def reach(self, device: BridgedMatterDevice) -> None:
        """Add a new device, or one with its power back."""
        endpoint = self._endpoint_of(device)
        is_new = endpoint is None
        if endpoint is None:
            endpoint = _AGGREGATOR + 1 + len(self._devices)
            self._devices[endpoint] = device
            self.attributes["0/29/3"] = [_AGGREGATOR, *self._devices]
            self.attributes[f"{_AGGREGATOR}/29/3"] = list(self._devices)
        attributes = bridged_attributes(device.device, device.state, is_reachable=True)
        self.attributes.update(at_endpoint(endpoint, attributes))
        self.server.send_event("node_updated", self.describe())
        if is_new:
            self.server.send_event("endpoint_added", {"node_id": self.node_id, "endpoint_id": endpoint})

    def miss(self, device: BridgedMatterDevice) -> None:
        """Report that a device does not answer the bridge."""
        self.show(device, {_REACHABLE: False})

    def show(self, device: BridgedMatterDevice, attributes: Attributes) -> None:
        """Report the attributes of a device that are new."""
        endpoint = self._endpoint_of(device)
        if endpoint is not None:
            self.update(at_endpoint(endpoint, attributes))

    def invoke(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Pass a command on; return false where no device takes it."""
        device = self._devices.get(endpoint)
        if device is None or not device.is_there:
            return False
        return _obey(device, command_orders(device.device.kind, cluster, command, payload))

    def write(self, path: str, value: object) -> bool:
        """Pass a new value of an attribute on; return false where no device takes it."""
        endpoint, _, attribute = path.partition("/")
        device = self._devices.get(int(endpoint)) if endpoint.isdecimal() else None
        if device is None or not device.is_there:
            return False
        if not _obey(device, write_orders(device.device.kind, attribute, value)):
            return False
        self.update({path: value})
        return True

    def _endpoint_of(self, device: BridgedMatterDevice) -> int | None:
        return next((endpoint for endpoint, known in self._devices.items() if known is device), None)


def _bridge_of(server: SimulatedMatterServer) -> MatterBridge:
    """Return the one bridge that *server* has commissioned, which it does now if it has none."""
    for node in server.nodes.values():
        if isinstance(node, MatterBridge):
            return node
    bridge = MatterBridge(SimulatedDeviceInfo("house", "bridge", "Matter bridge", "bridge", ""), server)
    server.reach(bridge)
    return bridge


def _obey(device: ServedDevice, orders: tuple[str, ...] | None) -> bool:
    for order in orders or ():
        device.on_command(order)
    return orders is not None
