"""One device of a simulated house on its network, for any protocol."""

from abc import ABC, abstractmethod
from collections.abc import Callable

import anyio
from anyio.abc import TaskStatus

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.support.isolation import run_as


class ConnectedDevice(ABC):
    """A simulated device on its network, which does not know homebot."""

    def __init__(self) -> None:
        self._has_power = True
        self._switched = anyio.Event()

    @abstractmethod
    def begin(self, state: DeviceState, *, has_power: bool) -> None:
        """Start in *state*; called before :meth:`live`."""

    @abstractmethod
    def publish(self, state: DeviceState) -> None:
        """Report *state* in the device's protocol; never waits."""

    @abstractmethod
    def repeat(self) -> None:
        """Report the last state again, if devices of the protocol do that."""

    def power(self, *, on: bool) -> None:
        """Switch the power: without it the device vanishes from the network silently."""
        if on is not self._has_power:
            self._has_power = on
            self._switched.set()
            self._switched = anyio.Event()

    @abstractmethod
    async def live(self) -> None:
        """Be online whenever there is power, until cancelled."""


class ServedDevice(ConnectedDevice):
    """A device that is itself a server or a radio: it answers requests, or broadcasts.

    Args:
        on_command: Receives each command, as text such as ``on``.
    """

    def __init__(self, device: SimulatedDeviceInfo, on_command: Callable[[str], None]) -> None:
        super().__init__()
        self.device = device
        self.on_command = on_command
        self.state = DeviceState(text="")

    @abstractmethod
    async def serve(self) -> None:
        """Be on the network until cancelled, as by a power failure: without a goodbye."""

    @abstractmethod
    def show(self) -> None:
        """Report the new :attr:`state` to observers; never waits. Also called without power."""

    def begin(self, state: DeviceState, *, has_power: bool) -> None:
        """Begin in *state*."""
        self.state = state
        self._has_power = has_power

    def publish(self, state: DeviceState) -> None:
        """Keep *state*, and show it."""
        self.state = state
        self.show()

    def repeat(self) -> None:
        """Do nothing: a server only answers requests."""

    async def live(self) -> None:
        """Serve while there is power, until cancelled."""
        while True:
            while not self._has_power:
                await self._switched.wait()
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(run_as, "a simulated device", self.serve)
                while self._has_power:
                    await self._switched.wait()
                tasks.cancel_scope.cancel()


class HubDevice(ServedDevice):
    """A device that others reach through a hub: a bridge, or a server with its nodes.

    Attributes:
        is_there: Whether it has power, so that the hub can reach it.
    """

    is_there = False

    @abstractmethod
    async def join(self) -> None:
        """Make it reachable for the hub."""

    @abstractmethod
    def leave(self) -> None:
        """Make it unreachable for the hub."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Be reachable for the hub until cancelled."""
        self.is_there = True
        await self.join()
        task_status.started()
        try:
            await anyio.sleep_forever()
        finally:
            self.is_there = False
            self.leave()
