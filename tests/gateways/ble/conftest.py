"""A virtual radio with the Bluetooth gateway on it, in virtual time."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from random import Random

import anyio
import pytest
from tests.patience import PATIENCE
from tests.simulated.ble_family import LIGHT_PROFILE
from tests.simulated.virtual_bleak import backend_of
from tests.simulated.virtual_radio import VirtualRadio

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.value import PlainValue
from homebot.gateways.base import GatewayContext
from homebot.gateways.ble import BleGateway, BleGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile

KEPT = QoSProfile(depth=20_000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RadioHouse:
    """A gateway, its radio, and what it published."""

    def __init__(self) -> None:
        self.radio = VirtualRadio(Random(1))  # noqa: S311 - a simulation
        self.graph = Graph()
        self.watcher = Node(self.graph, "watcher")
        self.values: dict[tuple[str, str, str], list[PlainValue]] = {}
        self.sightings: dict[str, Sighting] = {}
        self.removed: list[str] = []

    @asynccontextmanager
    async def running(self, **settings: object) -> AsyncIterator[BleGateway]:
        """Run the gateway, and watch it."""
        context = GatewayContext.of(backend_of(self.radio), random=Random(3))  # noqa: S311
        async with (
            self.radio.running(),
            self.watcher,
            Node(self.graph, "ble", namespace="/gateway") as node,
            anyio.create_task_group() as tasks,
        ):
            gateway = BleGateway(
                node, BleGatewaySettings.model_validate({"profiles": {"light": LIGHT_PROFILE}, **settings}), context
            )
            await tasks.start(gateway.serve)
            tasks.start_soon(self._watch_sightings, gateway)
            tasks.start_soon(self._watch_reports, gateway)
            yield gateway
            tasks.cancel_scope.cancel()

    async def until(self, condition: Callable[[], object]) -> None:
        """Wait until something is so."""
        with anyio.fail_after(PATIENCE):
            while not condition():  # noqa: ASYNC110 - a radio tells nobody
                await anyio.sleep(0.1)

    def newest(self, key: str, part: str, capability: str) -> PlainValue:
        """The last value of a part; None for none."""
        found = self.values.get((key, part, capability))
        return found[-1] if found else None

    async def _watch_sightings(self, gateway: BleGateway) -> None:
        sightings = self.watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=KEPT)
        while True:
            sighting = await sightings.receive()
            if sighting.kind == "removed":
                self.removed.append(sighting.key)
                del self.sightings[sighting.key]
            else:
                self.sightings[sighting.key] = sighting

    async def _watch_reports(self, gateway: BleGateway) -> None:
        reports = self.watcher.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
        while True:
            report = await reports.receive()
            for one in report.readings:
                self.values.setdefault((report.key, one.part, one.capability), []).append(one.value.plain())


@pytest.fixture
async def radio_house() -> RadioHouse:
    return RadioHouse()
