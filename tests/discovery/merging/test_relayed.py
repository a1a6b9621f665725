"""A Bluetooth device that several gateways receive is one device, with each part once."""

import json

import pytest
from tests.discovery.announcements import announce, part_of
from tests.integrations.shelly.formats.test_gen2_bluetooth import DOOR, DOOR_PARTS, page, valve

from homebot.conventions.bluetooth.broadcast import Advertisement, full_uuid
from homebot.conventions.description import DeviceAnnounced
from homebot.devices import Sighting
from homebot.devices.part import Part
from homebot.discovery import DeviceIndex
from homebot.gateways.announced.announcement import StoredAnnouncement
from homebot.gateways.ble.known_device import KnownDevice
from homebot.gateways.ble.settings import BleDeviceSettings
from homebot.integrations.bthome.formats.parser import BTHomeParser
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.messages import Time


def sighted(gateway: str, described: DeviceAnnounced) -> Sighting:
    stored = StoredAnnouncement(gateway, described.full_key, described)
    now, later = Time.from_seconds(1.0), Time.from_seconds(3600.0)
    return stored.template.model_copy(update={"seen_at": now, "expires_at": later, "heard_at": 1.0, "confirmed": True})


def relayed(shelly: str) -> list[Sighting]:
    """The sightings of a Shelly with a door sensor and a radiator valve behind it."""
    convention, mac = Shelly(ShellySettings()), shelly.partition("-")[2].upper()
    found: dict[str, DeviceAnnounced] = {}
    for result in (
        {"id": shelly, "mac": mac, "gen": 3, "app": "PlugSG3"},
        {"sys": {"mac": mac}, "switch:0": {"id": 0, "output": True}},
        page(*DOOR_PARTS, valve())["result"],
    ):
        frame = json.dumps({"id": 1, "src": shelly, "result": result}).encode()
        events = convention.read_message(f"homebot/{shelly}/rpc", frame, retained=False)
        found |= {one.key: one for one in events if isinstance(one, DeviceAnnounced)}
    return [sighted("mqtt", one) for one in found.values()]


def received() -> Sighting:
    """The sighting of the door sensor by homebot's own adapter."""
    packet = bytes.fromhex("44 0001 0158 2d01 3f1e00")
    advertisement = Advertisement(DOOR.upper(), -60, "SBDW-002C", service_data={full_uuid("fcd2"): packet})
    device = KnownDevice(advertisement.address, BleDeviceSettings(), None, 0.0)
    device.update(advertisement, BTHomeParser({}).read(advertisement, 0.0), 0.0)
    return sighted("ble", device.describe(signal=True).described())


def test_two_shellys_and_an_adapter_receive_one_door_sensor() -> None:
    plug, other = "shellyplugsg3-a8032abe54dc", "shellyplugsg3-a8032abe54dd"
    sightings = [*relayed(plug), received(), *relayed(other)]
    for order in (sightings, sightings[::-1]):
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        devices = {device.name: device for device in index.devices()}
        assert len(index.ids) == 4
        parts = {part.id: sorted(route.gateway for route in part.routes) for part in devices["Front door"].parts}
        assert parts == {
            **{one: ["ble", "mqtt", "mqtt"] for one in ("battery", "rotation", "window")},
            "rssi": ["mqtt", "mqtt"],
            "signal": ["ble"],
            "distance": ["ble"],
        }
        (thermostat, *_) = devices["BLU TRV 0554"].parts
        assert len(thermostat.routes) == 1


MAC = "mac:aabbccddeeff"


def marked(part: Part, *, echoed: bool, readable: bool = True) -> Part:
    changes = {"echoed": echoed, "readable": readable}
    return part.model_copy(update={"capabilities": tuple(one.model_copy(update=changes) for one in part.capabilities)})


@pytest.mark.parametrize(
    ("bridge", "other", "echoed"),
    [
        ({"echoed": False}, {"echoed": True}, False),
        ({"echoed": True}, {"echoed": False}, False),
        ({"echoed": True}, {"echoed": True}, True),
        ({"echoed": True}, {"echoed": False, "readable": False}, True),
    ],
)
def test_one_honest_way_is_enough(bridge: dict[str, bool], other: dict[str, bool], *, echoed: bool) -> None:
    index = DeviceIndex(forget_after=1000.0)
    lamp = part_of("light", "on_off", id="l")
    index.observe(announce("a", marked(lamp, **bridge), ids=(MAC,), gateway="radio"), 0.0)
    index.observe(announce("b", marked(lamp, **other), ids=(MAC,), gateway="cable"), 0.0)
    (device,) = index.devices()
    (merged,) = device.parts
    assert {one.echoed for one in merged.part.capabilities} == {echoed}
