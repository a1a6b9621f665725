"""A Shelly device as a Bluetooth proxy, by the script of aioshelly."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Callable, Mapping
from pathlib import Path

import anyio
import pytest
from tests.gateways.drivers.driver_host import KeepingHost, found
from tests.gateways.served import served
from tests.integrations.shelly.simulated.web_device import ServedShelly
from tests.patience import PATIENCE

from homebot.clock import LoopClock
from homebot.conventions.bluetooth.broadcast import Advertisement
from homebot.gateways.base import GatewayContext
from homebot.gateways.ble_proxies.hub import ProxyHub
from homebot.gateways.ble_proxies.settings import BleProxySettings
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import as_object
from homebot.integrations.shelly.driver import ShellyDriver, ShellyDriverSettings
from homebot.integrations.shelly.listed_proxy import ShellyBleProxy
from homebot.support.ble_proxies import BleProxies

SCRIPT = "aioshelly_ble_integration"
CONTENT = bytes.fromhex("0201060916d2fc40000102c409")
GOOD = ["a4:c1:38:0a:0b:0c", -60, b64encode(CONTENT).decode(), ""]


class ScriptedShelly(ServedShelly):
    """A lamp with scripts, which sends what it hears while the script runs.

    Attributes:
        code: The code of each script by name.
        runs: Whether the script runs.
        asked: The methods on scripts that were called.
    """

    def __init__(self, password: str = "", **code: str) -> None:
        super().__init__(
            SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall"), lambda _: None, password=password
        )
        self.code = code
        self.runs = False
        self.asked: list[str] = []
        self.begin(DeviceState(text="off"), has_power=True)

    def hear(self, *advertisements: object, form: object = 2) -> None:
        """Send an event of the script."""
        event = {"component": "script:1", "id": 1, "event": "ble.scan_result", "data": [form, [*advertisements]]}
        for peer in self.server.peers:
            peer.send(json.dumps({"src": self.id, "method": "NotifyEvent", "params": {"events": [event]}}).encode())

    def _run(self, call: Mapping[str, object]) -> list[Mapping[str, object]]:
        method, params = str(call.get("method")), as_object(json.dumps(call.get("params") or {}).encode())
        if not method.startswith("Script."):
            return super()._run(call)
        answer = {"id": call.get("id"), "src": self.id, "dst": call.get("src")}
        self.asked.append(method)
        result: dict[str, object] = {}
        match method:
            case "Script.List":
                result = {"scripts": [{"id": at, "name": name} for at, name in enumerate(self.code, 1)]}
            case "Script.Create":
                self.code[str(params["name"])] = ""
            case "Script.GetCode" if not self.code[SCRIPT]:
                return [{**answer, "error": {"code": -105, "message": "no code"}}]
            case "Script.GetCode":
                result = {"data": self.code[SCRIPT]}
            case "Script.PutCode":
                self.code[SCRIPT] = str(params["code"])
            case "Script.Start":
                self.runs = True
        return [{**answer, "result": result}]


class Ears:
    """What a hub heard."""

    def __init__(self, hub: ProxyHub) -> None:
        self.hub = hub
        self.heard: list[Advertisement] = []

    def hear(self, advertisement: Advertisement, *, counts: bool) -> None:
        if counts:
            self.heard.append(advertisement)

    async def until(self, condition: Callable[[], object]) -> None:
        with anyio.fail_after(PATIENCE):
            while not condition():  # noqa: ASYNC110 - a device tells nobody
                await anyio.sleep(0.01)


async def test_a_listed_one_gets_the_script_and_what_it_hears_is_heard() -> None:
    """What is not as the script sends it is counted, and changes nothing."""
    shelly = ScriptedShelly()
    with ProxyHub(LoopClock(), takes_found=False).running() as hub:
        ears = Ears(hub)
        with hub.listening(ears.hear, lambda: None):
            async with served(shelly), anyio.create_task_group() as tasks:
                settings = BleProxySettings(kind="shelly", address="127.0.0.1", port=shelly.server.port)
                tasks.start_soon(ShellyBleProxy(settings, hub, lambda: None).run)
                await ears.until(lambda: hub.has_proxy)
                assert shelly.runs
                assert "BLE.Scanner.Start" in shelly.code[SCRIPT]
                for form, advertisement in ((2, ["x"]), (1, GOOD), (None, 5), (2, [GOOD[0], "strong", "", ""])):
                    shelly.hear(advertisement, form=form)
                shelly.hear(GOOD)
                await ears.until(lambda: ears.heard)
                tasks.cancel_scope.cancel()
    (heard,) = {one.address: one for one in ears.heard}.values()
    assert (heard.address, heard.rssi) == ("A4:C1:38:0A:0B:0C", -60)
    assert heard.service_data == {"0000fcd2-0000-1000-8000-00805f9b34fb": CONTENT[-6:]}
    assert hub.refused == 4


@pytest.mark.parametrize(
    ("password", "code", "is_taken"),
    [("correct horse", {SCRIPT: "old"}, True), ("correct horse", {}, False), ("", {SCRIPT: "old"}, False)],
)
async def test_a_found_one_is_taken_with_a_password_and_the_script_which_is_not_installed(
    password: str,
    code: dict[str, str],
    is_taken: bool,  # noqa: FBT001 - a parameter of pytest
    tmp_path: Path,
) -> None:
    shelly = ScriptedShelly(password, **code)
    file = tmp_path / "password"
    file.write_text("correct horse")
    file.chmod(0o600)
    settings = ShellyDriverSettings(password_file=file) if password else ShellyDriverSettings()
    with ProxyHub(LoopClock(), takes_found=True).running() as hub:
        host = KeepingHost(GatewayContext(services={BleProxies: hub}))
        async with served(shelly), anyio.create_task_group() as tasks:
            driver = ShellyDriver(found("_shelly._tcp.local.", shelly.server.port, gen="3"), settings, host)
            tasks.start_soon(driver.run)
            await Ears(hub).until(
                lambda: host.devices and (hub.has_proxy if is_taken else shelly.asked or not password)
            )
            tasks.cancel_scope.cancel()
    assert shelly.runs is is_taken
    assert code.keys() == shelly.code.keys()
