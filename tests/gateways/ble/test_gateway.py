"""The Bluetooth gateway with simulated devices on a virtual radio."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING

import anyio
import pytest
from tests.integrations.bthome.simulated.sensors import BroadcastingButton, BroadcastingSensor
from tests.simulated.ble_devices import BluetoothLight, address_of
from tests.simulated.virtual_radio import GattValue
from tests.sizes import size

from homebot.devices import GatewayState
from homebot.devices.gateway_messages import Command
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.value import Value
from homebot.errors import LinkError, RefusedError
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

if TYPE_CHECKING:
    from tests.gateways.ble.conftest import RadioHouse

pytestmark = pytest.mark.virtual_time

KEY = "231d39c1d7cc1ab1aee224cd096db932"
IBEACON = bytes.fromhex("4c000215" + "f7826da64fa24e988024bc5b71e0893e" + "00010002" + "c5")
BTHOME = b"\xd2\xfc\x40"


def info(name: str, kind: str) -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo("home425", kind, name, "sensors", "hall")


@asynccontextmanager
async def living(device: ServedDevice, state: DeviceState) -> AsyncIterator[None]:
    device.begin(state, has_power=True)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(device.live)
        yield
        tasks.cancel_scope.cancel()


async def test_a_thermometer_is_listed_with_its_measurements_signal_and_distance(radio_house: RadioHouse) -> None:
    device = BroadcastingSensor(info("attic", "thermostat"), lambda _: None, radio_house.radio)
    async with radio_house.running(), living(device, DeviceState(text="", celsius=21.5)):
        await radio_house.until(lambda: radio_house.newest(device.address, "temperature", "temperature") == 21.5)
        device.publish(DeviceState(text="", celsius=-3.25))
        await radio_house.until(lambda: radio_house.newest(device.address, "temperature", "temperature") == -3.25)
        assert radio_house.newest(device.address, "battery", "battery") == 100.0
        sighting = radio_house.sightings[device.address]
        parts = {one.id: (one.service_type, one.category) for one in sighting.parts}
        assert parts == {
            "battery": ("x_battery", "diagnostic"),
            "temperature": ("temperature_sensor", ""),
            "signal": ("x_sensor", "diagnostic"),
            "distance": ("x_sensor", "diagnostic"),
        }
        assert sighting.name == "attic"
        assert f"mac:{device.address.replace(':', '').lower()}" in sighting.identifiers
        signal = radio_house.newest(device.address, "signal", "signal_strength")
        assert isinstance(signal, float)
        assert -75 < signal < -45
        distance = radio_house.newest(device.address, "distance", "measurement")
        assert isinstance(distance, float)
        assert 0.3 < distance < 4
        assert ("distance_uncertainty", "a factor of 1.9, up or down") in {
            (one.key, one.value) for one in sighting.metadata
        }


async def test_a_device_on_a_battery_may_be_silent_for_minutes(radio_house: RadioHouse) -> None:
    device = BroadcastingSensor(info("door", "contact"), lambda _: None, radio_house.radio)
    async with radio_house.running(signal=False):
        async with living(device, DeviceState(text="open")):
            await radio_house.until(lambda: radio_house.newest(device.address, "window", "contact") is True)
        sighting = radio_house.sightings[device.address]
        assert sighting.expires_at.to_seconds() - sighting.seen_at.to_seconds() == pytest.approx(300, abs=1)
        await anyio.sleep(3600)
        assert radio_house.removed == []


async def test_each_press_of_a_button_is_one_event(radio_house: RadioHouse) -> None:
    device = BroadcastingButton(info("button", "button"), lambda _: None, radio_house.radio)
    async with radio_house.running(signal=False):
        async with living(device, DeviceState(text="")):
            for how in ("single", "single", "long"):
                device.press(how)
                await anyio.sleep(5)
        assert radio_house.values[device.address, "button", "press"] == ["single", "single", "long"]


async def test_a_device_that_encrypts_is_read_with_its_bind_key(
    radio_house: RadioHouse, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ATTIC_KEY", KEY)
    device = BroadcastingSensor(info("attic", "motion"), lambda _: None, radio_house.radio, bytes.fromhex(KEY))
    async with radio_house.running(devices={device.address: {"bind_key_env": "ATTIC_KEY", "name": "Attic"}}):
        async with living(device, DeviceState(text="motion")):
            await radio_house.until(lambda: radio_house.newest(device.address, "motion", "occupancy") is True)
        assert radio_house.sightings[device.address].name == "Attic"


async def test_a_device_without_its_bind_key_is_listed_and_reported(radio_house: RadioHouse) -> None:
    device = BroadcastingSensor(info("attic", "motion"), lambda _: None, radio_house.radio, bytes.fromhex(KEY))
    async with radio_house.running(signal=False) as gateway:
        async with living(device, DeviceState(text="motion")):
            await anyio.sleep(11)
        assert radio_house.sightings[device.address].parts == ()
        health = await radio_house.watcher.create_client(GetHealth, gateway.names.health).call(HealthRequest())
        assert health.troubles == (f"{device.address}: it is encrypted, and no bind key is configured for it",)


async def test_a_light_is_connected_to_commanded_and_reports(radio_house: RadioHouse) -> None:
    told: list[str] = []
    light = BluetoothLight(info("lamp", "lamp"), told.append, radio_house.radio)
    async with (
        radio_house.running(signal=False) as gateway,
        living(light, DeviceState(text="off", is_on=False, brightness=1.0)),
    ):
        await radio_house.until(lambda: radio_house.newest(light.address, "", "on_off") is False)
        await gateway._perform(command(light.address, "level", 50.0))
        await gateway._perform(command(light.address, "on_off", False))
        assert told == ["0.5020", "off"]
        light.publish(DeviceState(text="on", is_on=True, brightness=0.5))
        await radio_house.until(lambda: radio_house.newest(light.address, "", "on_off") is True)
        assert radio_house.newest(light.address, "", "level") == pytest.approx(50, abs=0.3)
        assert ("manufacturer", "homebot") in {
            (one.key, one.value) for one in radio_house.sightings[light.address].metadata
        }
        reachable = radio_house.newest(light.address, "", "reachable")
        assert reachable is True


async def test_a_connected_light_is_present_although_it_does_not_advertise(radio_house: RadioHouse) -> None:
    light = BluetoothLight(info("lamp", "lamp"), lambda _: None, radio_house.radio)
    async with radio_house.running(signal=False, forget_after=30.0), living(light, DeviceState(text="off")):
        await radio_house.until(lambda: radio_house.newest(light.address, "", "on_off") is False)
        before = radio_house.sightings[light.address].expires_at
        await anyio.sleep(300)
        assert radio_house.removed == []
        assert radio_house.sightings[light.address].expires_at.to_seconds() > before.to_seconds() + 200


async def test_a_light_without_power_is_unreachable_and_found_again(radio_house: RadioHouse) -> None:
    light = BluetoothLight(info("lamp", "lamp"), lambda _: None, radio_house.radio)
    async with radio_house.running(signal=False) as gateway, living(light, DeviceState(text="off")):
        await radio_house.until(lambda: radio_house.newest(light.address, "", "reachable") is True)
        light.power(on=False)
        await radio_house.until(lambda: radio_house.newest(light.address, "", "reachable") is False)
        with pytest.raises(LinkError, match="cannot be reached"):
            await gateway._perform(command(light.address, "on_off", True))
        light.power(on=True)
        await radio_house.until(lambda: radio_house.newest(light.address, "", "reachable") is True)
        await gateway._perform(command(light.address, "on_off", True))


async def test_a_light_that_leaves_while_it_is_told_is_a_lost_link(radio_house: RadioHouse) -> None:
    """Its power fails in the moment in which it gets the command."""
    service, characteristic = "6e1d0001-0000-4000-8000-0123456789ab", "6e1d0002-0000-4000-8000-0123456789ab"
    profile = {"service": service, "command": characteristic, "on": "01", "off": "00"}
    async with radio_house.running(signal=False, profiles={"lamp": profile}) as gateway:
        address = address_of("lamp")
        async with anyio.create_task_group() as tasks:

            def fail(data: bytes) -> None:
                tasks.start_soon(peripheral.lose_power)
                raise OSError("no power")  # it never answers

            values = (GattValue(characteristic, write=fail),)
            async with radio_house.radio.peripheral("lamp", address, {service: values}) as peripheral:
                services = bytes.fromhex(service.replace("-", ""))[::-1]
                await peripheral.advertise([(0x01, b"\x06"), (0x07, services)], 0.5, connectable=True)
                await radio_house.until(lambda: radio_house.newest(address, "", "reachable") is True)
                with pytest.raises((LinkError, RefusedError)):
                    await gateway._perform(command(address, "on_off", True))
                await radio_house.until(lambda: radio_house.newest(address, "", "reachable") is False)


async def test_a_device_that_is_not_what_its_profile_says_is_tried_less_and_less_often(radio_house: RadioHouse) -> None:
    """It advertises the service, and does not have the characteristic."""
    service, other = "6e1d0001-0000-4000-8000-0123456789ab", "6e1d0009-0000-4000-8000-0123456789ab"
    profile = {"service": service, "command": "6e1d0002-0000-4000-8000-0123456789ab", "on": "01", "off": "00"}
    values = (GattValue(other, read=lambda: b""),)
    async with (
        radio_house.running(signal=False, profiles={"lamp": profile}) as gateway,
        radio_house.radio.peripheral("lamp", address_of("lamp"), {service: values}) as peripheral,
    ):
        services = bytes.fromhex(service.replace("-", ""))[::-1]
        await peripheral.advertise([(0x01, b"\x06"), (0x07, services)], 0.5, connectable=True)
        await anyio.sleep(300)
        tried = peripheral.connected_times
        assert 5 < tried < 60
        with pytest.raises(LinkError, match="cannot be reached"):
            await gateway._perform(command(address_of("lamp"), "on_off", True))


async def test_more_lights_than_connections_are_all_commanded(radio_house: RadioHouse) -> None:
    told: dict[str, list[str]] = {f"lamp{number}": [] for number in range(4)}
    lights = [BluetoothLight(info(name, "lamp"), heard.append, radio_house.radio) for name, heard in told.items()]
    async with radio_house.running(signal=False, max_connections=2) as gateway, anyio.create_task_group() as tasks:
        for light in lights:
            light.begin(DeviceState(text="off"), has_power=True)
            tasks.start_soon(light.live)
        await radio_house.until(lambda: len(radio_house.sightings) == 4)
        for light in lights:
            await gateway._perform(command(light.address, "on_off", True))
        assert list(told.values()) == [["on"]] * 4
        tasks.cancel_scope.cancel()


async def test_twenty_lights_take_turns_at_five_connections_and_all_are_read(radio_house: RadioHouse) -> None:
    lights = [BluetoothLight(info(f"lamp{number}", "lamp"), lambda _: None, radio_house.radio) for number in range(20)]
    async with radio_house.running(signal=False), anyio.create_task_group() as tasks:
        for light in lights:
            light.begin(DeviceState(text="on", is_on=True), has_power=True)
            tasks.start_soon(light.live)
        await radio_house.until(lambda: len(radio_house.sightings) == 20)
        await radio_house.until(
            lambda: all(radio_house.newest(light.address, "", "on_off") is True for light in lights)
        )
        lights[0].publish(DeviceState(text="off"))
        await radio_house.until(lambda: radio_house.newest(lights[0].address, "", "on_off") is False)
        reached = [radio_house.values[light.address, "", "reachable"] for light in lights]
        assert all(set(each) == {True} for each in reached), "a light without a connection at the moment is reachable"
        tasks.cancel_scope.cancel()


async def test_lights_that_left_do_not_keep_others_from_being_connected(radio_house: RadioHouse) -> None:
    """Each attempt to connect to one that is not there takes until its timeout, and there is one attempt at a time."""
    async with radio_house.running(signal=False):
        async with AsyncExitStack() as stack:
            for number in range(15):
                gone = BluetoothLight(info(f"gone{number}", "lamp"), lambda _: None, radio_house.radio)
                await stack.enter_async_context(living(gone, DeviceState(text="off")))
            await radio_house.until(lambda: len(radio_house.sightings) == 15)
        await anyio.sleep(40)
        light = BluetoothLight(info("lamp", "lamp"), lambda _: None, radio_house.radio)
        async with living(light, DeviceState(text="off")):
            with anyio.fail_after(7):
                await radio_house.until(lambda: radio_house.newest(light.address, "", "on_off") is False)


async def test_a_thermometer_that_is_an_ibeacon_as_well_is_a_thermometer(radio_house: RadioHouse) -> None:
    """Govee's H5174, as its advertisement was recorded; all of them are one and the same iBeacon."""
    pytest.importorskip("govee_ble")
    address, beacon = "A4:C1:38:6B:6B:E0", b"\x4c\x00\x02\x15INTELLI_ROCKS_HWPu\xf2\xff\xc2"
    data = [(0x09, b"GVH5174_6BE0"), (0xFF, bytes.fromhex("0100 010102f7d664")), (0xFF, beacon)]
    async with radio_house.running(signal=False):
        radio_house.radio.transmit(address, data)
        await radio_house.until(lambda: radio_house.newest(address, "temperature", "temperature") == 19.4)
        assert radio_house.newest(address, "humidity", "humidity") == 51.8
    assert list(radio_house.sightings) == [address]


