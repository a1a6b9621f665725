import json

import pytest
from tests.integrations.announced_parts import Say, device_in, part_in

from homebot.conventions.description import (
    AnnouncementEvent,
    DeviceAnnounced,
    DeviceRequest,
    DeviceWithdrawn,
    Publication,
)
from homebot.errors import RefusedError, WireError
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.mqtt.topics import topic_matches

ID = "shellyplus2pm-a8032abe54dc"
INFO = {
    "name": "Hall",
    "id": ID,
    "mac": "A8032ABE54DC",
    "model": "SNSW-102P16EU",
    "gen": 2,
    "ver": "1.4.4",
    "app": "Plus2PM",
}
SYS = {"mac": "A8032ABE54DC", "uptime": 100}
SWITCH = {
    "id": 0,
    "output": True,
    "apower": 12.5,
    "voltage": 230.1,
    "current": 0.05,
    "freq": 50,
    "aenergy": {"total": 1500.0},
}
COVER = {"id": 0, "state": "stopped", "pos_control": True, "current_pos": 30}


def answer(result: object, source: str = ID) -> dict[str, object]:
    return {"id": 1, "src": source, "dst": "homebot", "result": result}


def introduce(
    say: Say, components: dict[str, object], *, config: object = None, info: object = None
) -> tuple[AnnouncementEvent, ...]:
    """Have a device come online and answer all questions."""
    say(f"{ID}/online", "true")
    say(f"homebot/{ID}/rpc", answer(INFO if info is None else info))
    say(
        f"homebot/{ID}/rpc", answer({"sys": {"device": {"name": None}}, **(config if isinstance(config, dict) else {})})
    )
    return say(f"homebot/{ID}/rpc", answer({"sys": SYS, **components}))


def called(publications: tuple[Publication, ...]) -> tuple[str, object]:
    (one,) = publications
    assert one.topic == f"{ID}/rpc"
    assert not one.retain
    frame = json.loads(one.payload)
    assert frame["src"] == "homebot"
    return frame["method"], frame["params"]


def test_a_device_that_comes_online_is_asked_for_its_identity(say: Say) -> None:
    (question,) = say(f"{ID}/online", "true", retained=True)
    assert isinstance(question, DeviceRequest)
    assert question.key == ID
    assert question.publications[0] == Publication(
        f"{ID}/rpc", b'{"id":1,"src":"homebot/shellyplus2pm-a8032abe54dc","method":"Shelly.GetDeviceInfo"}'
    )
    asked = [json.loads(one.payload) for one in question.publications]
    methods = ["Shelly.GetDeviceInfo", "Shelly.GetConfig", "Shelly.GetStatus", "Shelly.GetComponents"]
    assert [(one["method"], one["src"]) for one in asked] == [(one, f"homebot/{ID}") for one in methods]


def test_its_answers_describe_it(say: Say) -> None:
    device = device_in(introduce(say, {"switch:0": SWITCH}))
    assert (device.key, device.convention) == (ID, "shelly")
    assert device.name == "Hall"
    assert device.identifiers == ("mac:a8032abe54dc", f"id:{ID}")
    assert device.facts == {
        "manufacturer": "Shelly",
        "model": "SNSW-102P16EU",
        "model_id": "Plus2PM",
        "sw_version": "1.4.4",
        "generation": "2",
    }
    assert device.availability is not None
    assert device.availability.sources[0].topic == f"{ID}/online"
    (ask,) = device.parts[0].state_requests
    assert ask == Publication(
        f"{ID}/rpc", b'{"id":1,"src":"homebot/shellyplus2pm-a8032abe54dc","method":"Shelly.GetStatus"}'
    )


