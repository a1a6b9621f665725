"""Bluetooth devices behind a Shelly are devices of their own.

The components are those of real gateways with BLU TRV, BLU Door/Window and BLU RC Button 4 (source: answers to
``Shelly.GetComponents`` in prometheus exporters and ShellyScanner; events of Shelly Gen2+ API, BTHomeDevice).
"""

import json
from collections.abc import Mapping

import pytest
from tests.integrations.announced_parts import Say
from tests.integrations.shelly.formats.rpc_documents import ANSWERS, ID

from homebot.conventions.bluetooth.broadcast import Advertisement, full_uuid
from homebot.conventions.description import AnnouncementEvent, DescribedPart, DeviceAnnounced, DeviceWithdrawn
from homebot.integrations.bthome.formats.parser import BTHomeParser

TRV, DOOR, REMOTE, OLD = "f8:44:77:1d:05:54", "3c:2e:f5:71:d5:2a", "7c:c6:b6:a5:c9:3d", "7c:c6:b6:a5:c9:3e"


def component(
    key: str, address: object, status: Mapping[str, object], *, model: int = 0, **config: object
) -> dict[str, object]:
    return {
        "key": key,
        "status": {"id": int(key.partition(":")[2]), **status},
        "config": {"addr": address, "name": None, "meta": None, **config},
        "attrs": {"flags": 17, "model_id": model},
    }


def valve(target: float = 17.8, **config: object) -> dict[str, object]:
    status = {"target_C": target, "current_C": 18.5, "pos": 54, "connected": True, "rssi": -60, "battery": 100}
    heard = {"packet_id": 243, "last_updated_ts": 1766497610, "fw_ver": "v1.2.10"}
    return component("blutrv:200", TRV, {**status, **heard}, model=8, trv="bthomedevice:200", **config)


VALVE_SENDER = component("bthomedevice:200", TRV, {"rssi": -60, "battery": 100, "fw_ver": "v1.2.10"}, model=8)
VALVE_SENSOR = component("bthomesensor:203", TRV, {"value": 100}, obj_id=1, idx=0)
DOOR_PARTS = (
    component("bthomedevice:201", DOOR, {"rssi": -59, "battery": 88, "last_updated_ts": 7}, model=2, name="Front door"),
    component("bthomesensor:200", DOOR, {"value": 88, "last_updated_ts": 7}, obj_id=1, idx=0),
    component("bthomesensor:201", DOOR, {"value": 3.0, "last_updated_ts": 7}, obj_id=63, idx=0),
    component("bthomesensor:202", DOOR, {"value": True, "last_updated_ts": 7}, obj_id=45, idx=0),
)
REMOTE_PARTS = (component("bthomedevice:202", REMOTE, {"rssi": -53, "battery": 100}, model=7),)


def page(*components: object) -> dict[str, object]:
    result = {"components": list(components), "cfg_rev": 3, "offset": 0, "total": len(components)}
    return {"id": 1, "src": ID, "dst": f"homebot/{ID}", "result": result}


def devices(events: tuple[AnnouncementEvent, ...]) -> dict[str, DeviceAnnounced]:
    return {one.key.partition("/")[2]: one for one in events if isinstance(one, DeviceAnnounced)}


def parts(device: DeviceAnnounced) -> dict[str, DescribedPart]:
    return {one.part.id: one for one in device.parts}


def test_each_is_a_device_with_its_own_identity_and_is_reachable_while_the_shelly_is(gateway: Say) -> None:
    found = devices(gateway(ANSWERS, page(valve(), VALVE_SENDER, VALVE_SENSOR, *DOOR_PARTS, *REMOTE_PARTS)))
    assert found.keys() == {"", TRV, DOOR, REMOTE}
    whole, door = found[""], found[DOOR]
    assert (whole.name, whole.parts) == ("Gateway", ())
    assert door.identifiers == (f"mac:{DOOR.replace(':', '')}",)
    assert (door.name, found[TRV].name, found[REMOTE].name) == ("Front door", "BLU TRV 0554", "BLU RC Button 4 C93D")
    assert door.facts == {
        "manufacturer": "Shelly",
        "model": "BLU Door/Window",
        "model_id": "SBDW-002C",
        "address": DOOR.upper(),
        "via_device": ID,
    }
    assert found[TRV].facts["sw_version"] == "v1.2.10"
    assert door.availability == whole.availability
    assert (door.whole_device, door.implies_alive, door.area) == (False, False, "")


def test_the_parts_are_those_of_its_own_broadcasts(gateway: Say) -> None:
    """The same packet at an adapter of homebot, so that both are one device with each part once."""
    behind = parts(devices(gateway(ANSWERS, page(*DOOR_PARTS)))[DOOR])
    packet = bytes.fromhex("44 0001 0158 2d01 3f1e00")
    advertisement = Advertisement(DOOR.upper(), -60, service_data={full_uuid("fcd2"): packet})
    heard = BTHomeParser({}).read(advertisement, 0.0)
    assert heard is not None
    own = {one.id: (one.service_type, one.tag, one.category, one.capabilities) for one in heard.parts}
    assert (
        own.items()
        <= {
            name: (one.part.service_type, one.part.tag, one.part.category, one.part.capabilities)
            for name, one in behind.items()
        }.items()
    )
    assert behind.keys() - own.keys() == {"rssi"}


