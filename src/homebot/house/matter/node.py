"""A simulated device that a simulated Matter server has commissioned."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import anyio
from anyio.abc import TaskStatus

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.matter.clusters import Attributes, attributes_of, command_orders, state_attributes, write_orders
from homebot.house.matter.server import SimulatedMatterServer

__all__ = ["ServedMatterNode"]


class ServedMatterNode(ServedDevice):
    """A lamp, window, cover, lock, thermostat or sensor as a node of a Matter fabric.

    Args:
        device: Its name and kind.
        on_command: Gets each command for it.
        server: The server that has commissioned it.

    Attributes:
        server: The same.
        node_id: Its number in the fabric; 0 before it was commissioned.
        is_available: Whether the server reaches it.
        attributes: What the server knows of it, by path.
    """

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], server: SimulatedMatterServer
    ) -> None:
        super().__init__(device, on_command)
        self.server = server
        self.node_id = 0
        self.is_available = False
        self.attributes: Attributes = {}

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be reachable until cancelled; commissioned the first time."""
        self.attributes = attributes_of(self.device, self.state)
        self.is_available = True
        self.server.meet(self)
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
        for path, value in state_attributes(self.device, self.state).items():
            if self.attributes.get(path) != value:
                self.change(path, value)

    def change(self, path: str, value: object) -> None:
        """Report that an attribute has a new value."""
        self.attributes[path] = value
        self.server.report(self, path, value)

    def describe(self) -> dict[str, object]:
        """Return what the server says of it."""
        return {
            "node_id": self.node_id,
            "date_commissioned": "2026-01-01T00:00:00.000000",
            "last_interview": "2026-01-01T00:00:00.000000",
            "interview_version": 6,
            "available": self.is_available,
            "is_bridge": False,
            "attributes": self.attributes,
            "attribute_subscriptions": [],
        }

    def invoke(self, cluster: int, command: str, payload: Mapping[str, object]) -> bool:
        """Carry out a command; return false for one that it does not have."""
        return self._obey(command_orders(self.device.kind, cluster, command, payload))

    def write(self, path: str, value: object) -> bool:
        """Write an attribute; return false for one that cannot be written."""
        if not self._obey(write_orders(self.device.kind, path, value)):
            return False
        self.change(path, value)
        return True

    def _obey(self, orders: tuple[str, ...] | None) -> bool:
        for order in orders or ():
            self.on_command(order)
        return orders is not None