def test_the_same_answer_again_describes_nothing(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    assert say(f"homebot/{ID}/rpc", answer({"sys": SYS, "switch:0": {**SWITCH, "output": False}})) == ()


def test_answers_to_one_name_for_all_are_known_by_their_source(say: Say) -> None:
    say(f"{ID}/online", "true")
    say("homebot/rpc", answer(INFO))
    device = device_in(say("homebot/rpc", answer({"sys": SYS, "switch:0": SWITCH})))
    assert device.key == ID


def test_a_renamed_one_is_known_by_the_topic_it_answers_on(say: Say) -> None:
    say("kitchen/online", "true")
    say("homebot/kitchen/rpc", answer(INFO))
    heard = say("homebot/kitchen/rpc", answer({"sys": SYS, "switch:0": SWITCH}))
    relay = part_in(heard, "switch:0")
    assert relay.part.writes == ("kitchen/rpc",)
    assert relay.codec.read("kitchen/status/switch:0", b'{"output":false}', retained=False) == {"on_off": False}


def test_prefixes_of_several_levels_are_a_setting() -> None:
    shelly = Shelly(ShellySettings(client="robot", prefixes=("home/+/plug",)))
    for topic in ("home/hall/plug/online", "home/hall/plug/events/rpc", "robot/home/hall/plug/rpc", "robot/rpc"):
        assert any(topic_matches(one, topic) for one in shelly.filters()), topic
    (question,) = shelly.read_message("home/hall/plug/online", b"true", retained=False)
    assert isinstance(question, DeviceRequest)
    assert question.publications[0].topic == "home/hall/plug/rpc"


def test_one_below_shellies_is_known_by_its_notifications(say: Say) -> None:
    frame = {"src": ID, "method": "NotifyStatus", "params": {"switch:0": {"output": True}}}
    (question,) = say("shellies/hall/events/rpc", frame)
    assert isinstance(question, DeviceRequest)
    say("homebot/shellies/hall/rpc", answer(INFO))
    device = device_in(say("homebot/shellies/hall/rpc", answer({"sys": SYS, "switch:0": SWITCH})))
    assert device.key == "shellies/hall"


def test_a_silent_device_is_asked_less_and_less(say: Say) -> None:
    asked = [len(say("lookalike/online", "true")) for _ in range(64)]
    assert sum(asked) == 7
    assert len(say("lookalike/online", "true", retained=True)) == 1


def test_a_returned_device_is_asked_again(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    assert say(f"{ID}/online", "true", retained=True) == ()
    (question,) = say(f"{ID}/online", "true")
    assert isinstance(question, DeviceRequest)


def test_a_new_profile_replaces_the_old_one(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH, "switch:1": SWITCH})
    device = device_in(say(f"homebot/{ID}/rpc", answer({"sys": SYS, "cover:0": COVER})))
    assert [one.part.service_type for one in device.parts] == ["window_covering"]


def test_a_device_without_components_is_withdrawn(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    assert say(f"homebot/{ID}/rpc", answer({"sys": SYS})) == (DeviceWithdrawn(ID, "it has no components left"),)


def test_a_removed_online_topic_withdraws_it(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    assert say(f"{ID}/online", "", retained=True) == (DeviceWithdrawn(ID, "its online topic was removed"),)


def test_a_changed_configuration_is_asked_for(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    event = {"component": "switch:0", "event": "config_changed"}
    frame = {"src": ID, "method": "NotifyEvent", "params": {"events": [event]}}
    assert isinstance(say(f"{ID}/events/rpc", frame)[0], DeviceRequest)
    frame = {"src": ID, "method": "NotifyStatus", "params": {"switch:0": {"output": True}}}
    assert say(f"{ID}/events/rpc", frame) == ()


def test_a_sleeping_device_is_described_by_its_whole_status(say: Say) -> None:
    name = "shellyplusht-a8032a000001"
    status = {
        "sys": {"mac": "A8032A000001", "wakeup_period": 7200},
        "temperature:0": {"id": 0, "tC": 21.5},
        "humidity:0": {"id": 0, "rh": 45},
        "devicepower:0": {"id": 0, "battery": {"percent": 57}, "external": {"present": False}},
    }
    frame = {"src": name, "method": "NotifyFullStatus", "params": status}
    heard = say(f"{name}/events/rpc", frame)
    device = heard[0]
    assert isinstance(device, DeviceAnnounced)
    assert device.availability is None
    assert device.identifiers == ("mac:a8032a000001", f"id:{name}")
    thermometer = part_in(heard, "temperature:0").codec
    assert thermometer.read(f"{name}/events/rpc", json.dumps(frame).encode(), retained=False) == {"temperature": 21.5}
    assert thermometer.read(f"{name}/status/temperature:0", b'{"tC":null}', retained=False) == {"temperature": None}


def test_a_relay_is_switched_and_read_on_three_topics(say: Say) -> None:
    heard = introduce(say, {"switch:0": SWITCH})
    relay, meter = part_in(heard, "switch:0"), part_in(heard, "switch:0/meter").codec
    assert relay.part.service_type == "switch"
    assert called(relay.codec.write("on_off", True)) == ("Switch.Set", {"id": 0, "on": True})
    frame = json.dumps({"src": ID, "method": "NotifyStatus", "params": {"switch:0": SWITCH}}).encode()
    assert relay.codec.read(f"{ID}/events/rpc", frame, retained=False) == {"on_off": True}
    assert relay.codec.read(f"{ID}/status/switch:0", json.dumps(SWITCH).encode(), retained=False) == {"on_off": True}
    whole = json.dumps(answer({"switch:0": SWITCH})).encode()
    assert relay.codec.read(f"homebot/{ID}/rpc", whole, retained=False) == {"on_off": True}
    assert meter.read(f"{ID}/events/rpc", frame, retained=False) == {
        "power": 12.5,
        "voltage": 230.1,
        "current": 0.05,
        "frequency": 50.0,
        "energy": 1.5,
    }


def test_the_main_purpose_of_a_device_comes_first(say: Say) -> None:
    device = device_in(introduce(say, {"input:0": {"state": True}, "switch:1": SWITCH, "switch:0": SWITCH, "wifi": {}}))
    assert [one.part.id for one in device.parts if "/" not in one.part.id] == ["switch:0", "switch:1", "input:0"]


def test_a_socket_is_a_plug_with_the_name_of_its_component(say: Say) -> None:
    config = {"switch:0": {"name": "Pump"}}
    plug = part_in(introduce(say, {"switch:0": SWITCH}, info={**INFO, "app": "PlugSG3"}, config=config), "switch:0")
    assert (plug.part.service_type, plug.part.name) == ("plug", "Pump")


def test_a_cover_that_is_not_calibrated_knows_no_position(say: Say) -> None:
    cover = part_in(introduce(say, {"cover:0": {"id": 0, "state": "closed", "pos_control": False}}), "cover:0")
    assert {one.name for one in cover.part.capabilities} == {"movement"}
    with pytest.raises(RefusedError, match="movement"):
        cover.codec.write("position", 30.0)
    told = cover.codec.read(f"{ID}/status/cover:0", b'{"state":"calibrating","current_pos":null}', retained=False)
    assert told == {"movement": None, "position": None}


def test_a_button_reports_live_presses_only(say: Say) -> None:
    button = part_in(
        introduce(say, {"input:0": {"id": 0, "state": None}}, config={"input:0": {"type": "button"}}), "input:0"
    )
    assert button.part.service_type == "generic_switch"
    event = {"component": "input:0", "id": 0, "event": "double_push"}
    frame = json.dumps({"src": ID, "method": "NotifyEvent", "params": {"events": [event]}}).encode()
    assert button.codec.read(f"{ID}/events/rpc", frame, retained=False) == {"press": "double"}
    assert button.codec.read(f"{ID}/events/rpc", frame, retained=True) == {}


def test_an_answer_of_no_device_is_refused(shelly: Shelly, say: Say) -> None:
    with pytest.raises(WireError, match="src"):
        say("homebot/rpc", {"id": 1, "src": None, "result": INFO})
    with pytest.raises(WireError):
        say("homebot/rpc", "not JSON")
    assert shelly.rejected == 2


def test_other_answers_are_passed_over(say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    assert say("homebot/rpc", answer({"was_on": False})) == ()
    assert say("homebot/rpc", {"id": 1, "src": ID, "error": {"code": 404, "message": "No handler"}}) == ()


def test_unknown_devices_are_bounded(shelly: Shelly, say: Say) -> None:
    introduce(say, {"switch:0": SWITCH})
    for number in range(3000):
        say(f"stranger{number}/online", "true")
    assert shelly.reader.dropped == 1
    assert isinstance(say(f"{ID}/online", "true")[0], DeviceRequest)
    assert say(f"homebot/{ID}/rpc", answer(INFO)) == ()


def test_a_silent_device_is_described_by_its_reports(say: Say) -> None:
    (described, question) = say(f"{ID}/status/switch:0", {"id": 0, "output": True})
    assert isinstance(question, DeviceRequest)
    assert isinstance(described, DeviceAnnounced)
    assert "mac:a8032abe54dc" in described.identifiers
    assert part_in((described,), "switch:0").codec.read(
        f"{ID}/status/switch:0", b'{"output":false}', retained=False
    ) == {"on_off": False}
    more = say(f"{ID}/events/rpc", {"src": ID, "method": "NotifyStatus", "params": {"ts": 1.5, "cover:0": COVER}})
    assert isinstance(more[0], DeviceAnnounced)
    assert [one.part.id for one in more[0].parts] == ["switch:0", "cover:0"]
    assert not any(isinstance(one, DeviceAnnounced) for one in say(f"{ID}/status/switch:0", {"id": 0, "output": False}))


def test_answers_are_preferred_to_reports(say: Say) -> None:
    say(f"{ID}/status/switch:7", {"id": 7, "output": True})
    described = device_in(introduce(say, {"switch:0": SWITCH}))
    assert "switch:7" not in [one.part.id for one in described.parts]
    assert say(f"{ID}/status/switch:7", {"id": 7, "output": True}) == ()


@pytest.mark.parametrize("prefix", ["boiler", "shelly-kitchen", "shellyplus1-a8032abe54", "zigbee2mqtt"])
def test_a_prefix_without_address_is_not_described_by_reports(say: Say, prefix: str) -> None:
    assert say(f"{prefix}/status/switch:0", {"id": 0, "output": True}) == ()


def test_reports_of_a_silent_device_are_bounded(shelly: Shelly, say: Say) -> None:
    for number in range(10):
        say(f"{ID}/status/switch:{number}", {"id": number, "output": True, "x": "y" * 20_000})
    described = say(f"{ID}/status/switch:10", {"id": 10, "output": True})[0]
    assert isinstance(described, DeviceAnnounced)
    assert {one.part.id for one in described.parts} == {"switch:10", *(f"switch:{number}" for number in range(6))}
    assert shelly.reader.dropped == 4
