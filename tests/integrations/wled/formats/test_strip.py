import copy
from typing import Any

import pytest
from tests.integrations.wled.formats.wled_documents import (
    BEFORE_0_13,
    RGB_0_15,
    RGBW_0_14,
    TWO_SEGMENTS_0_15,
    WHITES_0_13,
)

from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.announced.gateway_device import can_report
from homebot.integrations.wled.formats.strip import WledStrip, effect_names

EFFECTS = effect_names(["Solid", "Blink", "RSVD", "-", "Solid", "Rainbow@!,Size;!", "", 7, "x", "Wipe"])
DOCUMENTS = {
    "RGB, 0.15": RGB_0_15,
    "RGBW, 0.14": RGBW_0_14,
    "two segments, 0.15": TWO_SEGMENTS_0_15,
    "whites, 0.13": WHITES_0_13,
    "before 0.13": BEFORE_0_13,
}
LAMPS = {
    "RGB, 0.15": {"": {"on_off", "level", "color", "effect"}},
    "RGBW, 0.14": {"": {"on_off", "level", "color", "effect"}},
    "two segments, 0.15": {
        "": {"on_off", "level"},
        "segment:0": {"on_off", "level", "color", "effect"},
        "segment:3": {"on_off", "level", "color", "color_temperature", "effect"},
    },
    "whites, 0.13": {"": {"on_off", "level", "color_temperature", "effect"}},
    "before 0.13": {"": {"on_off", "level", "color", "effect"}},
}


def strip(document: dict[str, Any]) -> WledStrip:
    return WledStrip(document, EFFECTS)


def values(document: dict[str, Any]) -> dict[tuple[str, str], PlainValue]:
    return {(part, name): value for part, found in strip(document).readings() for name, value in found.items()}


def part_of(document: dict[str, Any], part_id: str) -> Part:
    (found,) = (one for one in strip(document).parts() if one.id == part_id)
    return found


def test_effects_that_cannot_be_chosen_have_no_name() -> None:
    assert EFFECTS == ("Solid", "Blink", "", "", "", "Rainbow", "", "", "x", "Wipe")
    assert effect_names({"error": 3}) == ()


@pytest.mark.parametrize("name", DOCUMENTS)
def test_lamps_have_the_light_capabilities_of_their_segments(name: str) -> None:
    lamps = [one for one in strip(DOCUMENTS[name]).parts() if one.service_type == "light"]
    assert {one.id: {able.name for able in one.capabilities} for one in lamps} == LAMPS[name]


@pytest.mark.parametrize("name", DOCUMENTS)
def test_settings_and_diagnostics_are_parts_of_their_own(name: str) -> None:
    others = {one.id: one.category for one in strip(DOCUMENTS[name]).parts() if one.service_type != "light"}
    assert others == {
        "sync_send": "config",
        "sync_receive": "config",
        "nightlight": "config",
        "live": "diagnostic",
        "signal": "diagnostic",
    }


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_reading_is_of_a_part_that_can_report_it(name: str) -> None:
    for (part, capability), value in values(DOCUMENTS[name]).items():
        assert can_report(part_of(DOCUMENTS[name], part), capability, value)


def test_the_facts_of_a_device() -> None:
    described = strip(RGB_0_15)
    assert described.name == "Shelf"
    assert described.metadata == {
        "manufacturer": "WLED",
        "model": "FOSS",
        "sw_version": "0.15.0",
        "architecture": "esp32",
    }
    assert "e8db84aabbcc" in described.identifiers[0].replace(":", "").lower()
    assert part_of(TWO_SEGMENTS_0_15, "segment:0").name == "Desk"


OFF_0_15 = {**TWO_SEGMENTS_0_15, "state": {**TWO_SEGMENTS_0_15["state"], "on": False}}


@pytest.mark.parametrize(
    ("document", "part", "capability", "value"),
    [
        (RGB_0_15, "", "on_off", True),
        (RGB_0_15, "", "level", pytest.approx(50, abs=0.5)),
        (RGB_0_15, "", "color", pytest.approx((37.647, 100))),
        (RGB_0_15, "", "effect", "Wipe"),
        (RGBW_0_14, "", "level", pytest.approx(50, abs=0.5)),  # of the master and of the segment together
        (RGBW_0_14, "", "color", (0, 0)),  # a white channel alone has none
        (TWO_SEGMENTS_0_15, "", "on_off", True),
        (TWO_SEGMENTS_0_15, "segment:0", "on_off", False),
        (TWO_SEGMENTS_0_15, "segment:3", "on_off", True),
        (TWO_SEGMENTS_0_15, "segment:3", "level", 20),
        (OFF_0_15, "segment:3", "on_off", False),
        (WHITES_0_13, "", "color_temperature", 1900),
        (TWO_SEGMENTS_0_15, "segment:3", "color_temperature", 2700),
    ],
)
def test_a_state_is_read(document: dict[str, Any], part: str, capability: str, value: object) -> None:
    assert values(document)[part, capability] == value