async def test_thermometers_that_are_heard_as_one_and_the_same_ibeacon_first_are_told_apart(
    radio_house: RadioHouse,
) -> None:
    """Govee's H5074: the values are in its scan response, which comes after the advertisement."""
    pytest.importorskip("govee_ble")
    beacon = (0xFF, b"\x4c\x00\x02\x15INTELLI_ROCKS_HWPu\xf2\xff\xc2")
    sent = {"A4:C1:38:00:5F:F4": ("00e609bc126402", 25.34), "A4:C1:38:00:5F:F5": ("00ce08b2126402", 22.54)}
    async with radio_house.running(signal=False):
        for _ in range(2):
            for address in sent:
                radio_house.radio.transmit(address, [(0x09, b"Govee_H5074"), beacon])
            await anyio.sleep(2)
            for address, (data, celsius) in sent.items():
                values = (0xFF, b"\x88\xec" + bytes.fromhex(data))
                radio_house.radio.transmit(address, [(0x09, b"Govee_H5074"), beacon, values])
                await anyio.sleep(1)
                assert radio_house.newest(address, "temperature", "temperature") == celsius
            assert radio_house.sightings.keys() == sent.keys()


async def test_a_beacon_is_known_by_its_identity_whatever_its_address(radio_house: RadioHouse) -> None:
    async with radio_house.running():
        for address in ("C0:00:00:00:00:01", "C0:00:00:00:00:02"):
            radio_house.radio.transmit(address, [(0x01, b"\x06"), (0xFF, IBEACON)])
            await anyio.sleep(2)
        (sighting,) = radio_house.sightings.values()
        assert sighting.key == "ibeacon:f7826da6-4fa2-4e98-8024-bc5b71e0893e/1/2"
        assert not [one for one in sighting.identifiers if one.startswith("mac:")]


