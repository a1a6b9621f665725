"""Devices that Home Assistant shows as several, and homebot as one by a gateway of its own.

The identifiers and unique ids are as the integrations of Home Assistant core 2026.1 write them into its registries, in
the files of ``homeassistant/components`` that each case names.
"""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple

import pytest

from homebot.conventions.description import DeviceAnnounced
from homebot.devices import Device, Sighting
from homebot.discovery import DeviceIndex
from homebot.gateways.announced.announcement import StoredAnnouncement
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.integrations.esphome.formats.device import EsphomeDevice
from homebot.integrations.homeassistant.gateway.entities import HomeAssistantEntities
from homebot.integrations.homekit.formats.accessory import parse_accessories
from homebot.integrations.homekit.gateway.accessory_runner import describe
from homebot.integrations.homekit.gateway.port import FoundAccessory
from homebot.integrations.shelly.formats.gen1 import Gen1
from homebot.integrations.shelly.formats.gen2_device import Gen2Device
from homebot.messages import Time

NOW = datetime(2026, 11, 22, 8, 0, tzinfo=UTC)
MAC = "A8032ABE54DC"
PAIRS = "A8:03:2A:BE:54:DC"


class SubDevice(NamedTuple):
    """A device of a registry that is behind another one, with its entities by their unique ids."""

    identifier: tuple[str, str]
    entities: Mapping[str, str]
    connections: Sequence[Sequence[str]] = ()


def in_home_assistant(*devices: SubDevice) -> list[Sighting]:
    """Return the devices of Home Assistant, all behind the first."""
    home = HomeAssistantEntities(100)
    ids = [f"d{number}" for number in range(len(devices))]
    entries = [
        {"entity_id": entity_id, "id": f"r-{entity_id}", "unique_id": unique_id, "device_id": device_id}
        for device_id, one in zip(ids, devices, strict=True)
        for entity_id, unique_id in one.entities.items()
    ]
    rows = [
        {
            "id": device_id,
            "name": f"Home Assistant's {device_id}",
            "area_id": device_id,
            "identifiers": [list(one.identifier)],
            "connections": [list(pair) for pair in one.connections],
            "via_device_id": "d0" if number else None,
        }
        for number, (device_id, one) in enumerate(zip(ids, devices, strict=True))
    ]
    home.registries.put("device", rows)
    home.registries.put("entity", entries)
    home.registries.put("area", [{"area_id": one, "name": f"Room {one}"} for one in ids])
    for entry in entries:
        state = {"s": "off", "a": {}, "c": "1", "lc": NOW.timestamp()}
        home.put(entry["entity_id"], state, is_new=True)
    return [sighting(home.describe(key).described(), "homeassistant") for key in home.regroup()]


def sighting(described: DeviceAnnounced, gateway: str) -> Sighting:
    """Return the first sighting of a device at its gateway, to which it has proved its identity."""
    stored = StoredAnnouncement(gateway, described.key, described)
    seen = {"kind": "appeared", "why": "it was announced", "confirmed": True, "authenticated": True}
    return stored.template.model_copy(update={**seen, "expires_at": Time.from_seconds(3600.0)})


def devices_of(*sightings: Sighting) -> tuple[Device, ...]:
    """Return the devices, which do not depend on the order of the sightings."""
    found: list[tuple[Device, ...]] = []
    for order in (sightings, sightings[::-1], sightings[1:] + sightings[:1]):
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        found.append(index.devices())
    assert len({frozenset(map(routes, devices)) for devices in found}) == 1
    return found[0]


def routes(device: Device) -> frozenset[tuple[tuple[str, str], ...]]:
    """Return the gateways and parts by which each part of a device is commanded."""
    return frozenset(tuple((one.gateway, one.part) for one in part.routes) for part in device.parts)


def relays(count: int) -> dict[str, Any]:
    return {f"switch:{number}": {"id": number, "output": False} for number in range(count)}


