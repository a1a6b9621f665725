"""Simulated devices that are servers of HTTP, and may announce themselves by DNS-SD."""

from abc import abstractmethod
from collections.abc import Callable

import anyio
from anyio.abc import TaskStatus
from tests.simulated.dns_sd import DnsSdService, announce_service
from tests.simulated.http.web_server import WebDevice, WebServer

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo


class ServedWebDevice(ServedDevice, WebDevice):
    """A device with a server of its own, at a free port for 0, which may announce itself by DNS-SD."""

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        *,
        address: str = "127.0.0.1",
        port: int = 0,
        announced: bool = False,
    ) -> None:
        super().__init__(device, on_command)
        self.server = WebServer(self, address, port)
        self._is_announced = announced

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be on the network until cancelled."""
        async with anyio.create_task_group() as tasks:
            await tasks.start(self.server.serve)
            if self._is_announced:
                await tasks.start(announce_service, self.service(), self.server.address)
            task_status.started()

    @abstractmethod
    def service(self) -> DnsSdService:
        """Return its announced service; the port is known once it serves."""
