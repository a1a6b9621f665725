"""Two simulated Bluetooth proxies that hear the same sensors; see ``ble_proxies.py``."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import anyio
from aioesphomeapi import api_pb2
from anyio import to_thread

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

sys.path.append(str(Path(__file__).parents[1]))
from tests.integrations.esphome.simulated.device import EsphomeServedDevice, _ApiClient
from tests.integrations.esphome.simulated.wire import ApiMessage

SENSORS = 100
BATCH = 10
REPEATS = 5
"""How often a sensor sends the same content."""

RAW = 1 | 32


class Proxy(EsphomeServedDevice):
    """A proxy, to which sensors are near or far."""

    def __init__(self, name: str, rssi: int) -> None:
        super().__init__(SimulatedDeviceInfo("home", "switch", name, "plugs", name), lambda _: None)
        self.begin(DeviceState(text="off"), has_power=True)
        self.rssi = rssi
        self.clients: list[_ApiClient] = []

    def hear(self, number: int, batch: int) -> None:
        """Send a batch of advertisements."""
        heard = []
        for at in range(number, number + batch):
            sensor, packet = at % SENSORS, at // SENSORS // REPEATS % 256
            content = b"\x02\x01\x06\x09\x16\xd2\xfc\x40" + bytes((0, packet, 2, packet, 8))
            heard.append(
                api_pb2.BluetoothLERawAdvertisement(  # type: ignore[attr-defined] # made when imported
                    address=0xA4C138000000 + sensor, rssi=self.rssi - sensor % 30, data=content
                )
            )
        for client in self.clients:
            client.put(("BluetoothLERawAdvertisementsResponse", {"advertisements": heard}))

    async def _talk(self, client: _ApiClient) -> None:
        self.clients.append(client)
        try:
            await super()._talk(client)
        finally:
            self.clients.remove(client)

    def _responses(self, name: str, fields: Mapping[str, Any]) -> tuple[ApiMessage, ...]:
        answers = super()._responses(name, fields)
        if name == "DeviceInfoRequest":
            ((kind, info),) = answers
            return (
                (kind, {**info, "bluetooth_proxy_feature_flags": RAW, "bluetooth_mac_address": self.device.device_id}),
            )
        return answers


async def main(per_second: float) -> None:
    proxies = (Proxy("kitchen", -50), Proxy("bedroom", -65))
    async with anyio.create_task_group() as tasks:
        for proxy in proxies:
            tasks.start_soon(proxy.live)
            await proxy.listening.wait()
        print(json.dumps({"ports": [proxy.port for proxy in proxies]}), flush=True)
        tasks.start_soon(_send, proxies, per_second)
        await to_thread.run_sync(sys.stdin.read)
        tasks.cancel_scope.cancel()


async def _send(proxies: tuple[Proxy, ...], per_second: float) -> None:
    sent, began = 0, anyio.current_time()
    while True:
        for proxy in proxies:
            proxy.hear(sent // len(proxies), BATCH)
            sent += BATCH
        await anyio.sleep_until(began + sent / per_second)


if __name__ == "__main__":
    anyio.run(main, float(sys.argv[1]))