def shelly(components: dict[str, Any], channels: Mapping[str, str]) -> tuple[Sighting, tuple[Sighting, ...]]:
    """Return a Shelly of its own gateway and of Home Assistant, with its channels by their names there."""
    known = Gen2Device("shellypro-a8032abe54dc", {"id": "shellypro-a8032abe54dc", "mac": MAC, "gen": 2})
    known.record_answer("status", {"sys": {"mac": MAC}, **components}, 100)
    subs = [SubDevice(("shelly", f"{MAC}-{key}"), {entity: f"{MAC}-{key}"}) for key, entity in channels.items()]
    main = SubDevice(("shelly", MAC), {"sensor.rssi": f"{MAC}-rssi"}, (("mac", PAIRS),))
    ((described,), _) = known.describe("homebot", "", "")
    return sighting(described, "mqtt"), tuple(in_home_assistant(main, *subs))


def test_the_channels_of_a_shelly_are_parts_of_it() -> None:
    """``shelly/utils.py``: ``get_rpc_device_info``."""
    own, shown = shelly(relays(2), {"switch:0": "switch.first", "switch:1": "switch.second"})
    (device,) = devices_of(own, *shown)
    assert {("mqtt", "switch:0"), ("mqtt", "switch:1")} <= {route for part in routes(device) for route in part}
    assert {part for part in routes(device) if len(part) > 1} == {
        (("mqtt", "switch:0"), ("homeassistant", f"switch_{MAC}-switch:0")),
        (("mqtt", "switch:1"), ("homeassistant", f"switch_{MAC}-switch:1")),
    }


def test_the_phases_of_an_energy_meter_are_parts_of_it() -> None:
    """``shelly/utils.py``: ``get_rpc_device_info`` with ``emeter_phase``."""
    meter = {"em:0": {"id": 0, "a_act_power": 1.0, "b_act_power": 2.0, "c_act_power": 3.0, "total_act_power": 6.0}}
    phases = {f"em:0-{phase}": f"sensor.phase_{phase}" for phase in "abc"}
    own, shown = shelly(meter, phases)
    assert len(devices_of(own, *shown)) == 1


def test_channels_stay_devices_with_rooms_of_their_own_where_home_assistant_alone_has_them() -> None:
    _, shown = shelly(relays(2), {"switch:0": "switch.first", "switch:1": "switch.second"})
    assert sorted(one.area for one in devices_of(*shown)) == ["Room d0", "Room d1", "Room d2"]


def test_a_valve_behind_a_shelly_is_no_channel_of_it() -> None:
    """``shelly/utils.py``: ``get_blu_trv_device_info``; and the channels of a second Shelly are its own."""
    own, _ = shelly(relays(2), {})
    main = SubDevice(("shelly", MAC), {"sensor.rssi": f"{MAC}-rssi"}, (("mac", PAIRS),))
    valve = SubDevice(("shelly", "f8:44:77:25:f0:dd"), {"switch.valve": "x"}, (("bluetooth", "f8:44:77:25:f0:dd"),))
    other = SubDevice(("shelly", "A8032ABE54DD-switch:0"), {"switch.other": "A8032ABE54DD-switch:0"})
    assert len(devices_of(own, *in_home_assistant(main, valve, other))) == 3


def test_the_channels_of_a_shelly_of_the_first_generation_are_parts_of_it() -> None:
    """``shelly/utils.py``: ``get_block_device_info``."""
    announced = (
        b'{"id":"shellyswitch25-BE54DC","model":"SHSW-25","mac":"%s","mode":"relay","fw_ver":"1"}' % MAC.encode()
    )
    (known,) = Gen1().read_message("shellies/announce", announced)
    assert isinstance(known, DeviceAnnounced)
    main = SubDevice(("shelly", MAC), {"sensor.rssi": f"{MAC}-rssi"}, (("mac", PAIRS),))
    subs = [
        SubDevice(("shelly", f"{MAC}-relay_{number}"), {f"switch.relay_{number}": f"{MAC}-relay_{number}"})
        for number in range(2)
    ]
    (device,) = devices_of(sighting(known, "mqtt"), *in_home_assistant(main, *subs))
    assert {part for part in routes(device) if len(part) > 1} == {
        (("mqtt", f"relay:{number}"), ("homeassistant", f"switch_{MAC}-relay_{number}")) for number in range(2)
    }


