from collections.abc import Mapping
from typing import Any

import pytest
from tests.integrations.announced_parts import Say, device_in, heard, part_in, told

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn, Publication
from homebot.errors import RefusedError, WireError
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.mqtt.topics import topic_matches

PLUG = {
    "id": "shellyplug-s-122881",
    "model": "SHPLG-S",
    "mac": "A8032A122881",
    "ip": "192.168.1.50",
    "new_fw": False,
    "fw_ver": "20230913-112003/v1.14.0-gcb84623",
}
ROLLER = {"id": "shellyswitch25-033453", "model": "SHSW-25", "mac": "A8032A033453", "mode": "roller"}
BULB = {"id": "shellybulb-099CF9", "model": "SHBLB-1", "mac": "A8032A099CF9"}


def ids(events: tuple[AnnouncementEvent, ...]) -> dict[str, str]:
    return {one.part.id: one.part.service_type for one in device_in(events).parts}


def test_all_are_asked_to_announce_themselves_at_the_start(shelly: Shelly) -> None:
    assert shelly.birth_messages() == (
        Publication("shellies/command", b"announce"),
        Publication("shellies/command", b"update"),
    )


def test_an_announcement_describes_a_plug(say: Say) -> None:
    device = device_in(say("shellies/announce", PLUG))
    assert device.key == "shellies/shellyplug-s-122881"
    assert device.identifiers == ("mac:a8032a122881", "id:shellyplug-s-122881")
    assert device.facts["model"] == "SHPLG-S"
    assert device.availability is not None
    assert device.availability.sources[0].topic == "shellies/shellyplug-s-122881/online"
    assert device.availability.sources[0].read(b"true") is True
    assert device.availability.sources[0].read(b"false") is False
    assert device.availability.sources[0].read(b"maybe") is None
    assert device.parts[0].state_requests == (Publication("shellies/shellyplug-s-122881/command", b"update"),)
    assert all(not one.state_requests for one in device.parts[1:])


def test_the_same_announcement_on_its_second_topic_counts_once(say: Say) -> None:
    device_in(say("shellies/announce", PLUG))
    assert say("shellies/shellyplug-s-122881/announce", PLUG) == ()
    assert device_in(say("shellies/announce", PLUG)).topic == "shellies/announce"
    assert device_in(say("shellies/shellyplug-s-122881/announce", {**PLUG, "fw_ver": "2"})).facts["sw_version"] == "2"


