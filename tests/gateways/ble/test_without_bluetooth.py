"""The gateway on a computer without Bluetooth, with bleak's own backend."""

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest
from tests.patience import PATIENCE

from homebot.devices import GatewayState
from homebot.gateways.ble import BleGateway, BleGatewaySettings
from homebot.graph import Graph, Node, qos_profile_latched

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="others have no D-Bus that could be missing")


BUS = """<!DOCTYPE busconfig PUBLIC "-//freedesktop//DTD D-Bus Bus Configuration 1.0//EN"
 "http://www.freedesktop.org/standards/dbus/1.0/busconfig.dtd">
<busconfig><listen>unix:path={path}</listen><auth>EXTERNAL</auth>
<policy context="default">
<allow send_destination="*" eavesdrop="true"/><allow eavesdrop="true"/><allow own="*"/>
</policy>
</busconfig>"""


@pytest.fixture
def bus(tmp_path: Path) -> Iterator[str]:
    """A system bus on which there is no BlueZ."""
    if shutil.which("dbus-daemon") is None:
        pytest.skip("dbus-daemon is not installed")
    config = tmp_path / "bus.conf"
    config.write_text(BUS.format(path=tmp_path / "bus"))
    command = ["dbus-daemon", f"--config-file={config}", "--nofork", "--nopidfile", "--print-address"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as daemon:
        assert daemon.stdout is not None
        assert daemon.stdout.readline()
        yield f"unix:path={tmp_path / 'bus'}"
        daemon.terminate()


@pytest.mark.system
@pytest.mark.parametrize("scan", ["active", "passive"])
async def test_without_bluez_it_is_unavailable_and_says_so(
    scan: str, bus: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DBUS_SYSTEM_BUS_ADDRESS", bus)
    assert "bluetoothd is not running" in await reason(scan)


@pytest.mark.parametrize("scan", ["active", "passive"])
async def test_without_a_system_bus_it_is_unavailable_and_says_what_is_missing(
    scan: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere/bus")
    assert "there is no D-Bus" in await reason(scan)


async def reason(scan: str) -> str:
    """Why the gateway is unavailable."""
    graph = Graph()
    async with Node(graph, "ble", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        gateway = BleGateway(node, BleGatewaySettings.model_validate({"scan": scan}))
        states = watcher.create_subscription(GatewayState, gateway.names.state, qos_profile=qos_profile_latched)
        async with anyio.create_task_group() as tasks:
            with anyio.fail_after(PATIENCE):
                await tasks.start(gateway.serve)
                state = await states.receive()
            tasks.cancel_scope.cancel()
        assert state.state == "unavailable"
        return state.reason