@pytest.mark.parametrize("read", [(0, 11, 22), (0, 11), (11,), (0,)])
def test_the_sub_devices_of_an_esphome_device_are_parts_of_it(read: Sequence[int]) -> None:
    """``esphome/manager.py``, with the unique ids of ``esphome/entry_data.py``; all have a part of one name.

    One that homebot does not read, as it is disabled by default, is no other one.
    """
    entities = [("switch", {"key": 1, "object_id": "relay", "name": "Relay", "device_id": sub}) for sub in read]
    subs = [{"device_id": one, "name": f"Sub {one}"} for one in (11, 22)]
    known = EsphomeDevice({"mac_address": PAIRS, "name": "board", "devices": subs}, entities)
    own = GatewayDevice("board", known.name, known.parts(), identifiers=known.identifiers)
    main_entities = {"switch.main": f"{PAIRS}-switch-relay", "sensor.x": f"{PAIRS}-sensor-x"}
    main = SubDevice(("other", "x"), main_entities, (("mac", PAIRS),))
    shown = [
        SubDevice(("esphome", f"{PAIRS}_{one}"), {f"switch.sub_{one}": f"{PAIRS}-switch-relay@{one}"})
        for one in (11, 22)
    ]
    (device,) = devices_of(sighting(own.described(), "mdns"), *in_home_assistant(main, *shown))
    assert {part for part in routes(device) if len(part) > 1} == {
        (("mdns", f"switch_relay{sub}"), ("homeassistant", f"switch_{PAIRS}-switch-relay{sub}"))
        for sub in ("" if one == 0 else f"@{one}" for one in read)
    }


def lamp(aid: int) -> dict[str, Any]:
    """A lamp behind a bridge."""
    on = {"iid": 9, "type": "25", "format": "bool", "perms": ["pr", "pw", "ev"], "value": False}
    return {"aid": aid, "services": [{"iid": 8, "type": "43", "characteristics": [on]}]}


@pytest.mark.parametrize("pairing_id", ["AA:BB:CC:00:11:22", "aa:bb:cc:00:11:22"])
def test_each_accessory_behind_a_bridge_is_one_device(pairing_id: str) -> None:
    """``homekit_controller/connection.py``: ``device_info_for_accessory``."""
    found = FoundAccessory(pairing_id, "Bridge", "127.0.0.1", 1)
    accessories = parse_accessories([{"aid": 1, "services": []}, lamp(2), lamp(3)])
    own = [sighting(describe(found, one).device.described(), "homekit") for one in accessories.values()]
    shown = [
        SubDevice(
            ("homekit_controller:accessory-id", f"aa:bb:cc:00:11:22:aid:{aid}"),
            {f"light.lamp_{aid}": f"aa:bb:cc:00:11:22_{aid}_8"},
        )
        for aid in (1, 2, 4)
    ]
    devices = devices_of(*own, *in_home_assistant(*shown))
    assert sorted(tuple(sorted(one.gateway for one in device.endpoints)) for device in devices) == [
        ("homeassistant",),
        ("homeassistant", "homekit"),
        ("homeassistant", "homekit"),
        ("homekit",),
    ]


def test_a_valve_behind_a_shelly_is_a_device_of_its_own_in_both() -> None:
    """``shelly/utils.py``: ``get_blu_trv_device_info``; ``shelly/climate.py``: ``RpcBluTrvClimate``."""
    address = "f8:44:77:1d:05:54"
    known = Gen2Device("shellyblugwg3-a8032abe54dc", {"id": "shellyblugwg3-a8032abe54dc", "mac": MAC, "gen": 3})
    status = {"target_C": 17.8, "current_C": 18.5, "pos": 54, "rssi": -60, "battery": 100}
    valve = {"key": "blutrv:200", "status": status, "config": {"addr": address, "name": "Bath"}}
    known.add_page({"components": [valve], "offset": 0, "total": 1}, 0, 100)
    described, _ = known.describe("homebot", "", "")
    main = SubDevice(("shelly", MAC), {"sensor.rssi": f"{MAC}-rssi"}, (("mac", PAIRS),))
    trv = SubDevice(("shelly", address), {"climate.bath": f"{address}-blutrv:200"}, (("bluetooth", address),))
    own = [sighting(one, "mqtt") for one in described]
    found = {device.name: device for device in devices_of(*own, *in_home_assistant(main, trv))}
    assert len(found) == 2
    (thermostat, *_) = found["Bath"].parts
    assert [route.gateway for route in thermostat.routes] == ["mqtt", "homeassistant"]
