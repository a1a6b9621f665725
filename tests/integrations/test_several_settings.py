"""Several settings of one command, as the messages of conventions with and without a message for all of them."""

import pytest
from tests.integrations.announced_parts import installed, part_with
from tests.whole_house import WHOLE_HOUSE

from homebot.conventions.description import WritesSeveral
from homebot.conventions.payload import compact_json
from homebot.devices.value import PlainValue

NIGHT: dict[str, PlainValue] = {"level": 3.0, "color_temperature": 2700.0, "on_off": True}
RED: dict[str, PlainValue] = {"level": 3.0, "color": (0.0, 100.0), "on_off": True}
LAMP = {"uniq_id": "l", "cmd_t": "l/set"}
MORE = {"clrm": True, "sup_clrm": ["color_temp", "hs"], "brightness": True}
TEMPLATES = {
    "cmd_on_tpl": "{{ state }} {{ brightness }} {{ color_temp }}",
    "cmd_off_tpl": "off",
    "bri_tpl": "{{ value }}",
    "clr_temp_tpl": "{{ value }}",
}
TOPICS = {"bri_cmd_t": "l/bri", "bri_scl": 100, "clr_temp_cmd_t": "l/ct"}


def numeric(name: str, least: float, most: float) -> dict[str, object]:
    return {"type": "numeric", "name": name, "property": name, "access": 7, "value_min": least, "value_max": most}


STATE = {"type": "binary", "name": "state", "property": "state", "access": 7, "value_on": "ON", "value_off": "OFF"}
MODE = {
    "type": "enum",
    "name": "system_mode",
    "property": "system_mode",
    "access": 7,
    "values": ["off", "auto", "heat"],
}
EXPOSES = [
    {"type": "light", "features": [STATE, numeric("brightness", 0, 254), numeric("color_temp", 150, 500)]},
    {"type": "climate", "features": [numeric("occupied_heating_setpoint", 5, 30), MODE]},
]
BRIDGED = {
    "ieee_address": "0x00124b0000000001",
    "type": "Router",
    "friendly_name": "a",
    "supported": True,
    "interview_completed": True,
    "definition": {"model": "M", "exposes": EXPOSES},
}
TASMOTA = {
    "ip": "", "dn": "D",
    "fn": ["D"], "hn": "d", "mac": "AABBCCDDEEFF", "md": "M", "state": ["OFF", "ON", "TOGGLE", "HOLD"],
    "sw": "14", "t": "d", "ft": "%prefix%/", "tp": ["c", "s", "t"], "rl": [2], "lt_st": 5, "lk": 1, "so": {}, "ver": 1,
}  # fmt: skip
RGB = {"red": 255, "green": 0, "blue": 0}
FOUND = "tasmota/discovery/AABBCCDDEEFF"
ROWS: dict[str, tuple[str, list[tuple[str, object]], dict[str, PlainValue], list[tuple[str, object]]]] = {
    "zigbee2mqtt": (
        "zigbee2mqtt",
        [("zigbee2mqtt/bridge/devices", [BRIDGED])],
        NIGHT,
        [("zigbee2mqtt/a/set", {"state": "ON", "brightness": 8, "color_temp": 370})],
    ),
    "a thermostat": (
        "zigbee2mqtt",
        [("zigbee2mqtt/bridge/devices", [BRIDGED])],
        {"thermostat_mode": "auto", "heating_setpoint": 21.0},
        [("zigbee2mqtt/a/set", {"system_mode": "auto", "occupied_heating_setpoint": 21})],
    ),
    "a thermostat that its mode turns on": (
        "homeassistant",
        [("homeassistant/climate/t/config", {"uniq_id": "t", "modes": ["off", "heat", "auto"], "mode_cmd_t": "t/set"})],
        {"on_off": True, "thermostat_mode": "auto"},
        [("t/set", "auto")],
    ),
    "json": (
        "homeassistant",
        [("homeassistant/light/l/config", {**LAMP, **MORE, "schema": "json"})],
        RED,
        [("l/set", {"state": "ON", "color": {"h": 0.0, "s": 100.0}, "brightness": 8})],
    ),
    "template": (
        "homeassistant",
        [("homeassistant/light/l/config", {**LAMP, **TEMPLATES, "schema": "template"})],
        NIGHT,
        [("l/set", "True 8 370")],
    ),
    "a topic for each": (
        "homeassistant",
        [("homeassistant/light/l/config", {**LAMP, **TOPICS})],
        NIGHT,
        [("l/bri", "3"), ("l/ct", "370"), ("l/set", "ON")],
    ),
    "tasmota": (
        "tasmota",
        [(f"{FOUND}/config", TASMOTA), (f"{FOUND}/sensors", {"sn": {}})],
        NIGHT,
        [("c/Backlog", "NoDelay;Dimmer 3;NoDelay;CT 370")],
    ),
    "shelly": (
        "shelly",
        [("shellies/announce", {"id": "shellycolorbulb-1", "model": "SHCB-1", "mac": "AABBCCDDEEFF"})],
        RED,
        [
            (
                "shellies/shellycolorbulb-1/color/0/set",
                {
                    "turn": "on",
                    "mode": "color",
                    "red": 255,
                    "green": 0,
                    "blue": 0,
                    "white": 0,
                    "gain": 3,
                    "brightness": 3,
                },
            )
        ],
    ),
}


@WHOLE_HOUSE
@pytest.mark.parametrize(("convention", "announcements", "values", "messages"), ROWS.values(), ids=ROWS)
def test_one_message_sets_all_where_the_wire_takes_that(
    convention: str,
    announcements: list[tuple[str, object]],
    values: dict[str, PlainValue],
    messages: list[tuple[str, object]],
) -> None:
    """A lamp that has a topic for each value is turned on last."""
    codec = part_with(next(iter(values)), installed(convention), *announcements).codec
    assert isinstance(codec, WritesSeveral)
    publications, names = codec.write_several(values)
    texts = [(topic, one if isinstance(one, str) else compact_json(one)) for topic, one in messages]
    assert [(one.topic, one.payload.decode()) for one in publications] == texts
    assert set(names) == set(values)
