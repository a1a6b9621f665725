"""Shelly's devices on a channel of their own, by the answers of real models."""

from __future__ import annotations

import json
from typing import Any

import pytest
from tests.conventions.shelly.rpc_documents import MODELS, Model

from homebot.conventions.shelly.gen2_rpc import Gen2RpcDevice, RpcCall, is_setup_change
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError


def asked(model: Model) -> Gen2RpcDevice:
    device = Gen2RpcDevice(model.info["id"])
    device.record_answer("info", model.info, 100)
    device.record_answer("config", model.config, 100)
    device.record_answer("status", model.status, 100)
    device.add_page({"components": model.components, "offset": 0, "total": len(model.components)})
    return device


def values(device: Gen2RpcDevice, model: Model) -> dict[tuple[str, str], PlainValue]:
    frames = (frame({"id": 3, "src": "x", "result": model.status}), device.components_status())
    return {
        (part, name): value
        for one in frames
        for part, readings in device.read_status(one)
        for name, value in readings.items()
    }


def frame(value: object) -> bytes:
    return json.dumps(value).encode()


@pytest.mark.parametrize("address", [[], {}, 7, None])
def test_a_valve_whose_address_is_no_text_is_described(address: object) -> None:
    device = Gen2RpcDevice("shellyblugwg3-a8032abe54dc")
    device.record_answer("info", {"id": "shellyblugwg3-a8032abe54dc"}, 100)
    device.record_answer("config", {"blutrv:200": {"addr": address}, "bthomedevice:200": {"addr": address}}, 100)
    device.record_answer("status", {"blutrv:200": {"id": 200}, "bthomedevice:200": {"id": 200}}, 100)
    assert device.describe() is not None


@pytest.mark.parametrize("name", MODELS)
def test_a_model_is_described_with_its_parts(name: str) -> None:
    model = MODELS[name]
    described = asked(model).describe()
    assert described is not None
    assert {one.part.id: one.part.service_type for one in described.parts} == model.parts
    assert described.facts["model"] == model.info["model"]
    assert described.facts["sw_version"] == "1.4.4"


@pytest.mark.parametrize("name", MODELS)
def test_its_status_is_read(name: str) -> None:
    model = MODELS[name]
    device = asked(model)
    device.describe()
    assert values(device, model).items() >= model.values.items()


@pytest.mark.parametrize(
    ("name", "part", "capability", "value", "method", "params"),
    [
        ("Plus 1", "switch:0", "on_off", False, "Switch.Set", {"id": 0, "on": False}),
        ("Pro 4PM", "switch:3", "on_off", True, "Switch.Set", {"id": 3, "on": True}),
        ("Dimmer Gen3", "light:0", "level", 20.0, "Light.Set", {"id": 0, "on": True, "brightness": 20}),
        ("Plus 2PM in the profile cover", "cover:0", "movement", "open", "Cover.Open", {"id": 0}),
        ("Plus 2PM in the profile cover", "cover:0", "position", 30.0, "Cover.GoToPosition", {"id": 0, "pos": 30}),
        (
            "Plus RGBW PM in the profile rgbw",
            "rgbw:0",
            "color",
            (0.0, 100.0),
            "RGBW.Set",
            {"id": 0, "on": True, "rgb": [255, 0, 0], "white": 0},
        ),
        ("BLU Gateway with a door sensor", "boolean:200", "state", True, "Boolean.Set", {"id": 200, "value": True}),
    ],
)
def test_a_command_is_a_call(
    name: str, part: str, capability: str, value: PlainValue, method: str, params: dict[str, Any]
) -> None:
    device = asked(MODELS[name])
    device.describe()
    assert device.calls(part, capability, value, 0.0) == (RpcCall(method, params),)


def test_a_transition_is_sent_along() -> None:
    device = asked(MODELS["Dimmer Gen3"])
    device.describe()
    (call,) = device.calls("light:0", "on_off", True, 2.5)
    assert call.params == {"id": 0, "on": True, "transition_duration": 2.5}


@pytest.mark.parametrize(
    ("loads", "expected"), [(["", "Lights"], "light"), (["light", ""], "switch"), (["light"], "switch"), (7, "switch")]
)
def test_a_relay_is_a_light_by_its_configured_load(loads: object, expected: str) -> None:
    device = Gen2RpcDevice("shellyplus2pm-a8032abe54dc")
    device.record_answer("config", {"sys": {"device": {}, "ui_data": {"consumption_types": loads}}}, 100)
    device.record_answer("status", {"sys": {"uptime": 1}, "switch:1": {"id": 1, "output": True}}, 100)
    described = device.describe()
    assert described is not None
    assert [one.part.service_type for one in described.parts] == [expected]
    assert device.calls("switch:1", "on_off", False, 0.0) == (RpcCall("Switch.Set", {"id": 1, "on": False}),)


