"""Simulated Bluetooth devices as other people's libraries see them: bleak, and the parser of Home Assistant."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random
from typing import cast

import anyio
import pytest
from bleak import BleakClient, BleakScanner
from bleak.backends.client import BaseBleakClient
from bleak.backends.device import BLEDevice
from bleak.backends.scanner import AdvertisementData, BaseBleakScanner
from bthome_ble import BTHomeBluetoothDeviceData
from habluetooth import BluetoothServiceInfoBleak
from tests.integrations.bthome.simulated.sensors import BroadcastingButton, BroadcastingSensor
from tests.simulated.ble_devices import (
    LIGHT_COMMAND,
    LIGHT_SERVICE,
    LIGHT_STATE,
    BluetoothLight,
    address_of,
)
from tests.simulated.virtual_bleak import backend_of
from tests.simulated.virtual_radio import VirtualRadio

from homebot.errors import UsageError
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

KEY = bytes.fromhex("231d39c1d7cc1ab1aee224cd096db932")
Heard = list[tuple[BLEDevice, AdvertisementData]]


@asynccontextmanager
async def on_air(radio: VirtualRadio, device: ServedDevice, state: DeviceState) -> AsyncIterator[Heard]:
    """Let a device live, and hear it."""
    heard: Heard = []
    device.begin(state, has_power=True)
    scanner = BleakScanner(
        lambda found, data: heard.append((found, data)),
        backend=cast("type[BaseBleakScanner]", backend_of(radio).scanner),
    )
    async with radio.running(), scanner, anyio.create_task_group() as tasks:
        tasks.start_soon(device.live)
        await anyio.sleep(3)
        yield heard
        tasks.cancel_scope.cancel()


def radio() -> VirtualRadio:
    return VirtualRadio(Random(7))  # noqa: S311 - a simulation


def read(heard: Heard, key: bytes | None = None) -> dict[str, object]:
    """Read the last advertisement as Home Assistant does."""
    device, data = heard[-1]
    info = BluetoothServiceInfoBleak.from_device_and_advertisement_data(device, data, "", 0.0, connectable=False)
    update = BTHomeBluetoothDeviceData(bindkey=key).update(info)
    found: dict[str, object] = {one.key: value.native_value for one, value in update.entity_values.items()}
    found |= {one.key: value.native_value for one, value in update.binary_entity_values.items()}
    return found | {one.key: event.event_type for one, event in update.events.items()}


@pytest.mark.parametrize("key", [None, KEY], ids=["plain", "encrypted"])
@pytest.mark.parametrize(
    ("kind", "state", "measured"),
    [
        ("contact", DeviceState(text="open"), ("window", True)),
        ("motion", DeviceState(text="clear"), ("motion", False)),
        ("lux", DeviceState(text="", value=320.5), ("illuminance", 320.5)),
        ("power_meter", DeviceState(text="", value=1200.25), ("power", 1200.25)),
        ("thermostat", DeviceState(text="", celsius=-3.5), ("temperature", -3.5)),
    ],
)
async def test_a_sensor_broadcasts_packets_that_home_assistant_reads(
    kind: str, state: DeviceState, measured: tuple[str, object], key: bytes | None
) -> None:
    air = radio()
    device = BroadcastingSensor(SimulatedDeviceInfo("h", kind, "it", "s", "hall"), print, air, key or b"")
    async with on_air(air, device, state) as heard:
        assert measured in read(heard, key).items()
        assert {found.address for found, _ in heard} == {address_of("it")}
        assert len({data.rssi for _, data in heard}) > 1


async def test_a_button_is_silent_until_it_is_pressed() -> None:
    air = radio()
    button = BroadcastingButton(SimulatedDeviceInfo("h", "button", "it", "s", "hall"), print, air)
    async with on_air(air, button, DeviceState(text="")) as heard:
        assert heard == []
        button.press("double")
        await anyio.sleep(1)
        assert read(heard)["button"] == "double_press"
        await anyio.sleep(5)
        count = len(heard)
        await anyio.sleep(5)
        assert len(heard) == count


@pytest.mark.newest("ble")
async def test_a_light_takes_commands_and_notifies() -> None:
    air = radio()
    told: list[str] = []
    light = BluetoothLight(SimulatedDeviceInfo("h", "lamp", "it", "lights", "hall"), told.append, air)
    async with on_air(air, light, DeviceState(text="off")) as heard:
        device, data = heard[-1]
        assert data.service_uuids == [LIGHT_SERVICE]
        backend = cast("type[BaseBleakClient]", backend_of(air).client)
        async with BleakClient(device, backend=backend) as client:
            values: list[bytes] = []
            await client.start_notify(LIGHT_STATE, lambda _, value: values.append(bytes(value)))
            assert bytes(await client.read_gatt_char(LIGHT_STATE)) == b"\x00\xff"
            for command in (b"\x01\xff", b"\x01\x80", b"\x00\x80", b"\x01"):
                await client.write_gatt_char(LIGHT_COMMAND, command, response=True)
            assert told == ["on", "0.5020", "off"]
            light.publish(DeviceState(text="on", is_on=True, brightness=0.5))
            await anyio.sleep(1)
            assert values == [b"\x01\x80"]


async def test_a_light_without_power_vanishes_and_disconnects_its_client() -> None:
    air = radio()
    light = BluetoothLight(SimulatedDeviceInfo("h", "lamp", "it", "lights", "hall"), print, air)
    async with on_air(air, light, DeviceState(text="off")) as heard:
        lost = anyio.Event()
        backend = cast("type[BaseBleakClient]", backend_of(air).client)
        client = BleakClient(heard[-1][0], disconnected_callback=lambda _: lost.set(), backend=backend)
        await client.connect()
        light.power(on=False)
        with anyio.fail_after(5):
            await lost.wait()
        heard.clear()
        await anyio.sleep(10)
        assert heard == []


async def test_a_device_that_does_not_broadcast_is_refused() -> None:
    with pytest.raises(UsageError, match="'window' does not broadcast BTHome"):
        BroadcastingSensor(SimulatedDeviceInfo("h", "window", "it", "s", "hall"), print, radio())


def test_an_address_is_random_static_and_lasts() -> None:
    """Core 6.0, Vol 6, B 1.3.2.1: the two highest bits are 1."""
    assert address_of("attic") == address_of("attic") != address_of("cellar")
    assert all(int(address_of(str(number))[:2], 16) >= 0xC0 for number in range(50))