@pytest.mark.parametrize(("listed", "count"), [("understood", 0), ("named", 1), ("all", 2)])
async def test_phones_do_not_fill_the_directory(radio_house: RadioHouse, listed: str, count: int) -> None:
    async with radio_house.running(listed=listed):
        radio_house.radio.transmit("D0:00:00:00:00:01", [(0x01, b"\x1a"), (0xFF, b"\x4c\x00\x10\x05\x01\x18")])
        radio_house.radio.transmit("D0:00:00:00:00:02", [(0x01, b"\x1a"), (0x09, b"Phone")])
        await anyio.sleep(1)
        assert len(radio_house.sightings) == count


async def test_a_device_that_left_the_house_is_forgotten_but_not_while_nothing_can_be_heard(
    radio_house: RadioHouse,
) -> None:
    device = BroadcastingSensor(info("attic", "thermostat"), lambda _: None, radio_house.radio)
    async with radio_house.running(forget_after=600.0):
        async with living(device, DeviceState(text="", celsius=20)):
            await radio_house.until(lambda: device.address in radio_house.sightings)
        await radio_house.radio.unplug()
        await anyio.sleep(2000)
        assert radio_house.removed == []
        radio_house.radio.plug_in()
        await anyio.sleep(500)
        assert radio_house.removed == []
        await anyio.sleep(200)
        assert radio_house.removed == [device.address]


