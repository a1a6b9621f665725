"""homebot finds, reads and commands ESPHome's own firmware, compiled for this computer and announced by Avahi.

The firmware is ``peer-light.yaml`` for ESPHome's ``host`` platform, which has no mDNS of its own and cannot be compiled
with encryption without a package from a registry of boards; encryption is tested against
``tests.integrations.esphome.simulated``.
ESPHome is installed into an environment of its own, with Python 3.12, unless it is on the path or ``HOMEBOT_ESPHOME``
names it.
"""

import os
import shutil
import signal
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import ifaddr  # noqa: F401 - it starts a program when it is imported, which must not be in the event loop
import pytest
from tests.patience import PATIENCE
from tests.peers.avahi import avahi, why_no_avahi
from tests.peers.network import Lan, Machine
from tests.peers.other_python import ROOT, python_with
from tests.sizes import NIGHTLY

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand
from homebot.devices.value import PlainValue, Value
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.graph import Graph, Node, Subscription
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import KEPT

CONFIGURATION = Path(__file__).with_name("peer-light.yaml")
BUILT = ".esphome/build/peer-light/.pioenvs/peer-light/program"
KEY = "peer-light._esphomelib._tcp.local."
PORT = "16053"
COMPILE_WITHIN = 600.0


@pytest.fixture(scope="module")
def firmware() -> Path:
    """The program that is the device; to compile it takes minutes, which ``make nightly`` has."""
    folder = ROOT / "esphome-firmware"
    if (folder / BUILT).exists() and (folder / CONFIGURATION.name).read_bytes() == CONFIGURATION.read_bytes():
        return folder / BUILT
    if not NIGHTLY:
        pytest.skip("ESPHome's firmware is compiled by make nightly")
    if shutil.which("g++") is None:
        pytest.skip("g++ is not installed, which compiles ESPHome's firmware")
    program = os.environ.get("HOMEBOT_ESPHOME") or shutil.which("esphome")
    if program is None:
        program = str(Path(python_with("esphome", "3.12", "3.13")).with_name("esphome"))
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(CONFIGURATION, folder)
    command = [program, "compile", CONFIGURATION.name]
    try:
        done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True, timeout=COMPILE_WITHIN)
    except subprocess.TimeoutExpired:
        pytest.skip(f"ESPHome's firmware was not compiled within {COMPILE_WITHIN:g} s")
    if done.returncode != 0:
        pytest.skip(f"ESPHome cannot compile its firmware here: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return folder / BUILT


class Watcher:
    """What the gateway published, newest first.

    Attributes:
        values: The values by part and capability.
    """

    def __init__(self, gateway: MdnsGateway, node: Node) -> None:
        self.values: dict[tuple[str, str], PlainValue] = {}
        self._sightings = node.create_subscription(Sighting, gateway.names.received_topics, qos_profile=KEPT)
        self._reports: Subscription[Report] = node.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
        self._commands = node.create_client(SendCommand, gateway.names.send_command)

    async def described(self) -> Sighting:
        """Wait until the device is known with its parts."""
        with anyio.fail_after(PATIENCE):
            while not (sighting := await self._sightings.receive()).parts:
                pass
        return sighting

    async def until(self, part: str, capability: str, value: PlainValue) -> None:
        with anyio.fail_after(PATIENCE):
            while self.values.get((part, capability)) != value:
                for one in (await self._reports.receive()).readings:
                    self.values[one.part, one.capability] = one.value.plain()

    async def tell(self, part: str, capability: str, value: PlainValue, code: str = "") -> None:
        told = Command(key=KEY, part=part, capability=capability, value=Value.of(value), code=code)
        response = await self._commands.call(told)
        assert (response.success, response.message) == (True, "")


@asynccontextmanager
async def watching(hub: Machine) -> AsyncIterator[Watcher]:
    """Run the gateway on *hub* inside the block."""
    graph = Graph()
    settings = MdnsGatewaySettings(interfaces=(hub.address,), service_types=("_esphomelib._tcp",), announce=False)
    async with Node(graph, "watcher") as node, Node(graph, "mdns", namespace="/gateway") as gateway_node:
        gateway = MdnsGateway(gateway_node, settings)
        watcher = Watcher(gateway, node)
        async with running(gateway):
            yield watcher


@asynccontextmanager
async def announced(device: Machine) -> AsyncIterator[None]:
    """Let Avahi announce the firmware on *device* inside the block, as firmware with mDNS does itself."""
    txt = ("mac=063569abf679", "friendly_name=Peer Light", "version=2026.10.0")
    command = ("avahi-publish", "-s", "peer-light", "_esphomelib._tcp", PORT, *txt)
    async with avahi(device, *command, ready="Established"):
        yield


@pytest.mark.skipif(bool(why_no_avahi()), reason=why_no_avahi())
async def test_firmware_is_found_read_and_commanded_and_its_death_is_noticed(
    firmware: Path, lan: Lan, hub: Machine
) -> None:
    device = lan.machine("device")
    async with (
        device.program(str(firmware), ready="finished successfully") as program,
        announced(device),
        watching(hub) as watcher,
    ):
        found = await watcher.described()
        assert (found.key, found.name, found.area) == (KEY, "Peer Light", "Hall")
        assert "mac:063569abf679" in found.identifiers
        types = {part.id: part.service_type for part in found.parts}
        assert types["light_lamp"] == "light"
        assert types["switch_relay"] == "plug"
        assert {part.id for part in found.parts if part.category == "config"} == {"switch_setting", "button_restart"}

        await watcher.until("sensor_room_temperature", "temperature", 20.0)  # which the firmware has as 68 °F
        await watcher.until("binary_sensor_door", "contact", True)
        for part, capability, value in COMMANDS:
            await watcher.tell(part, capability, value)
            await watcher.until(part, capability, value)
        await watcher.tell("button_restart", "push", True)
        await watcher.until("event_bell", "press", "ring")
        await watcher.tell("alarm_control_panel_alarm", "alarm", "armed_away", code="1234")
        await watcher.until("alarm_control_panel_alarm", "alarm", "armed_away")

        await watcher.until("", "reachable", True)
        program.end(signal.SIGKILL)
        with anyio.fail_after(PATIENCE):
            await watcher.until("", "reachable", False)


COMMANDS: tuple[tuple[str, str, PlainValue], ...] = (
    ("light_lamp", "on_off", True),
    ("light_lamp", "level", 40.0),
    ("light_lamp", "color_temperature", 3000.0),
    ("light_lamp", "color", (120.0, 60.0)),
    ("light_lamp", "color_temperature", 6500.0),
    ("light_lamp", "effect", "Party"),
    ("light_lamp", "on_off", False),
    ("switch_relay", "on_off", True),
    ("cover_blind", "position", 30.0),
    ("cover_blind", "movement", "closed"),
    ("lock_front_door", "lock", "locked"),
    ("number_level", "number", 2.5),
    ("select_mode", "option", "fast"),
    ("text_label", "text", "Küche"),
    ("fan_ceiling", "fan_speed", 100.0),
    ("fan_ceiling", "direction", "reverse"),
    ("valve_water", "valve", "closed"),
    ("date_day", "text", "2027-02-03"),
)