BULB_STATUS = '{"ison":true,"mode":"MODE","red":255,"green":128,"blue":0,"gain":30,"brightness":60,"temp":4000}'
MOTION_STATUS = '{"motion":true,"vibration":false,"lux":100,"bat":80,"tmp":{"value":21.5,"is_valid":false}}'
VALVE_STATUS = '{"thermostats":[{"pos":40,"target_t":{"value":21},"tmp":{"value":20.5,"is_valid":true}}],"bat":80}'
WARM_STATUS = '{"pos":40,"target_t":{"value":68,"units":"F"},"tmp":{"value":59,"units":"F","is_valid":true}}'
MOTION = {"id": "shellymotion2-233F91", "model": "SHMOS-02"}
VALVE = {"id": "shellytrv-256273", "model": "SHTRV-01"}
WARM = {"heating_setpoint": 20.0, "local_temperature": 15.0, "position": 40.0}
COOL = {"heating_setpoint": 21.0, "local_temperature": 20.5, "position": 40.0}
Thing = tuple[dict[str, Any], str, str, dict[str, Mapping[str, object]], dict[tuple[object, ...], str]]
THINGS: dict[str, Thing] = {
    "a plug is switched": (
        PLUG, "relay:0", "plug", {"relay/0 on": {"on_off": True}, "relay/0 overpower": {"on_off": False}},
        {("on_off", True): "relay/0/command on", ("on_off", False): "relay/0/command off"},
    ),
    "a plug measures": (
        PLUG, "relay:0/meter", "electrical_meter",
        {"relay/0/power 12.34": {"power": 12.34}, "relay/0/energy 60000": {"energy": 1.0}}, {},
    ),
    "999 is no temperature": (
        PLUG, "temperature", "temperature_sensor",
        {"temperature 999": {"temperature": None}, "temperature 21.5": {"temperature": 21.5}, "temperature hot": {}},
        {},
    ),
    "a thermometer tells its unit elsewhere": (  # bieniu/ha-shellies-discovery#143
        {"id": "shellyht-746E93", "model": "SHHT-1"}, "temperature", "temperature_sensor",
        {"sensor/temperature 23.62": {"temperature": 23.62},
         'info {"tmp":{"value":74.3,"units":"F","tC":23.5,"tF":74.3,"is_valid":true}}': {"temperature": 23.5},
         "sensor/temperature 74.3": {"temperature": 23.5}, "sensor/temperature 999": {"temperature": None}},
        {},
    ),
    "a switch in roller mode is a covering": (
        ROLLER, "roller:0", "window_covering",
        {"roller/0 close": {"movement": "closing"}, "roller/0/pos 30": {"position": 30.0},
         "roller/0/pos -1": {"position": None}},
        {("position", 30.0): "roller/0/command/pos 30", ("movement", "open"): "roller/0/command open",
         ("movement", "closed"): "roller/0/command close", ("movement", "stopped"): "roller/0/command stop"},
    ),
    "the meter of a Shelly 2 has no index": (
        {"id": "shellyswitch-A8032A000000", "model": "SHSW-21", "mode": "relay"}, "meter", "electrical_meter",
        {"relay/power 5": {"power": 5.0}}, {},
    ),
    "a meter counts drawn and returned energy": (
        {"id": "shellyem3-A8032A1339F2", "model": "SHEM-3"}, "emeter:0", "electrical_meter",
        {"emeter/0/total 1500.0": {"energy": 1.5}, "emeter/0/total_returned 250.0": {"energy_returned": 0.25}}, {},
    ),
    "the first press of a sleeping button counts": (
        {"id": "shellybutton1-1CD6EB", "model": "SHBTN-1"}, "input:0", "generic_switch",
        {'input_event/0 {"event":"L","event_cnt":1}': {"press": "long"}}, {},
    ),
    "a bulb shows a colour or a white": (
        BULB, "color:0", "light",
        {f"color/0/status {BULB_STATUS.replace('MODE', 'color')}":
            {"on_off": True, "level": 30.0, "color_temperature": None, "color": (30.118, 100.0)},
         f"color/0/status {BULB_STATUS.replace('MODE', 'white')}":
            {"on_off": True, "level": 60.0, "color_temperature": 4000.0, "color": None}},
        {("on_off", True): "color/0/command on", ("level", 0.0): "color/0/command off",
         ("on_off", False, 2.0): 'color/0/set {"turn":"off","transition":2000}',
         ("level", 0.2): 'color/0/set {"turn":"on","gain":1,"brightness":1}',
         ("level", 40.0): 'color/0/set {"turn":"on","gain":40,"brightness":40}',
         ("color_temperature", 4000.0): 'color/0/set {"turn":"on","mode":"white","temp":4000}',
         ("color", (120.0, 100.0)):
            'color/0/set {"turn":"on","mode":"color","red":0,"green":255,"blue":0,"white":0}'},
    ),
    "a motion sensor reports all in one message": (
        MOTION, "motion", "occupancy_sensor", {f"status {MOTION_STATUS}": {"occupancy": True}}, {},
    ),
    "and vibration": (MOTION, "vibration", "x_binary_sensor", {f"status {MOTION_STATUS}": {"vibration": False}}, {}),
    "and light": (MOTION, "lux", "light_sensor", {f"status {MOTION_STATUS}": {"illuminance": 100.0}}, {}),
    "and its temperature": (
        MOTION, "temperature", "temperature_sensor", {f"status {MOTION_STATUS}": {"temperature": None}}, {},
    ),
    "and its battery": (MOTION, "battery", "x_battery", {f"status {MOTION_STATUS}": {"battery": 80.0}}, {}),
    "commands of a radiator valve are degrees": (
        VALVE, "thermostat:0", "thermostat", {f"status {VALVE_STATUS}": COOL, f"info {VALVE_STATUS}": COOL},
        {("heating_setpoint", 21.5): "thermostat/0/command/target_t 21.5"},
    ),
    "commands of a Fahrenheit valve are Fahrenheit": (
        VALVE, "thermostat:0", "thermostat", {f"status {WARM_STATUS}": WARM},
        {("heating_setpoint", 21.5): "thermostat/0/command/target_t 70.7"},
    ),
    "a valve may change its unit": (
        VALVE, "thermostat:0", "thermostat",
        {f"status {WARM_STATUS}": WARM, 'status {"target_t":{"value":20,"units":"C"}}': {"heating_setpoint": 20.0}},
        {("heating_setpoint", 21.5): "thermostat/0/command/target_t 21.5"},
    ),
}  # fmt: skip


@pytest.mark.parametrize(("device", "part_id", "service_type", "reports", "orders"), THINGS.values(), ids=THINGS)
def test_a_part_is_read_and_told(
    say: Say,
    device: dict[str, Any],
    part_id: str,
    service_type: str,
    reports: dict[str, Mapping[str, object]],
    orders: dict[tuple[Any, ...], str],
) -> None:
    part, base = part_in(say("shellies/announce", device), part_id), f"shellies/{device['id']}"
    assert part.part.service_type == service_type
    for report, expected in reports.items():
        topic, _, payload = report.partition(" ")
        assert heard(part, f"{base}/{topic}", payload) == expected
    for order, publication in orders.items():
        topic, _, payload = publication.partition(" ")
        assert told(part, *order) == [(f"{base}/{topic}", payload)]


