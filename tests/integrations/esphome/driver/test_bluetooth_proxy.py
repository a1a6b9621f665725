"""Bluetooth proxies of ESPHome: the gateway ``ble`` against servers of the native API on loopback."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from random import Random

import anyio
import pytest
from tests.integrations.esphome.driver.proxy_server import ProxyServer, number_of, serving
from tests.integrations.esphome.driver.served import KEY, OTHER_KEY, driven, service_of
from tests.patience import PATIENCE
from tests.simulated.ble_devices import LIGHT_COMMAND, LIGHT_SERVICE, LIGHT_STATE

from homebot.clock import LoopClock
from homebot.devices import Sighting
from homebot.devices.gateway_messages import Command, Report
from homebot.devices.value import PlainValue, Value
from homebot.gateways.base import GatewayContext
from homebot.gateways.ble import BleGateway, BleGatewaySettings
from homebot.gateways.ble_proxies.hub import ProxyHub
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile
from homebot.integrations.esphome.driver import EsphomeSettings
from homebot.support.ble_proxies import BleProxies

ADDRESS = "A4:C1:38:0A:0B:0C"
LAMP = "C0:01:02:03:04:05"
KEPT = QoSProfile(depth=20_000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def bthome(packet: int, celsius: float) -> bytes:
    """An advertisement of a thermometer: flags, and a packet number and a temperature in BTHome v2."""
    measured = round(celsius * 100).to_bytes(2, "little", signed=True)
    return b"\x02\x01\x06" + b"\x09\x16\xd2\xfc\x40" + bytes((0, packet, 2)) + measured


class Watched:
    """What a gateway published."""

    def __init__(self) -> None:
        self.values: dict[tuple[str, str], list[PlainValue]] = {}
        self.sightings: dict[str, Sighting] = {}

    async def until(self, condition: Callable[[], object]) -> None:
        with anyio.fail_after(PATIENCE):
            while not condition():  # noqa: ASYNC110 - a proxy tells nobody
                await anyio.sleep(0.01)

    def has_read(self, celsius: float) -> bool:
        return self.values.get((ADDRESS, "temperature"), [])[-1:] == [celsius]

    def facts(self, key: str) -> dict[str, str]:
        return {one.key: one.value for one in self.sightings[key].metadata}

    async def sightings_of(self, node: Node, gateway: BleGateway) -> None:
        subscription = node.create_subscription(Sighting, gateway.names.received_topics, qos_profile=KEPT)
        while True:
            sighting = await subscription.receive()
            self.sightings[sighting.key] = sighting

    async def reports_of(self, node: Node, gateway: BleGateway) -> None:
        subscription = node.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
        while True:
            report = await subscription.receive()
            for one in report.readings:
                self.values.setdefault((report.key, one.capability), []).append(one.value.plain())


@asynccontextmanager
async def gateway_with(
    monkeypatch: pytest.MonkeyPatch, *proxies: dict[str, object], **settings: object
) -> AsyncIterator[tuple[BleGateway, Watched]]:
    """Run the gateway, on a computer without Bluetooth, with listed proxies."""
    monkeypatch.setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere/bus")
    checked = BleGatewaySettings.model_validate({"proxies": list(proxies), **settings})
    BleGateway.check(checked)
    (service,) = BleGateway.host_services(checked)
    graph, watched = Graph(), Watched()
    async with (
        service.start(graph, LoopClock()) as hub,
        Node(graph, "watcher") as watcher,
        Node(graph, "ble", namespace="/gateway") as node,
        anyio.create_task_group() as tasks,
    ):
        context = GatewayContext(Random(3), {service.kind: hub})  # noqa: S311 - a test
        gateway = BleGateway(node, checked, context)
        await tasks.start(gateway.serve)
        tasks.start_soon(watched.sightings_of, watcher, gateway)
        tasks.start_soon(watched.reports_of, watcher, gateway)
        yield gateway, watched
        tasks.cancel_scope.cancel()


def listed(proxy: ProxyServer, **more: object) -> dict[str, object]:
    return {"kind": "esphome", "address": proxy.host, "port": proxy.port, **more}


@pytest.fixture
def key_file(tmp_path: Path) -> Path:
    file = tmp_path / "proxy.key"
    file.write_text(KEY)
    file.chmod(0o600)
    return file


@pytest.mark.rooms("bthome")
async def test_one_advertisement_heard_by_two_is_one_reading_with_the_room_of_the_stronger(
    monkeypatch: pytest.MonkeyPatch, key_file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("DEBUG")
    kitchen, bedroom = ProxyServer("kitchen", "Kitchen", key=KEY), ProxyServer("bedroom", "Bedroom")
    async with (
        serving(kitchen, bedroom),
        gateway_with(monkeypatch, listed(kitchen, key_file=key_file), listed(bedroom)) as (_, watched),
    ):
        await kitchen.until_wanted()
        await bedroom.until_wanted()
        for packet, celsius in enumerate((20.0, 20.5, 21.0)):
            kitchen.hear((ADDRESS, -55, bthome(packet, celsius)))
            bedroom.hear((ADDRESS, -80, bthome(packet, celsius)))
            await watched.until(partial(watched.has_read, celsius))
        with anyio.fail_after(PATIENCE):
            while watched.facts(ADDRESS).get("heard_in") != "Kitchen":
                kitchen.hear((ADDRESS, -55, bthome(2, 21.0)))
                await anyio.sleep(0.2)
        assert watched.values[ADDRESS, "temperature"] == [20.0, 20.5, 21.0]
        facts = watched.facts(ADDRESS)
        assert (facts["heard_by"], facts["heard_in"], facts["heard_in_certainty"]) == ("kitchen", "Kitchen", "100%")
    assert KEY not in caplog.text


@pytest.mark.rooms("bthome")
async def test_a_proxy_that_dies_leaves_its_devices_to_the_others_and_comes_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kitchen, bedroom = ProxyServer("kitchen", "Kitchen"), ProxyServer("bedroom", "Bedroom")
    async with (
        serving(kitchen, bedroom),
        gateway_with(monkeypatch, listed(kitchen), listed(bedroom)) as (_, watched),
    ):
        await kitchen.until_wanted()
        await bedroom.until_wanted()
        kitchen.hear((ADDRESS, -50, bthome(1, 20.0)))
        await watched.until(lambda: watched.values.get((ADDRESS, "temperature")) == [20.0])
        kitchen.drop()
        await watched.until(lambda: kitchen.wants == 0)
        bedroom.hear((ADDRESS, -85, bthome(2, 21.0)))
        await watched.until(lambda: watched.values[ADDRESS, "temperature"] == [20.0, 21.0])
        await kitchen.until_wanted()
        kitchen.hear((ADDRESS, -50, bthome(3, 22.0)))
        await watched.until(lambda: watched.values[ADDRESS, "temperature"][-1] == 22.0)


@pytest.mark.rooms("bthome")
async def test_a_flood_of_one_proxy_is_bounded_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    flooded, calm = ProxyServer("flooded", "Hall"), ProxyServer("calm", "Kitchen")
    async with (
        serving(flooded, calm),
        gateway_with(monkeypatch, listed(flooded), listed(calm), listed="all") as (gateway, watched),
    ):
        await flooded.until_wanted()
        await calm.until_wanted()
        for batch in range(60):
            strangers = [(f"C2:00:00:00:{batch:02X}:{at:02X}", -60, bthome(at, 1.0)) for at in range(50)]
            flooded.hear(*strangers, (ADDRESS, 127, b""), (ADDRESS, -60, bytes(300)))
        calm.hear((ADDRESS, -60, bthome(1, 20.0)))
        await watched.until(lambda: watched.values.get((ADDRESS, "temperature")) == [20.0])
        hub = gateway._hub
        assert hub is not None
        await watched.until(lambda: hub.refused > 2_500)
        assert len(watched.sightings) < 1_000


@pytest.mark.newest("ble-proxies")
async def test_a_lamp_is_commanded_by_the_proxy_that_hears_it(monkeypatch: pytest.MonkeyPatch) -> None:
    kitchen = ProxyServer("kitchen", "Kitchen")
    kitchen.offer(LIGHT_SERVICE, {LIGHT_COMMAND: 0x08, LIGHT_STATE: 0x12})
    profile = {"service": LIGHT_SERVICE, "command": LIGHT_COMMAND, "on": "01ff", "off": "0000"}
    lamp = b"\x02\x01\x06" + b"\x11\x07" + bytes.fromhex(LIGHT_SERVICE.replace("-", ""))[::-1]
    async with (
        serving(kitchen),
        gateway_with(monkeypatch, listed(kitchen), profiles={"lamp": profile}) as (gateway, watched),
    ):
        await kitchen.until_wanted()
        kitchen.hear((LAMP, -60, lamp))
        await watched.until(lambda: number_of(LAMP) in kitchen.connected)
        order = Command(key=LAMP, part="", capability="on_off", value=Value.of(True))
        await gateway._perform(order)
        assert kitchen.written == [(number_of(LAMP), 2, b"\x01\xff")]


async def test_a_wrong_key_is_a_problem_with_a_remedy_and_not_told(
    monkeypatch: pytest.MonkeyPatch, key_file: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("DEBUG")
    kitchen = ProxyServer("kitchen", "Kitchen", key=OTHER_KEY)
    async with serving(kitchen), gateway_with(monkeypatch, listed(kitchen, key_file=key_file)) as (gateway, watched):
        problems = gateway._proxies.problems
        await watched.until(lambda: problems)
        assert "as key_file" in problems[f"{kitchen.host}:{kitchen.port}"]
    assert KEY not in caplog.text


@pytest.mark.parametrize("key", [KEY, ""])
async def test_a_proxy_that_is_found_is_taken_if_its_key_proves_that_it_is_the_owners(key: str, key_file: Path) -> None:
    kitchen = ProxyServer("kitchen", "Kitchen", key=key)
    settings = EsphomeSettings(key_file=key_file) if key else EsphomeSettings()
    with ProxyHub(LoopClock(), takes_found=True).running() as hub:
        context = GatewayContext(services={BleProxies: hub})
        async with serving(kitchen), driven(service_of(kitchen), settings, context) as run:
            await run.until_reported()
            await run.host.until(lambda: hub.has_proxy or not key)
            assert hub.has_proxy is bool(key)
        assert not hub.has_proxy
