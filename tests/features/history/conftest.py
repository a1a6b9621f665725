"""A house whose history is kept, in virtual time."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from datetime import UTC, tzinfo
from pathlib import Path
from typing import Literal, TypeAlias

import anyio
import pytest
from tests.set_clock import SetClock

from homebot.devices.history_messages import (
    CorrectHistory,
    CorrectHistoryRequest,
    CorrectHistoryResponse,
    EnergyOfDay,
    HistorySeries,
    ReadEnergy,
    ReadEnergyRequest,
    ReadHistory,
    ReadHistoryRequest,
    ReadHistoryResponse,
)
from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.value import PlainValue
from homebot.discovery import Directory, DirectorySettings
from homebot.features.history import CORRECT_HISTORY, READ_ENERGY, READ_HISTORY
from homebot.features.history.history import HistoryKeeper
from homebot.features.history.settings import HistorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from homebot.messages import Time

MIDNIGHT = 1_767_225_600.0
"""2026-01-01, UTC."""


class KeptHouse:
    """A meter, a thermometer, a lamp and a button.

    Attributes:
        clock: The wall clock, which a test may set.
    """

    def __init__(self, clock: SetClock, gateway: MemoryGateway, app: Node, history: HistoryKeeper) -> None:
        self.clock = clock
        self._gateway = gateway
        self._read = app.create_client(ReadHistory, READ_HISTORY.name)
        self._energy = app.create_client(ReadEnergy, READ_ENERGY.name)
        self._correct = app.create_client(CorrectHistory, CORRECT_HISTORY.name)
        self.history = history

    async def report(self, device: str, **values: PlainValue) -> None:
        await self._gateway.devices.report(device, values)
        await anyio.sleep(0.001)

    async def add(self, device: str, kind: str, **values: PlainValue) -> None:
        """Put a device that reports at once."""
        part = simple_part(kind, readable=tuple(values))
        self._gateway.devices.put(GatewayDevice(device, device.title(), (part,)), "it is there")
        await self.report(device, **values)

    async def read(self, device: str, capability: str = "", since: float = 86_400.0, points: int = 0) -> HistorySeries:
        response = await self.response(device, capability, since, points)
        assert response.success, response.message
        (series,) = response.series
        return series

    async def response(
        self, device: str, capability: str = "", since: float = 86_400.0, points: int = 0
    ) -> ReadHistoryResponse:
        begin = Time.from_seconds(self.clock.now() - since)
        request = ReadHistoryRequest(device=device, capability=capability, since=begin, points=points)
        return await self._read.call(request)

    async def query(self, query: tuple[QueryTerm, ...]) -> tuple[HistorySeries, ...]:
        since = Time.from_seconds(self.clock.now() - 86_400.0)
        return (await self._read.call(ReadHistoryRequest(query=query, since=since))).series

    async def correct(
        self, device: str, capability: str, begin: float, end: float, value: float | None = None
    ) -> CorrectHistoryResponse:
        """Correct numbers between two times, in seconds after midnight."""
        since, until = (Time.from_seconds(MIDNIGHT + one) for one in (begin, end))
        request = CorrectHistoryRequest(
            device=device, capability=capability, since=since, until=until, value=value or 0.0, drops=value is None
        )
        return await self._correct.call(request)

    async def energy(
        self,
        since: float = 86_400.0,
        step: Literal["day", "hour", "month"] = "day",
        by: Literal["device", "room", "all"] = "device",
    ) -> tuple[EnergyOfDay, ...]:
        request = ReadEnergyRequest(since=Time.from_seconds(self.clock.now() - since), step=step, by=by)
        answer = await self._energy.call(request)
        assert answer.success, answer.message
        return answer.days


MakeHouse: TypeAlias = Callable[..., AbstractAsyncContextManager[KeptHouse]]


@pytest.fixture
def kept(tmp_path: Path) -> MakeHouse:
    """Makes a house; the second one is the first one after a restart."""

    @asynccontextmanager
    async def make(
        begin: float = MIDNIGHT, zone: tzinfo = UTC, settings: HistorySettings | None = None
    ) -> AsyncIterator[KeptHouse]:
        clock = SetClock(begin - anyio.current_time())
        graph = Graph(clock)
        async with (
            Node(graph, "memory", namespace="/gateway") as gateway_node,
            Node(graph, "discovery") as directory_node,
            Node(graph, "history") as node,
            Node(graph, "app") as app,
            anyio.create_task_group() as tasks,
        ):
            gateway = MemoryGateway(gateway_node)
            await tasks.start(gateway.serve)
            await tasks.start(Directory(directory_node, DirectorySettings()).serve)
            for name, kind, readable in (
                ("meter", "electrical_meter", ("power", "energy")),
                ("thermometer", "temperature_sensor", ("temperature",)),
                ("lamp", "light", ("on_off",)),
                ("button", "generic_switch", ("press",)),
            ):
                part = simple_part(kind, readable=readable)
                gateway.devices.put(GatewayDevice(name, name.title(), (part,)), "it is there")
            await anyio.sleep(1)
            history = HistoryKeeper(node, settings or HistorySettings(), tmp_path / "history.sqlite", zone)
            await tasks.start(history.serve)
            await anyio.sleep(1)
            yield KeptHouse(clock, gateway, app, history)
            tasks.cancel_scope.cancel()

    return make