def test_a_valve_is_a_thermostat_and_its_broadcasts_add_nothing(gateway: Say) -> None:
    found = parts(devices(gateway(ANSWERS, page(valve(name="Bath"), VALVE_SENDER, VALVE_SENSOR)))[TRV])
    assert list(found) == ["thermostat", "battery", "rssi"]
    codec = found["thermostat"].codec
    assert codec.read(ANSWERS, json.dumps(page(valve())).encode(), retained=False) == {
        "heating_setpoint": 17.8,
        "local_temperature": 18.5,
        "position": 54.0,
    }
    (call,) = codec.write("heating_setpoint", 21.0)
    frame = json.loads(call.payload)
    assert (call.topic, frame["method"]) == (f"{ID}/rpc", "BluTRV.Call")
    assert frame["params"] == {"id": 200, "method": "TRV.SetTarget", "params": {"id": 0, "target_C": 21.0}}


def test_each_button_of_a_remote_has_its_own_presses(gateway: Say) -> None:
    found = parts(devices(gateway(ANSWERS, page(*REMOTE_PARTS)))[REMOTE])
    assert [one for one in found if one.startswith("button")] == ["button", "button_2", "button_3", "button_4"]
    event = {"component": "bthomedevice:202", "id": 202, "event": "long_double_push", "idx": 2, "ts": 1.0}
    frame = json.dumps({"method": "NotifyEvent", "params": {"events": [event]}}).encode()
    heard = {name: one.codec.read(f"{ID}/events/rpc", frame, retained=False) for name, one in found.items()}
    assert {name: values for name, values in heard.items() if values} == {"button_3": {"press": "long_double"}}


@pytest.mark.parametrize(("key", "index"), [("bthomesensor:204", None), ("bthomedevice:203", 1)])
def test_a_button_that_was_added_with_older_firmware_is_read_from_both_components(
    gateway: Say, key: str, index: int | None
) -> None:
    """From firmware 1.6 on its component stays, and its events come from the device."""
    old = [component(f"bthomesensor:{203 + one}", OLD, {}, obj_id=58, idx=one, name=f"Key {one}") for one in (0, 1)]
    device = component("bthomedevice:203", OLD, {"rssi": -60})
    found = parts(devices(gateway(ANSWERS, page(device, *old)))[OLD])
    event = {"component": key, "event": "single_push", **({} if index is None else {"idx": index})}
    frame = json.dumps({"method": "NotifyEvent", "params": {"events": [event]}}).encode()
    heard = {one.part.name: one.codec.read(f"{ID}/events/rpc", frame, retained=False) for one in found.values()}
    assert {name: values for name, values in heard.items() if values} == {"Key 1": {"press": "single"}}


def test_an_unknown_model_has_one_button(gateway: Say) -> None:
    found = devices(gateway(ANSWERS, page(component("bthomedevice:203", OLD, {"rssi": -60}))))[OLD]
    assert (found.name, list(parts(found))) == ("Bluetooth device C93E", ["button", "rssi"])
    assert "manufacturer" not in found.facts


def test_rain_at_a_weather_station_is_no_leak(gateway: Say) -> None:
    rain = component("bthomesensor:204", OLD, {"value": False}, obj_id=32, idx=0)
    found = devices(gateway(ANSWERS, page(component("bthomedevice:203", OLD, {"rssi": -60}, model=11), rain)))[OLD]
    assert {name: one.part.service_type for name, one in parts(found).items()} == {
        "rain": "x_binary_sensor",
        "rssi": "x_sensor",
    }


def test_an_answer_without_a_new_packet_is_no_sign_of_life(gateway: Say) -> None:
    """A gateway answers with what it heard last, also a week after the battery is empty."""
    window = parts(devices(gateway(ANSWERS, page(*DOOR_PARTS)))[DOOR])["window"].codec
    frame = json.dumps(page(*DOOR_PARTS)).encode()
    assert window.read(ANSWERS, frame, retained=False) == {"contact": True}
    assert window.read(ANSWERS, frame, retained=False) == {}
    later = frame.replace(b'"last_updated_ts": 7', b'"last_updated_ts": 8')
    assert window.read(ANSWERS, later, retained=False) == {"contact": True}


def test_a_removed_one_is_withdrawn_and_a_changed_one_alone_is_announced(gateway: Say) -> None:
    gateway(ANSWERS, page(valve(), *DOOR_PARTS))
    assert gateway(ANSWERS, page(valve(target=22.0), *DOOR_PARTS)) == ()
    assert devices(gateway(ANSWERS, page(valve(name="Bath"), *DOOR_PARTS))).keys() == {TRV}
    assert gateway(ANSWERS, page(valve(name="Bath"))) == (DeviceWithdrawn(f"{ID}/{DOOR}", "it has no components left"),)
    gone = gateway(f"{ID}/online", "")
    assert {one.key for one in gone if isinstance(one, DeviceWithdrawn)} == {ID, f"{ID}/{TRV}"}


@pytest.mark.parametrize("address", [[], {}, 7, None])
def test_one_without_an_address_is_left_out(gateway: Say, address: object) -> None:
    assert gateway(ANSWERS, page(component("bthomedevice:200", address, {"rssi": -60}))) == ()