def test_parts_follow_from_the_model(say: Say) -> None:
    assert list(ids(say("shellies/announce", PLUG))) == ["relay:0", "relay:0/meter", "temperature", "overtemperature"]
    assert "relay:0" not in ids(say("shellies/announce", ROLLER))
    motion = {"id": "shellymotionsensor-233F91", "model": "SHMOS-01"}
    assert list(ids(say("shellies/announce", motion))) == ["motion", "vibration", "lux", "battery"]


def test_a_position_out_of_bounds_is_refused(say: Say) -> None:
    with pytest.raises(RefusedError, match="0 to 100"):
        told(part_in(say("shellies/announce", ROLLER), "roller:0"), "position", 101.0)


@pytest.mark.parametrize(
    ("messages", "movement"),
    [
        (("open", "stop", "pos 100"), "open"),
        (("open", "pos 100", "stop"), "open"),
        (("pos 100", "close", "stop", "pos 0"), "closed"),
        (("close", "pos 20", "pos 0", "stop"), "closed"),
        (("pos 0", "open", "stop"), "stopped"),
        (("stop",), None),
        (("stop", "pos 100"), "open"),
        (("open", "stop", "pos 40"), "stopped"),
        (("open", "stop", "pos -1"), "stopped"),
        (("pos 0", "open"), "opening"),
        (("open", "pos 100"), "opening"),
    ],
)
def test_a_roller_that_stopped_at_an_end_is_open_or_closed(
    say: Say, messages: tuple[str, ...], movement: str | None
) -> None:
    roller = part_in(say("shellies/announce", ROLLER), "roller:0")
    topic = "shellies/shellyswitch25-033453/roller/0"
    values: dict[str, object] = {}
    for one in messages:
        word, _, position = one.partition(" ")
        message = (f"{topic}/pos", position) if position else (topic, word)
        values |= roller.codec.read(message[0], message[1].encode(), retained=False)
    assert values.get("movement") == movement


def test_a_mode_that_is_not_announced_shows_by_the_topics(say: Say) -> None:
    assert "roller:0" not in ids(say("shellies/announce", {**ROLLER, "mode": None}))
    assert "roller:0" in ids(say("shellies/shellyswitch25-033453/roller/0", "stop"))


def test_the_other_modes_topics_do_not_count(say: Say) -> None:
    say("shellies/announce", ROLLER)
    assert say("shellies/shellyswitch25-033453/relay/0/power", "0") == ()


def test_an_old_announcement_without_model_is_known_by_its_id(say: Say) -> None:
    heard = say("shellies/announce", {"id": "shellyplug-s-122881", "mac": "A8032A122881"})
    assert device_in(heard).facts["model"] == "SHPLG-S"
    assert ids(heard)["relay:0"] == "plug"


def test_an_accessory_is_described_with_its_first_report(say: Say) -> None:
    say("shellies/announce", PLUG)
    topic = "shellies/shellyplug-s-122881/ext_temperature/0"
    assert ids(say(topic, "21.5"))["ext_temperature:0"] == "temperature_sensor"
    assert say(topic, "21.6") == ()


def test_85_degrees_of_an_external_probe_are_no_reading(say: Say) -> None:
    say("shellies/announce", PLUG)
    topic = "shellies/shellyplug-s-122881/ext_temperature/0"
    probe = part_in(say(topic, "21.5"), "ext_temperature:0")
    read = [probe.codec.read(topic, told, retained=False) for told in (b"85", b"84.9", b"999")]
    assert read == [{}, {"temperature": 84.9}, {"temperature": None}]


def test_a_device_without_announcement_is_described_once_online(say: Say) -> None:
    assert say("shellies/hall/relay/0", "on") == ()
    assert ids(say("shellies/hall/online", "true", retained=True)) == {"relay:0": "switch"}
    assert device_in(say("shellies/hall/relay/1", "on")).identifiers == ()


def test_a_new_name_replaces_the_old_one(say: Say) -> None:
    say("shellies/shellyplug-s-122881/announce", PLUG)
    gone, there = say("shellies/kitchen/announce", PLUG)
    assert gone == DeviceWithdrawn("shellies/shellyplug-s-122881", "it has been renamed kitchen")
    assert isinstance(there, DeviceAnnounced)
    assert there.key == "shellies/kitchen"
    assert there.identifiers == ("mac:a8032a122881",)
    assert device_in(say("shellies/announce", {**PLUG, "fw_ver": "2"})).key == "shellies/kitchen"