async def test_an_adapter_that_vanishes_is_unavailable_and_comes_back(radio_house: RadioHouse) -> None:
    async with radio_house.running() as gateway:
        states = radio_house.watcher.create_subscription(GatewayState, gateway.names.state)
        await radio_house.radio.unplug()
        with anyio.fail_after(45):
            while (state := await states.receive()).state != "unavailable":
                pass
        assert "not plugged in" in state.reason
        radio_house.radio.plug_in()
        with anyio.fail_after(45):
            while (await states.receive()).state != "active":
                pass


async def test_broken_packets_of_a_known_device_are_charged_to_it_and_others_are_read(radio_house: RadioHouse) -> None:
    async with radio_house.running(signal=False) as gateway:
        bad, good = "C0:00:00:00:00:01", "C0:00:00:00:00:02"
        radio_house.radio.transmit(bad, [(0x16, BTHOME + b"\x02\xca\x09")])
        for number in range(400):
            radio_house.radio.transmit(bad, [(0x16, BTHOME + b"\x02" + bytes([number % 250]))])
            if number % 50 == 0:
                await anyio.sleep(0.01)
        radio_house.radio.transmit(good, [(0x16, BTHOME + b"\x02\x10\x00")])
        await anyio.sleep(1)
        assert radio_house.newest(good, "temperature", "temperature") == 0.16
        health = await radio_house.watcher.create_client(GetHealth, gateway.names.health).call(HealthRequest())
        assert [one.offender for one in health.quarantined] == [bad]


