"""Answers of WLED to ``/json/si`` as versions 0.13, 0.14 and 0.15 send them, shortened where no part needs it.

Source: WLED, JSON API (https://kno.wled.ge/interfaces/json-api).
"""

from __future__ import annotations

from typing import Any

__all__ = ["BEFORE_0_13", "RGBW_0_14", "RGB_0_15", "TWO_SEGMENTS_0_15", "WHITES_0_13"]


def segment(number: int, *, stop: int, col: list[list[int]], **more: Any) -> dict[str, Any]:
    return {
        "id": number,
        "start": 0,
        "stop": stop,
        "len": stop,
        "grp": 1,
        "spc": 0,
        "of": 0,
        "on": True,
        "frz": False,
        "bri": 255,
        "cct": 127,
        "col": col,
        "fx": 0,
        "sx": 128,
        "ix": 128,
        "pal": 0,
        "sel": True,
        "rev": False,
        "mi": False,
        **more,
    }


def document(
    version: str, leds: dict[str, Any], segments: list[dict[str, Any]], *, on: bool = True, bri: int = 128, **info: Any
) -> dict[str, Any]:
    return {
        "state": {
            "on": on,
            "bri": bri,
            "transition": 7,
            "ps": -1,
            "pl": -1,
            "nl": {"on": False, "dur": 60, "mode": 1, "tbri": 0, "rem": -1},
            "udpn": {"send": False, "recv": True},
            "lor": 0,
            "mainseg": 0,
            "seg": segments,
        },
        "info": {
            "ver": version,
            "vid": 2412100,
            "leds": {"count": 30, "pwr": 0, "fps": 0, "maxpwr": 0, "maxseg": 32, **leds},
            "str": False,
            "name": "Shelf",
            "udpport": 21324,
            "live": False,
            "liveseg": -1,
            "lm": "",
            "lip": "",
            "ws": 1,
            "fxcount": 187,
            "palcount": 71,
            "wifi": {"bssid": "C4:AD:34:00:00:01", "rssi": -57, "signal": 86, "channel": 1},
            "fs": {"u": 20, "t": 983, "pmt": 0},
            "ndc": 1,
            "arch": "esp32",
            "core": "v3.3.6",
            "freeheap": 190000,
            "uptime": 3600,
            "opt": 79,
            "brand": "WLED",
            "product": "FOSS",
            "mac": "e8db84aabbcc",
            "ip": "192.168.1.30",
            **info,
        },
    }


BLACK = [0, 0, 0]
RGB_0_15 = document(
    "0.15.0",
    {"seglc": [1], "lc": 1, "rgbw": False, "wv": 0, "cct": 0, "bootps": 0},
    [segment(0, stop=30, col=[[255, 160, 0], BLACK, BLACK], fx=9, n="", set=0, si=0, m12=0)],
    cn="Kōsen",
    release="ESP32",
)
RGBW_0_14 = document(
    "0.14.4",
    {"seglc": [3], "lc": 3, "rgbw": True, "wv": 2, "cct": 0},
    [segment(0, stop=60, col=[[0, 0, 0, 255], [*BLACK, 0], [*BLACK, 0]], bri=128)],
    bri=255,
)
TWO_SEGMENTS_0_15 = document(
    "0.15.0",
    {"seglc": [1, 7], "lc": 7, "rgbw": True, "wv": 2, "cct": 4},
    [
        segment(0, stop=10, col=[[0, 0, 255, 0], [*BLACK, 0], [*BLACK, 0]], n="Desk", on=False),
        segment(3, stop=30, col=[[255, 255, 255, 0], [*BLACK, 0], [*BLACK, 0]], bri=51, cct=25),
    ],
)
WHITES_0_13 = document(
    "0.13.3",
    {"seglc": [4], "lc": 4, "rgbw": False, "wv": False, "cct": True},
    [segment(0, stop=1, col=[[255, 255, 255], BLACK, BLACK], cct=0)],
    on=False,
)
BEFORE_0_13 = document("0.12.0", {"rgbw": True, "wv": True}, [segment(0, stop=9, col=[[1, 2, 3, 4], [0] * 4, [0] * 4])])
del BEFORE_0_13["state"]["seg"][0]["cct"]
