"""Apps find Bluetooth devices and command them, in a homebot that has only this gateway."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random

import anyio
import pytest

from homebot.config import parse_config
from homebot.devices.devices import Devices
from homebot.devices.handles import Light, TemperatureSensor
from homebot.gateways.ble import BleBackend
from homebot.graph import Node
from homebot.house.ble_devices import BluetoothLight, BroadcastingSensor
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.virtual_radio import VirtualRadio
from homebot.runtime import Runtime

pytestmark = pytest.mark.virtual_time


@asynccontextmanager
async def found_devices(radio: VirtualRadio) -> AsyncIterator[Devices]:
    config = parse_config({"gateways": {"ble": {}}}, "test")
    backend = BleBackend(radio.scanner, radio.client)
    async with Runtime(config, with_door=False, services=[backend]) as runtime, Node(runtime.graph, "app") as node:
        yield Devices(node)


async def test_an_app_reads_a_thermometer_and_turns_on_a_light() -> None:
    told: list[str] = []
    async with VirtualRadio(Random(5)).running() as radio, found_devices(radio) as devices:  # noqa: S311
        attic = BroadcastingSensor(SimulatedDeviceInfo("h", "thermostat", "attic", "t", "attic"), print, radio)
        lamp = BluetoothLight(SimulatedDeviceInfo("h", "lamp", "lamp", "lights", "hall"), told.append, radio)
        attic.begin(DeviceState(text="", celsius=18.5), has_power=True)
        lamp.begin(DeviceState(text="off"), has_power=True)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(attic.live)
            tasks.start_soon(lamp.live)
            with anyio.fail_after(60):
                async for change in devices.follow(TemperatureSensor, below=19):
                    assert (change.handle.name, change.handle.celsius) == ("attic", 18.5)
                    break
                async for found in devices.follow(Light, on=False):
                    await found.handle.turn_on(level=40)
                    break
            assert told[0] == "0.4000"
            tasks.cancel_scope.cancel()