@pytest.mark.parametrize(("device_id", "model"), [("shellyht-077A17", "SHHT-1"), ("shellysmoke2-077A17", "SHSM-02")])
def test_a_sleeping_device_has_no_availability(say: Say, device_id: str, model: str) -> None:
    device = device_in(say("shellies/announce", {"id": device_id, "model": model}))
    assert device.availability is None


def test_a_repeated_press_is_none(say: Say) -> None:
    button = part_in(say("shellies/announce", {"id": "shellyix3-1BC57A", "model": "SHIX3-1"}), "input:0").codec
    topic = "shellies/shellyix3-1BC57A/input_event/0"
    assert button.read(topic, b'{"event":"S","event_cnt":4}', retained=True) == {}
    assert button.read(topic, b'{"event":"S","event_cnt":4}', retained=False) == {}
    assert button.read(topic, b'{"event":"SS","event_cnt":5}', retained=False) == {"press": "double"}
    assert button.read(topic, b'{"event":"SS","event_cnt":5}', retained=False) == {}
    assert button.read(topic, b'{"event":"","event_cnt":6}', retained=False) == {}


def test_a_press_after_a_new_description_is_not_the_first_one(say: Say) -> None:
    """The device announces itself at each link, and is described anew when it is heard on one more topic."""
    switch = {"id": "shellyix3-1BC57A", "model": "SHIX3-1"}
    topic = "shellies/shellyix3-1BC57A/input_event/0"
    before = part_in(say("shellies/announce", switch), "input:0").codec
    assert before.read(topic, b'{"event":"S","event_cnt":4}', retained=False) == {}
    after = part_in(say("shellies/announce", {**switch, "fw_ver": "2"}), "input:0").codec
    assert after.read(topic, b'{"event":"S","event_cnt":4}', retained=False) == {}
    assert after.read(topic, b'{"event":"S","event_cnt":5}', retained=False) == {"press": "single"}


@pytest.mark.parametrize(("device_id", "first"), [("shellydw2-189127", "state"), ("shellyem-A8032A1339F2", "emeter:0")])
def test_the_main_purpose_of_a_device_comes_first(say: Say, device_id: str, first: str) -> None:
    assert next(iter(ids(say("shellies/announce", {"id": device_id})))) == first


@pytest.mark.parametrize(
    "announcement", ["", "[]", "{", {"mac": "A8032A122881"}, {"id": "a/b"}, {"id": 3}, {"id": "x", "mac": 3}]
)
def test_a_broken_announcement_is_refused_and_counted(shelly: Shelly, say: Say, announcement: object) -> None:
    with pytest.raises(WireError):
        say("shellies/announce", announcement)
    assert shelly.rejected == 1


def test_more_devices_than_there_is_room_for_push_out_unknown_ones(shelly: Shelly, say: Say) -> None:
    say("shellies/announce", PLUG)
    for number in range(5000):
        say(f"shellies/x{number}/relay/0", "on")
    assert shelly.reader.dropped == 1
    assert ids(say("shellies/announce", PLUG))


def test_the_filters_match_the_topics_of_parts(shelly: Shelly) -> None:
    for suffix in ("announce", "online", "relay/0", "relay/0/power", "light/0/status", "sensor/flood", "status"):
        topic = f"shellies/shellyplug-s-122881/{suffix}"
        assert any(topic_matches(one, topic) for one in shelly.filters()), suffix
    assert not any(topic_matches(one, "shellies/x/relay/0/command") for one in shelly.filters())


GAS = {"id": "shellygas-122881", "model": "SHGS-1", "mac": "A8032A122881"}


def test_a_gas_detector_without_its_valve_has_none(say: Say) -> None:
    say("shellies/announce", GAS)
    assert say("shellies/shellygas-122881/valve/0/state", "not_connected") == ()


def test_the_valve_of_a_gas_detector_is_a_valve(say: Say) -> None:
    """As enesbcs/shellyteacher4domo, issue 53, and the changes of firmware 1.9.2 name the topics."""
    say("shellies/announce", GAS)
    valve = part_in(say("shellies/shellygas-122881/valve/0/state", "opened"), "valve:0")
    assert (valve.part.service_type, valve.part.tag) == ("water_valve", "gas")
    topic = "shellies/shellygas-122881/valve/0"
    assert any(topic_matches(one, f"{topic}/state") for one in Shelly(ShellySettings()).filters())
    states = [b"opened", b"closing", b"closed", b"checking", b"not_connected"]
    read = [valve.codec.read(f"{topic}/state", one, retained=False)["valve"] for one in states]
    assert read == ["open", "closing", "closed", None, None]
    assert valve.codec.write("valve", "closed") == (Publication(f"{topic}/command", b"close"),)