def test_a_valve_behind_a_gateway_is_described_once() -> None:
    """Its broadcasts have the battery and the temperatures of its own component again, and no button is pressed."""
    device = Gen2RpcDevice("shellyblugwg3-a8032abe54dc")
    valve = {"addr": "aa:bb:cc:dd:ee:01"}
    components = [
        {"key": "blutrv:200", "status": {"target_C": 19, "current_C": 21, "battery": 90}, "config": valve},
        {"key": "bthomedevice:200", "status": {"battery": 90, "rssi": -58}, "config": valve},
        {"key": "bthomesensor:200", "status": {"value": 90}, "config": {**valve, "obj_id": 1}},
        {"key": "bthomesensor:201", "status": {"value": 40}, "config": {"addr": "aa:bb:cc:dd:ee:02", "obj_id": 46}},
    ]
    device.add_page({"components": components, "offset": 0, "total": 4})
    described = device.describe()
    assert described is not None
    assert [one.part.id for one in described.parts] == ["blutrv:200", "blutrv:200/battery", "bthomesensor:201"]


def test_a_part_that_is_gone_is_refused() -> None:
    device = asked(MODELS["Plus 1"])
    device.describe()
    with pytest.raises(RefusedError, match="no such part any more"):
        device.calls("switch:7", "on_off", True, 0.0)


def test_a_notification_reports_changes() -> None:
    """Shelly Gen2+ API, Notifications, NotifyStatus."""
    device = asked(MODELS["Pro 4PM"])
    device.describe()
    news = {
        "src": "shellypro4pm-f008d1d8b8b8",
        "dst": "homebot",
        "method": "NotifyStatus",
        "params": {"ts": 1631186545.04, "switch:0": {"id": 0, "output": True, "source": "button"}},
    }
    assert dict(device.read_notification(frame(news))) == {"switch:0": {"on_off": True}}


def test_a_press_is_an_event() -> None:
    """Likewise NotifyEvent."""
    device = asked(MODELS["Plus i4"])
    device.describe()
    event = {"component": "input:2", "id": 2, "event": "double_push", "ts": 1631266595.44}
    news = {"src": "x", "dst": "homebot", "method": "NotifyEvent", "params": {"ts": 1631266595.44, "events": [event]}}
    assert dict(device.read_notification(frame(news))) == {"input:2": {"press": "double"}}


def test_a_sleeper_reports_its_whole_status_and_is_missed_after_two_and_a_half_periods() -> None:
    model = MODELS["H&T Gen3"]
    device = asked(model)
    device.describe()
    assert device.stale_after == 2.5 * 7200
    assert asked(MODELS["Plus 1"]).stale_after == 0
    news = {"src": "x", "dst": "ws", "method": "NotifyFullStatus", "params": {"ts": 1.0, **model.status}}
    assert dict(device.read_notification(frame(news)))["temperature:0"] == {"temperature": 14.7}


def test_a_battery_reports_only_described_values() -> None:
    model = MODELS["H&T Gen3"]
    device = Gen2RpcDevice(model.info["id"])
    device.record_answer("info", model.info, 100)
    device.record_answer("status", {"devicepower:0": {"id": 0, "battery": {"percent": 83}}}, 100)
    device.describe()
    full = frame({"method": "NotifyFullStatus", "params": model.status})
    assert dict(device.read_notification(full)) == {"devicepower:0": {"battery": 83}}


@pytest.mark.parametrize("event", ["config_changed", "component_added", "component_removed"])
def test_a_device_reports_a_changed_setup(event: str) -> None:
    events = [{"component": "sys", "event": event, "restart_required": False, "ts": 1.0, "cfg_rev": 13}]
    assert is_setup_change({"method": "NotifyEvent", "params": {"ts": 1.0, "events": events}})
    assert not is_setup_change({"method": "NotifyStatus", "params": {"events": events}})


def test_the_same_answers_are_no_news() -> None:
    device = asked(MODELS["Plus 1"])
    assert device.describe() is not None
    device.record_answer(
        "status", {**MODELS["Plus 1"].status, "switch:0": {"id": 0, "output": False, "temperature": {}}}, 100
    )
    assert device.describe() is None


def test_components_come_in_pages_and_go_when_they_are_no_longer_listed() -> None:
    model = MODELS["BLU Gateway with a door sensor"]
    device = Gen2RpcDevice(model.info["id"])
    device.record_answer("info", model.info, 100)
    device.record_answer("status", model.status, 100)
    assert device.add_page({"components": model.components[:3], "offset": 0, "total": 4}) == 3
    first = device.describe()
    assert first is not None
    assert first.parts == ()
    assert device.add_page({"components": model.components[3:], "offset": 3, "total": 4}) == 0
    second = device.describe()
    assert second is not None
    assert len(second.parts) == len(model.parts)
    assert device.add_page({"components": [], "offset": 0, "total": 0}) == 0
    third = device.describe()
    assert third is not None
    assert third.parts == ()
