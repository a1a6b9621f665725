"""The Matter gateway with python-matter-server, the server of Home Assistant, and a light on matter.js."""

import ctypes.util
import signal
import subprocess
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest
from aiohttp import ClientSession
from tests.gateways.watched_gateway import reading, receive
from tests.peers.network import INTERFACE, Lan, Machine, Program
from tests.peers.node_package import node_folder
from tests.peers.other_python import python_with

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.names import GatewayNames
from homebot.devices.value import PlainValue, Value
from homebot.graph import Graph, Node
from homebot.integrations.matter.gateway import MatterGateway, MatterGatewaySettings
from homebot.integrations.matter.gateway.gateway import (
    Commission,
    CommissioningNames,
    CommissionRequest,
    Decommission,
    DecommissionRequest,
)
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import KEPT

DATA = Path("/data")
"""Where the Matter SDK of the server keeps its state, whatever its options say; the server gets one of its own."""

SERVER = """
import runpy
import matter_server.server.device_controller as controller

controller.NODE_RESUBSCRIBE_ATTEMPTS_UNAVAILABLE = 0  # else it takes minutes until it calls a dead device unavailable
runpy.run_module("matter_server.server", run_name="__main__", alter_sys=True)
"""
PATIENCE = 120.0
NAMES, COMMISSIONING = GatewayNames("matter"), CommissioningNames("matter")


@pytest.fixture(scope="session")
def matter_python() -> str:
    if ctypes.util.find_library("nl-route-3") is None:
        pytest.skip("the Matter SDK needs libnl-route-3 (apt-get install libnl-route-3-200)")
    return python_with("python-matter-server[server]", "3.12", "3.13")


@pytest.fixture(scope="session")
def matter_js() -> Path:
    return node_folder(Path(__file__).parent / "matter_js")


@pytest.fixture
def _data() -> Iterator[None]:
    is_new = not DATA.exists()
    DATA.mkdir(exist_ok=True)
    yield
    if is_new:
        with suppress(OSError):  # another program may use it by now
            DATA.rmdir()


@asynccontextmanager
async def server(hub: Machine, python: str, folder: Path, matter_js: Path) -> AsyncIterator[None]:
    """Run a Matter server that trusts test devices; it fetches no certificates, as it fetched some just now."""
    certificates = folder / "certificates"
    certificates.mkdir()
    subprocess.run(["node", matter_js / "root_certificate.mjs", certificates / "test.der"], check=True, timeout=60)
    (certificates / ".version").write_text("1")
    async with hub.program(
        *("sh", "-c", 'mount -t tmpfs tmpfs /data && exec "$@"', "sh", python, "-c", SERVER),
        *("--storage-path", str(folder / "server"), "--paa-root-cert-dir", str(certificates)),
        *("--primary-interface", INTERFACE, "--listen-address", "127.0.0.1"),
    ) as program:
        await program.prints("Matter Server successfully initialized", PATIENCE)
        yield


@asynccontextmanager
async def light(machine: Machine, folder: Path, matter_js: Path) -> AsyncIterator[Program]:
    command = ("node", str(matter_js / "light.mjs"), f"--storage-path={folder / 'light'}")
    async with machine.program("env", "MATTER_LOG_LEVEL=warn", *command) as program:
        await program.prints("the light runs", PATIENCE)
        yield program


async def add_scene(name: str, level: int) -> None:
    """Let the light keep scene 4, as another client of the server does."""
    values = [(6, 1), (8, level)]
    sets = [
        {"clusterID": cluster, "attributeValueList": [{"attributeID": 0, "valueUnsigned8": value}]}
        for cluster, value in values
    ]
    fields = {"groupID": 0, "sceneID": 4, "transitionTime": 0, "sceneName": name, "extensionFieldSetStructs": sets}
    command = {"node_id": 1, "endpoint_id": 1, "cluster_id": 98, "command_name": "AddScene", "payload": fields}
    async with ClientSession() as session, session.ws_connect(MatterGatewaySettings().url) as socket:
        await socket.receive_json()
        await socket.send_json({"message_id": "add", "command": "device_command", "args": command})
        assert (await socket.receive_json())["result"]["status"] == 0


async def send(node: Node, key: str, capability: str, value: PlainValue, part: str = "1") -> SendCommandResponse:
    client = node.create_client(SendCommand, NAMES.send_command)
    return await client.call(Command(key=key, part=part, capability=capability, value=Value.of(value)), timeout=60)


@pytest.mark.newest("matter")
@pytest.mark.usefixtures("_data")
async def test_a_light_is_commissioned_commanded_lost_found_and_removed(
    matter_python: str, matter_js: Path, lan: Lan, hub: Machine, tmp_path: Path
) -> None:
    graph, device = Graph(), lan.machine("light")
    async with (
        light(device, tmp_path, matter_js) as lamp,
        server(hub, matter_python, tmp_path, matter_js),
        Node(graph, "matter", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        running(MatterGateway(node, MatterGatewaySettings())),
    ):
        states = watcher.create_subscription(GatewayState, NAMES.state, qos_profile=KEPT)
        sightings = watcher.create_subscription(Sighting, NAMES.received_topics, qos_profile=KEPT)
        reports = watcher.create_subscription(Report, NAMES.readings, qos_profile=KEPT)
        assert (await states.receive()).state == "active"
        code = (await lamp.prints("pairing code ")).partition("pairing code ")[2].split()[0]
        commission = watcher.create_client(Commission, COMMISSIONING.commission)
        joined = await commission.call(CommissionRequest(code=code), timeout=PATIENCE)
        assert (joined.success, joined.message, joined.name) == (True, "", "Hall light")
        seen = await sightings.receive()
        assert (seen.kind, [part.service_type for part in seen.parts]) == ("appeared", ["light", "generic_switch"])
        await reading(reports, "on_off", False)

        assert (await send(watcher, joined.key, "on_off", True)).success
        await lamp.prints("light is on")
        await reading(reports, "on_off", True)
        assert (await send(watcher, joined.key, "level", 40.0)).success
        await lamp.prints("level is 102")
        await reading(reports, "level", 40.16)

        await add_scene("Film", level=51)
        seen = await receive(sightings, lambda one: any(part.service_type == "x_scene" for part in one.parts))
        (scene,) = [part for part in seen.parts if part.service_type == "x_scene"]
        assert (scene.id, scene.name) == ("1-scene-0-4", "Film")
        assert {one.capability: one.value.plain() for one in scene.values} == {"on_off": True, "level": 20.08}
        assert (await send(watcher, joined.key, "scene", True, scene.id)).success
        await lamp.prints("level is 51")
        await reading(reports, "level", 20.08)
        lamp.end(signal.SIGUSR2)
        await reading(reports, "press", "single")
        await reading(reports, "on_off", False)

        lamp.end(signal.SIGKILL)
        await reading(reports, "reachable", False)
        response = await send(watcher, joined.key, "on_off", True)
        assert (response.success, response.problem) == (False, "unreachable")

        async with light(device, tmp_path, matter_js) as again:
            await reading(reports, "reachable", True)
            decommission = watcher.create_client(Decommission, COMMISSIONING.decommission)
            assert (await decommission.call(DecommissionRequest(key=joined.key), timeout=PATIENCE)).success
            await again.prints("decommissioned")
        kinds = [one.kind for one in iter(sightings.take, None)]
        assert kinds[-1] == "removed"
