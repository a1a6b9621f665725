"""A simulated Matter bridge: one node with one endpoint for each device behind it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Protocol

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.matter.clusters import Attributes, at_endpoint, bridged_attributes, root_attributes
from homebot.house.matter.server import CommissionedNode, SimulatedMatterServer

__all__ = ["BridgedDevice", "MatterBridge", "bridge_of"]

_AGGREGATOR: Final = 1
_AGGREGATOR_TYPE: Final = 0x000E
_REACHABLE: Final = "57/17"


class BridgedDevice(Protocol):
    """A device behind a bridge, as the bridge sees it."""

    device: SimulatedDeviceInfo
    state: DeviceState

    def invoke(self, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Carry out a command; return false for one that it does not have."""

    def write(self, path: str, value: object) -> bool:
        """Write an attribute (``513/18``); return false for one that cannot be written."""


class MatterBridge(CommissionedNode):
    """A bridge, which always has power."""

    def __init__(self, info: SimulatedDeviceInfo, server: SimulatedMatterServer) -> None:
        super().__init__()
        self.is_bridge = True
        self.is_available = True
        self._server = server
        self._devices: dict[int, BridgedDevice] = {}
        self.attributes = root_attributes(info, [_AGGREGATOR]) | at_endpoint(
            _AGGREGATOR, {"29/0": [{"0": _AGGREGATOR_TYPE, "1": 1}], "29/3": []}
        )

    def reach(self, device: BridgedDevice) -> None:
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
        self._server.send_event("node_updated", self.describe())
        if is_new:
            self._server.send_event("endpoint_added", {"node_id": self.node_id, "endpoint_id": endpoint})

    def miss(self, device: BridgedDevice) -> None:
        """Report that a device does not answer the bridge."""
        self.update(device, {_REACHABLE: False})

    def update(self, device: BridgedDevice, attributes: Attributes) -> None:
        """Report the attributes of a device that are new."""
        endpoint = self._endpoint_of(device)
        for path, value in {} if endpoint is None else at_endpoint(endpoint, attributes).items():
            if self.attributes.get(path) != value:
                self.attributes[path] = value
                self._server.report(self, path, value)

    def invoke(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Pass a command on; return false where no device takes it."""
        device = self._devices.get(endpoint)
        return device is not None and device.invoke(cluster, command, payload)

    def write(self, path: str, value: object) -> bool:
        """Pass a new value of an attribute on; return false where no device takes it."""
        endpoint, _, attribute = path.partition("/")
        device = self._devices.get(int(endpoint)) if endpoint.isdecimal() else None
        if device is None or not device.write(attribute, value):
            return False
        self.update(device, {attribute: value})
        return True

    def _endpoint_of(self, device: BridgedDevice) -> int | None:
        return next((endpoint for endpoint, one in self._devices.items() if one is device), None)


def bridge_of(server: SimulatedMatterServer) -> MatterBridge:
    """Return the one bridge that *server* has commissioned, which it does now if it has none."""
    for node in server.nodes.values():
        if isinstance(node, MatterBridge):
            return node
    bridge = MatterBridge(SimulatedDeviceInfo("house", "bridge", "Matter bridge", "bridge", ""), server)
    server.reach(bridge)
    return bridge
