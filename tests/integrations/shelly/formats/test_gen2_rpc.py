"""Shelly's devices on a channel of their own, by the answers of real models."""

import json
from typing import Any

import pytest
from tests.integrations.shelly.formats.rpc_documents import MODELS, Model

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.shelly.formats.gen2_rpc import Gen2RpcDevice, is_setup_change


def asked(model: Model) -> Gen2RpcDevice:
    device = Gen2RpcDevice(model.info["id"])
    device.record_answer("info", model.info, 100)
    device.record_answer("config", model.config, 100)
    device.record_answer("status", model.status, 100)
    device.add_page({"components": model.components, "offset": 0, "total": len(model.components)})
    return device


def values(device: Gen2RpcDevice, model: Model) -> Any:
    found: dict[str, dict[str, PlainValue]] = {}
    for one in (frame({"id": 3, "src": "x", "result": model.status}), device.components_status()):
        for (_, part), readings in device.read_status(one):
            found.setdefault(part, {}).update(readings)
    return json.loads(json.dumps(found))  # a colour is a list in the documents


def frame(value: object) -> bytes:
    return json.dumps(value).encode()


@pytest.mark.parametrize("name", MODELS)
def test_a_model_is_described_with_its_parts(name: str) -> None:
    model = MODELS[name]
    described = asked(model).describe()
    assert {one.part.id: one.part.service_type for device in described for one in device.parts} == model.parts
    assert described[0].facts["model"] == model.info["model"]
    assert described[0].facts["sw_version"] == "1.4.4"


@pytest.mark.parametrize("name", MODELS)
def test_its_status_is_read(name: str) -> None:
    model = MODELS[name]
    device = asked(model)
    device.describe()
    found = values(device, model)
    assert all(found[part].items() >= expected.items() for part, expected in model.values.items())


def test_a_command_is_a_call() -> None:
    device = asked(MODELS["Dimmer Gen3"])
    device.describe()
    params = {"id": 0, "on": True, "brightness": 20, "transition_duration": 2.5}
    assert device.calls((device.id, "light:0"), {"level": 20.0}, 2.5)[0] == (("Light.Set", params),)


@pytest.mark.parametrize(
    ("loads", "expected"), [(["", "Lights"], "light"), (["light", ""], "switch"), (["light"], "switch"), (7, "switch")]
)
def test_a_relay_is_a_light_by_its_configured_load(loads: object, expected: str) -> None:
    device = Gen2RpcDevice("shellyplus2pm-a8032abe54dc")
    device.record_answer("config", {"sys": {"device": {}, "ui_data": {"consumption_types": loads}}}, 100)
    device.record_answer("status", {"sys": {"uptime": 1}, "switch:1": {"id": 1, "output": True}}, 100)
    (described,) = device.describe()
    assert [one.part.service_type for one in described.parts] == [expected]
    assert device.calls((device.id, "switch:1"), {"on_off": False}, 0.0)[0] == (("Switch.Set", {"id": 1, "on": False}),)


def test_a_part_that_is_gone_is_refused() -> None:
    device = asked(MODELS["Plus 1"])
    device.describe()
    with pytest.raises(RefusedError, match="no such part any more"):
        device.calls((device.id, "switch:7"), {"on_off": True}, 0.0)


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
    assert dict(device.read_notification(frame(news))) == {(device.id, "switch:0"): {"on_off": True}}


def test_a_sleeper_reports_its_whole_status_and_is_missed_after_two_and_a_half_periods() -> None:
    model = MODELS["H&T Gen3"]
    device = asked(model)
    device.describe()
    assert device.stale_after == 2.5 * 7200
    assert asked(MODELS["Plus 1"]).stale_after == 0
    news = {"src": "x", "dst": "ws", "method": "NotifyFullStatus", "params": {"ts": 1.0, **model.status}}
    assert dict(device.read_notification(frame(news)))[(device.id, "temperature:0")] == {"temperature": 14.7}


def test_a_battery_reports_only_described_values() -> None:
    model = MODELS["H&T Gen3"]
    device = Gen2RpcDevice(model.info["id"])
    device.record_answer("info", model.info, 100)
    device.record_answer("status", {"devicepower:0": {"id": 0, "battery": {"percent": 83}}}, 100)
    device.describe()
    full = frame({"method": "NotifyFullStatus", "params": model.status})
    assert dict(device.read_notification(full)) == {(device.id, "devicepower:0"): {"battery": 83}}


@pytest.mark.parametrize("event", ["config_changed", "component_added", "component_removed"])
def test_a_device_reports_a_changed_setup(event: str) -> None:
    events = [{"component": "sys", "event": event, "restart_required": False, "ts": 1.0, "cfg_rev": 13}]
    assert is_setup_change({"method": "NotifyEvent", "params": {"ts": 1.0, "events": events}})
    assert not is_setup_change({"method": "NotifyStatus", "params": {"events": events}})


def test_the_same_answers_are_no_news() -> None:
    device = asked(MODELS["Plus 1"])
    assert device.describe()
    device.record_answer(
        "status", {**MODELS["Plus 1"].status, "switch:0": {"id": 0, "output": False, "temperature": {}}}, 100
    )
    assert device.describe() == ()


def test_components_come_in_pages_and_go_when_they_are_no_longer_listed() -> None:
    model = MODELS["BLU Gateway with a door sensor"]
    device = Gen2RpcDevice(model.info["id"])
    device.record_answer("info", model.info, 100)
    device.record_answer("status", model.status, 100)
    assert device.add_page({"components": model.components[:3], "offset": 0, "total": 4}) == 3
    (first,) = device.describe()
    assert first.parts == ()
    assert device.add_page({"components": model.components[3:], "offset": 3, "total": 4}) == 0
    assert sum(len(one.parts) for one in device.describe()) == len(model.parts)
    assert device.add_page({"components": [], "offset": 0, "total": 0}) == 0
    assert [one.parts for one in device.describe()] == [()]