def test_capabilities_of_inactive_segments_are_listed_before_0_14() -> None:
    """There the list has a place for each segment up to the last."""
    older = copy.deepcopy(TWO_SEGMENTS_0_15)
    older["info"]["leds"]["seglc"] = [1, 0, 0, 7]
    assert strip(older).parts() == strip(TWO_SEGMENTS_0_15).parts()


def test_the_declared_abilities_of_a_segment_count() -> None:
    """From WLED 16 on."""
    newer = copy.deepcopy(RGB_0_15)
    for segment in newer["state"]["seg"]:
        segment["lc"] = 4
    (part, *_) = WledStrip(newer, ()).parts()
    assert [one.name for one in part.capabilities] == ["on_off", "level", "color_temperature"]


@pytest.mark.parametrize(
    ("document", "part", "capability", "value", "state"),
    [
        (RGB_0_15, "", "on_off", True, {"on": True, "seg": [{"id": 0, "on": True}]}),
        (RGB_0_15, "", "on_off", False, {"on": False}),
        (RGB_0_15, "", "level", 100.0, {"on": True, "bri": 255, "seg": [{"id": 0, "on": True, "bri": 255}]}),
        (RGB_0_15, "", "level", 0.1, {"on": True, "bri": 1, "seg": [{"id": 0, "on": True, "bri": 255}]}),
        (RGB_0_15, "", "level", 0.0, {"on": False}),
        (RGB_0_15, "", "color", (120.0, 100.0), {"on": True, "seg": [{"id": 0, "on": True, "col": [[0, 255, 0]]}]}),
        (RGBW_0_14, "", "color", (0.0, 100.0), {"on": True, "seg": [{"id": 0, "on": True, "col": [[255, 0, 0, 0]]}]}),
        (RGB_0_15, "", "effect", "Rainbow", {"on": True, "seg": [{"id": 0, "on": True, "fx": 5}]}),
        (WHITES_0_13, "", "color_temperature", 2700.0, {"on": True, "seg": [{"id": 0, "on": True, "cct": 25}]}),
        (
            TWO_SEGMENTS_0_15,
            "segment:3",
            "color_temperature",
            10060.0,
            {"on": True, "seg": [{"id": 3, "on": True, "cct": 255, "col": [[0, 0, 0, 255]]}]},
        ),
        (TWO_SEGMENTS_0_15, "segment:0", "on_off", False, {"seg": [{"id": 0, "on": False}]}),
        (TWO_SEGMENTS_0_15, "segment:3", "level", 0.0, {"seg": [{"id": 3, "on": False}]}),
        (TWO_SEGMENTS_0_15, "segment:3", "level", 50.0, {"on": True, "seg": [{"id": 3, "on": True, "bri": 128}]}),
        (TWO_SEGMENTS_0_15, "", "level", 50.0, {"on": True, "bri": 128}),
        (TWO_SEGMENTS_0_15, "", "on_off", False, {"on": False}),
        (RGB_0_15, "nightlight", "on_off", True, {"nl": {"on": True}}),
        (RGB_0_15, "sync_receive", "on_off", False, {"udpn": {"recv": False}}),
    ],
)
def test_a_command_is_a_state(
    document: dict[str, Any], part: str, capability: str, value: PlainValue, state: dict[str, Any]
) -> None:
    assert strip(document).write(part, {capability: value}, 0.0) == state


@pytest.mark.parametrize(("seconds", "tenths"), [(0.5, 5), (65.0, 650), (1000.0, 655)])
def test_a_transition_is_for_the_one_command(seconds: float, tenths: int) -> None:
    assert strip(RGB_0_15).write("", {"on_off": True}, seconds)["tt"] == tenths


@pytest.mark.parametrize(
    ("part", "capability", "value"),
    [
        ("", "color", (1.0, 2.0)),
        ("segment:0", "color_temperature", 3000.0),
        ("segment:3", "color_temperature", 1899.0),
        ("segment:1", "on_off", True),
        ("segment:0", "effect", "RSVD"),
        ("segment:0", "effect", ""),
        ("live", "state", True),
        ("nightlight", "on_off", 1.0),
    ],
)
def test_an_impossible_command_of_a_part_is_refused(part: str, capability: str, value: PlainValue) -> None:
    with pytest.raises(RefusedError):
        strip(TWO_SEGMENTS_0_15).write(part, {capability: value}, 0.0)


@pytest.mark.parametrize("document", [{}, {"state": {}}, {"state": [], "info": {}}, {"state": {}, "info": None}])
def test_an_invalid_document_is_refused(document: dict[str, Any]) -> None:
    with pytest.raises(WireError, match="no state or no info"):
        strip(document)
