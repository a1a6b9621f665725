"""Simulated devices in the fabric of a simulated Matter server: nodes of their own, and devices behind a bridge."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import anyio
from anyio.abc import TaskStatus

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.matter.bridge import bridge_of
from homebot.house.matter.clusters import attributes_of, command_orders, state_attributes, write_orders
from homebot.house.matter.server import CommissionedNode, SimulatedMatterServer

__all__ = ["BridgedMatterDevice", "ServedMatterNode"]


class ServedMatterNode(ServedDevice, CommissionedNode):
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
        ServedDevice.__init__(self, device, on_command)
        CommissionedNode.__init__(self)
        self.server = server
        self.setup_code = setup_code
        self._kind = kind or device.kind

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be reachable until cancelled; without a setup code it is commissioned the first time."""
        self.attributes = attributes_of(self.device, self.state, self._kind)
        self.is_available = True
        self.server.reach(self)
        task_status.started()
        try:
            await anyio.sleep_forever()
        finally:
            self.is_available = False
            self.server.miss(self)

    def show(self) -> None:
        """Report the attributes that have changed."""
        if not self.is_available:
            return
        for path, value in state_attributes(self._kind, self.state).items():
            if self.attributes.get(f"1/{path}") != value:
                self.change(f"1/{path}", value)

    def change(self, path: str, value: object) -> None:
        """Report that an attribute has a new value."""
        self.attributes[path] = value
        self.server.report(self, path, value)

    def invoke(self, endpoint: int, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Carry out a command; return false for one that it does not have."""
        return endpoint == 1 and _obey(self, command_orders(self._kind, cluster, command, payload))

    def write(self, path: str, value: object) -> bool:
        """Write an attribute; return false for one that cannot be written."""
        if not path.startswith("1/") or not _obey(self, write_orders(self._kind, path.removeprefix("1/"), value)):
            return False
        self.change(path, value)
        return True


class BridgedMatterDevice(ServedDevice):
    """Such a device behind the bridge of the house, which is a node.

    Args:
        server: The server that has commissioned the bridge.
    """

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], server: SimulatedMatterServer
    ) -> None:
        super().__init__(device, on_command)
        self._bridge = bridge_of(server)
        self._is_there = False

    async def serve(self) -> None:
        """Be reachable by the bridge until cancelled."""
        self._is_there = True
        self._bridge.reach(self)
        try:
            await anyio.sleep_forever()
        finally:
            self._is_there = False
            self._bridge.miss(self)

    def show(self) -> None:
        """Report the attributes that have changed."""
        if self._is_there:
            self._bridge.update(self, state_attributes(self.device.kind, self.state))

    def invoke(self, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Carry out a command; return false for one that it does not have."""
        return self._is_there and _obey(self, command_orders(self.device.kind, cluster, command, payload))

    def write(self, path: str, value: object) -> bool:
        """Write an attribute (``513/18``); return false for one that cannot be written."""
        return self._is_there and _obey(self, write_orders(self.device.kind, path, value))


def _obey(device: ServedDevice, orders: tuple[str, ...] | None) -> bool:
    for order in orders or ():
        device.on_command(order)
    return orders is not None
