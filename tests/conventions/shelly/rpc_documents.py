"""Answers of Shelly's devices to GetDeviceInfo, GetConfig and GetStatus, as firmware 1.x sends them.

Source: Shelly Gen2+ API, pages of the devices and components; values are made up, and what no part needs is shortened.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["MODELS", "Model"]

Fields = dict[str, Any]


@dataclass(frozen=True)
class Model:
    """One device: its answers, and what homebot is to make of them: parts with their types, and values."""

    info: Fields
    config: Fields
    status: Fields
    parts: dict[str, str]
    values: dict[tuple[str, str], Any]
    components: list[Fields] = field(default_factory=list)


def info(device_id: str, model: str, app: str, gen: int = 2, **more: Any) -> Fields:
    return {
        "name": None,
        "id": device_id,
        "mac": device_id.rpartition("-")[2].upper(),
        "slot": 0,
        "model": model,
        "gen": gen,
        "fw_id": "20241011-114455/1.4.4-g6d2a586",
        "ver": "1.4.4",
        "app": app,
        "auth_en": False,
        "auth_domain": None,
        **more,
    }


def config(name: str | None, **components: Any) -> Fields:
    system = {
        "device": {"name": name, "mac": "A8032ABE54DC", "fw_id": "x", "discoverable": True, "eco_mode": False},
        "location": {"tz": "Europe/Berlin", "lat": 52.5, "lon": 13.4},
        "debug": {"mqtt": {"enable": False}, "websocket": {"enable": False}, "udp": {"addr": None}},
        "ui_data": {},
        "rpc_udp": {"dst_addr": None, "listen_port": None},
        "sntp": {"server": "time.google.com"},
        "cfg_rev": 12,
    }
    return {
        "ble": {"enable": True, "rpc": {"enable": True}},
        "cloud": {"enable": False, "server": "iot.shelly.cloud:6012/jrpc"},
        "mqtt": {"enable": False, "server": None, "client_id": "x", "topic_prefix": "x"},
        "sys": system,
        "wifi": {"sta": {"ssid": "home", "is_open": False, "enable": True}},
        "ws": {"enable": False, "server": None, "ssl_ca": "ca.pem"},
        **{key.replace("_", ":"): value for key, value in components.items()},
    }


def status(**components: Any) -> Fields:
    system = {
        "mac": "A8032ABE54DC",
        "restart_required": False,
        "time": "14:02",
        "unixtime": 1732197720,
        "uptime": 12345,
        "ram_size": 260364,
        "ram_free": 135420,
        "fs_size": 458752,
        "fs_free": 131072,
        "cfg_rev": 12,
        "kvs_rev": 0,
        "schedule_rev": 0,
        "webhook_rev": 0,
        "available_updates": {},
        "reset_reason": 3,
    }
    return {
        "ble": {},
        "cloud": {"connected": False},
        "mqtt": {"connected": False},
        "sys": {**system, **components.pop("sys", {})},
        "wifi": {"sta_ip": "192.168.1.20", "status": "got ip", "ssid": "home", "rssi": -61},
        "ws": {"connected": False},
        **{key.replace("_", ":"): value for key, value in components.items()},
    }


def metered(number: int, *, output: bool, watts: float) -> Fields:
    return {
        "id": number,
        "source": "HTTP_in",
        "output": output,
        "apower": watts,
        "voltage": 231.4,
        "freq": 50.0,
        "current": 0.053,
        "aenergy": {"total": 1234.5, "by_minute": [0.0, 1.2, 3.4], "minute_ts": 1732197660},
        "ret_aenergy": {"total": 0.0, "by_minute": [0.0, 0.0, 0.0], "minute_ts": 1732197660},
        "temperature": {"tC": 41.3, "tF": 106.3},
    }


PRO_SWITCHES = {f"switch:{number}": "switch" for number in range(4)}
PRO_METERS = {f"switch:{number}/meter": "electrical_meter" for number in range(4)}
PRO_TEMPERATURES = {f"switch:{number}/temperature": "temperature_sensor" for number in range(4)}

MODELS = {
    "Plus 1": Model(
        info("shellyplus1-a8032abe54dc", "SNSW-001X16EU", "Plus1"),
        config(
            "Boiler room",
            input_0={"id": 0, "name": None, "type": "switch", "enable": True, "invert": False},
            switch_0={"id": 0, "name": "Pump", "in_mode": "follow", "initial_state": "restore_last", "auto_on": False},
        ),
        status(
            input_0={"id": 0, "state": False},
            switch_0={"id": 0, "source": "init", "output": True, "temperature": {"tC": 53.1, "tF": 127.5}},
        ),
        {"switch:0": "switch", "switch:0/temperature": "temperature_sensor", "input:0": "x_binary_sensor"},
        {("switch:0", "on_off"): True, ("switch:0/temperature", "temperature"): 53.1, ("input:0", "state"): False},
    ),
    "Plus Plug S": Model(
        info("shellyplusplugs-e86beae5b2f4", "SNPL-00112EU", "PlusPlugS"),
        config(
            "Washing machine",
            plugs_ui={"leds": {"mode": "switch"}},
            switch_0={"id": 0, "name": None, "power_limit": 2500, "autorecover_voltage_errors": False},
        ),
        status(switch_0=metered(0, output=True, watts=12.3), plugs_ui={}),
        {
            "switch:0": "plug",
            "switch:0/meter": "electrical_meter",
            "switch:0/temperature": "temperature_sensor",
        },
        {
            ("switch:0", "on_off"): True,
            ("switch:0/meter", "power"): 12.3,
            ("switch:0/meter", "energy"): 1.2345,
            ("switch:0/meter", "energy_returned"): 0,
            ("switch:0/meter", "voltage"): 231.4,
            ("switch:0/meter", "frequency"): 50,
        },
    ),
    "Pro 4PM": Model(
        info("shellypro4pm-f008d1d8b8b8", "SPSW-004PE16EU", "Pro4PM", name="Cabinet"),
        config(
            "Cabinet",
            **{f"switch_{number}": {"id": number, "name": f"Circuit {number}"} for number in range(4)},
            **{f"input_{number}": {"id": number, "type": "button"} for number in range(4)},
            eth={"enable": True, "ipv4mode": "dhcp"},
        ),
        status(
            **{f"switch_{number}": metered(number, output=number == 2, watts=100.0 * number) for number in range(4)},
            **{f"input_{number}": {"id": number, "state": None} for number in range(4)},
            eth={"ip": "192.168.1.21"},
        ),
        {
            **PRO_SWITCHES,
            **PRO_METERS,
            **PRO_TEMPERATURES,
            **{f"input:{number}": "generic_switch" for number in range(4)},
        },
        {
            ("switch:1", "on_off"): False,
            ("switch:2", "on_off"): True,
            ("switch:3/meter", "power"): 300,
        },
    ),
    "Plus RGBW PM in the profile rgbw": Model(
        info("shellyplusrgbwpm-ecc9ff4d3a1c", "SNDC-0D4P10WW", "PlusRGBWPM", profile="rgbw"),
        config("Shelf", rgbw_0={"id": 0, "name": None, "initial_state": "restore_last", "transition_duration": 3.0}),
        status(
            rgbw_0={
                "id": 0,
                "source": "WS_in",
                "output": True,
                "rgb": [0, 0, 255],
                "brightness": 40,
                "white": 0,
                "temperature": {"tC": 44.0, "tF": 111.2},
                "aenergy": {"total": 10.0, "by_minute": [0.0, 0.0, 0.0], "minute_ts": 1732197660},
                "apower": 3.1,
                "current": 0.26,
                "voltage": 12.1,
            },
            **{f"input_{number}": {"id": number, "state": False} for number in range(4)},
        ),
        {
            "rgbw:0": "light",
            "rgbw:0/meter": "electrical_meter",
            "rgbw:0/temperature": "temperature_sensor",
            **{f"input:{number}": "generic_switch" for number in range(4)},
        },
        {
            ("rgbw:0", "on_off"): True,
            ("rgbw:0", "level"): 40,
            ("rgbw:0", "color"): (240.0, 100.0),
            ("rgbw:0/meter", "power"): 3.1,
        },
    ),
    "Dimmer Gen3": Model(
        info("shellydimmerg3-84fce636a1b2", "S3DM-0A101WWL", "DimmerG3", gen=3),
        config(None, light_0={"id": 0, "name": "Dining table", "min_brightness_on_toggle": 3, "night_mode": {}}),
        status(
            light_0={
                "id": 0,
                "source": "switch",
                "output": False,
                "brightness": 73.0,
                "temperature": {"tC": 38.8, "tF": 101.8},
                "aenergy": {"total": 20.0, "by_minute": [0.0, 0.0, 0.0], "minute_ts": 1732197660},
                "apower": 0.0,
                "current": 0.0,
                "voltage": 229.9,
                "calibration": {"progress": 100},
                "flags": [],
            },
            input_0={"id": 0, "state": None},
            input_1={"id": 1, "state": None},
        ),
        {
            "light:0": "light",
            "light:0/meter": "electrical_meter",
            "light:0/temperature": "temperature_sensor",
            "input:0": "generic_switch",
            "input:1": "generic_switch",
        },
        {("light:0", "on_off"): False, ("light:0", "level"): 73, ("light:0/meter", "power"): 0},
    ),
    "Plus 2PM in the profile cover": Model(
        info("shellyplus2pm-5443b23d81f8", "SNSW-102P16EU", "Plus2PM", profile="cover"),
        config(
            "Bedroom blind",
            cover_0={"id": 0, "name": None, "motor": {"idle_power_thr": 2.0}, "slat": {"enable": False}},
        ),
        status(
            cover_0={
                "id": 0,
                "source": "limit_switch",
                "state": "stopped",
                "apower": 0.0,
                "voltage": 233.0,
                "current": 0.0,
                "pf": 0.0,
                "freq": 50.0,
                "aenergy": {"total": 42.0, "by_minute": [0.0, 0.0, 0.0], "minute_ts": 1732197660},
                "temperature": {"tC": 33.0, "tF": 91.4},
                "pos_control": True,
                "last_direction": "open",
                "current_pos": 65,
            },
            input_0={"id": 0, "state": False},
            input_1={"id": 1, "state": False},
        ),
        {
            "cover:0": "window_covering",
            "cover:0/meter": "electrical_meter",
            "cover:0/temperature": "temperature_sensor",
            "input:0": "generic_switch",
            "input:1": "generic_switch",
        },
        {("cover:0", "movement"): "stopped", ("cover:0", "position"): 65, ("cover:0/meter", "energy"): 0.042},
    ),
    "H&T Gen3": Model(
        info("shellyhtg3-84fce63ad204", "S3SN-0U12A", "HTG3", gen=3),
        config(
            "Cellar",
            temperature_0={"id": 0, "name": None, "report_thr_C": 0.5, "offset_C": 0.0},
            humidity_0={"id": 0, "name": None, "report_thr": 5.0, "offset": 0.0},
            ht_ui={"temperature_unit": "C"},
        ),
        status(
            sys={"wakeup_reason": {"boot": "deepsleep_wake", "cause": "periodic"}, "wakeup_period": 7200},
            devicepower_0={"id": 0, "battery": {"V": 5.94, "percent": 83}, "external": {"present": False}},
            temperature_0={"id": 0, "tC": 14.7, "tF": 58.4},
            humidity_0={"id": 0, "rh": 66.3},
        ),
        {"temperature:0": "temperature_sensor", "humidity:0": "humidity_sensor", "devicepower:0": "x_battery"},
        {
            ("temperature:0", "temperature"): 14.7,
            ("humidity:0", "humidity"): 66.3,
            ("devicepower:0", "battery"): 83,
            ("devicepower:0", "voltage"): 5.94,
            ("devicepower:0", "plugged_in"): False,
        },
    ),
    "Plus i4": Model(
        info("shellyplusi4-a8032ab8a5b0", "SNSN-0024X", "PlusI4"),
        config("Hall", **{f"input_{number}": {"id": number, "name": None, "type": "button"} for number in range(4)}),
        status(**{f"input_{number}": {"id": number, "state": None} for number in range(4)}),
        {f"input:{number}": "generic_switch" for number in range(4)},
        {},
    ),
    "BLU Gateway with a door sensor": Model(
        info("shellyblugw-7c87ce123456", "SNGW-BT01", "BluGw"),
        config("Gateway"),
        status(),
        {
            "boolean:200": "x_setting",
            "window": "contact_sensor",
            "illuminance": "light_sensor",
            "battery": "x_battery",
            "rssi": "x_sensor",
        },
        {
            ("window", "contact"): True,
            ("illuminance", "illuminance"): 120,
            ("battery", "battery"): 100,
            ("boolean:200", "state"): False,
        },
        [
            {
                "key": "bthomedevice:200",
                "status": {"id": 200, "rssi": -66, "battery": 100, "packet_id": 12, "last_updated_ts": 1732197700},
                "config": {"id": 200, "addr": "3c:2e:f5:71:d5:2a", "name": "Front door", "key": None, "meta": None},
                "attrs": {"flags": 0, "model_id": 2},
            },
            {
                "key": "bthomesensor:200",
                "status": {"id": 200, "value": True, "last_updated_ts": 1732197700},
                "config": {"id": 200, "addr": "3c:2e:f5:71:d5:2a", "name": "Front door", "obj_id": 45, "idx": 0},
            },
            {
                "key": "bthomesensor:201",
                "status": {"id": 201, "value": 120, "last_updated_ts": 1732197700},
                "config": {"id": 201, "addr": "3c:2e:f5:71:d5:2a", "name": None, "obj_id": 5, "idx": 0},
            },
            {
                "key": "boolean:200",
                "status": {"value": False, "source": "rpc", "last_update_ts": 1732197700},
                "config": {"id": 200, "name": "Holiday", "access": "crw", "default_value": False, "persisted": False},
            },
        ],
    ),
}