async def test_a_flood_of_made_up_devices_is_bounded_and_the_real_ones_are_heard(radio_house: RadioHouse) -> None:
    device = BroadcastingSensor(info("attic", "thermostat"), lambda _: None, radio_house.radio)
    async with radio_house.running(max_devices=300) as gateway, living(device, DeviceState(text="", celsius=20)):
        await radio_house.until(lambda: device.address in radio_house.sightings)
        await anyio.sleep(90)
        for number in range(size(2_000, 10_000)):
            address = ":".join(f"{one:02X}" for one in (0xC0, 0xF0, number // 256, number % 256, 1, 2))
            radio_house.radio.transmit(address, [(0x16, BTHOME + b"\x02\xca\x09")])
            if number % 100 == 0:
                await anyio.sleep(0.05)
        assert len(gateway.devices.keys) <= 300
        assert len(radio_house.sightings) <= 300
        device.publish(DeviceState(text="", celsius=25))
        await radio_house.until(lambda: radio_house.newest(device.address, "temperature", "temperature") == 25.0)
        await anyio.sleep(120)
        radio_house.radio.transmit("C0:00:00:00:00:09", [(0x16, BTHOME + b"\x02\xca\x09")])
        await anyio.sleep(1)
        assert "C0:00:00:00:00:09" in radio_house.sightings
        assert device.address in radio_house.sightings


async def test_a_sensor_of_another_maker_is_read_through_its_library_and_broken_packets_of_it_end_nothing(
    radio_house: RadioHouse,
) -> None:
    pytest.importorskip("ruuvitag_ble")
    tag = "DE:AD:7B:3F:EF:AF"
    data = bytes.fromhex("99040505a060a0c89afd34028cff006376726976dead7b3fefaf")
    async with radio_house.running(signal=False) as gateway:
        radio_house.radio.transmit(tag, [(0x01, b"\x06"), (0xFF, data)])
        await radio_house.until(lambda: radio_house.newest(tag, "temperature", "temperature") == 7.2)
        assert radio_house.newest(tag, "voltage", "voltage") == 2.395
        assert ("model", "RuuviTag") in {(one.key, one.value) for one in radio_house.sightings[tag].metadata}
        rejected = gateway.devices.counters.rejected
        radio_house.radio.transmit(tag, [(0x01, b"\x06"), (0xFF, data[:2])])
        await radio_house.until(lambda: gateway.devices.counters.rejected > rejected)
        radio_house.radio.transmit(tag, [(0x01, b"\x06"), (0xFF, data[:4] + b"\xff" + data[5:])])
        await radio_house.until(lambda: radio_house.newest(tag, "temperature", "temperature") != 7.2)


async def test_motion_that_a_sensor_reports_once_is_unknown_after_a_moment(radio_house: RadioHouse) -> None:
    """A Govee H5121 never says that it is over."""
    pytest.importorskip("govee_ble")
    sensor, data = "C1:37:37:32:0F:45", bytes.fromhex("88ef59940000f0b91937ae50b6372c866ac2f3d061e717c02cef")
    async with radio_house.running(signal=False):
        radio_house.radio.transmit(sensor, [(0x09, b"GV5121195A"), (0xFF, data)])
        await radio_house.until(lambda: radio_house.newest(sensor, "motion", "occupancy") is True)
        await anyio.sleep(60)
        assert radio_house.newest(sensor, "motion", "occupancy") is True
        await anyio.sleep(60)
        assert radio_house.newest(sensor, "motion", "occupancy") is None


def command(key: str, capability: str, value: bool | float) -> Command:  # noqa: FBT001 - a value
    return Command(key=key, part="", capability=capability, value=Value.of(value))
