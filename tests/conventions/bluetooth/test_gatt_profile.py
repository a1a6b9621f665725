"""Declared profiles of devices that are connected to."""

import pytest
from tests.simulated.ble_family import LIGHT_PROFILE

from homebot.conventions.bluetooth.gatt_profile import GattProfile
from homebot.errors import RefusedError, WireError

LIGHT = GattProfile.model_validate(LIGHT_PROFILE)
STRIP = GattProfile.model_validate(
    {
        "service": "ffd5",
        "command": "ffd9",
        "on": "cc2333",
        "off": "cc2433",
        "color": "56{red}{green}{blue}00f0aa",
        "report": "66..{on}{red}{green}{blue}99",
    }
)


def test_a_light_has_the_capabilities_of_its_frames() -> None:
    assert [(one.name, one.readable, one.settable) for one in LIGHT.part().capabilities] == [
        ("on_off", True, True),
        ("level", True, True),
    ]
    assert [one.name for one in STRIP.part().capabilities] == ["on_off", "color"]


def test_short_uuids_are_written_out() -> None:
    assert STRIP.command == STRIP.reported_by == "0000ffd9-0000-1000-8000-00805f9b34fb"


def test_commands_fill_the_fields_of_their_frame() -> None:
    state = LIGHT.unknown_state()
    assert LIGHT.write("level", 50.0, state).hex() == "0180"
    assert LIGHT.write("on_off", False, state).hex() == "0080"
    assert LIGHT.write("on_off", True, state).hex() == "0180"
    assert LIGHT.write("level", 0.1, state).hex() == "0101"
    assert LIGHT.write("level", 0.0, state).hex() == "0001"
    assert STRIP.write("on_off", True, state).hex() == "cc2333"
    assert STRIP.write("color", (120.0, 100.0), state).hex() == "5600ff0000f0aa"


def test_a_colour_whose_frame_does_not_turn_the_device_on_is_followed_by_one_that_does() -> None:
    state = LIGHT.unknown_state()
    assert [one.hex() for one in STRIP.write_frames("color", (120.0, 100.0), state)] == ["5600ff0000f0aa", "cc2333"]
    assert [one.hex() for one in LIGHT.write_frames("level", 50.0, state)] == ["0180"]
    assert [one.hex() for one in LIGHT.write_frames("level", 0.0, state)] == ["0080"]


def test_reports_are_read_by_their_frame() -> None:
    state = LIGHT.unknown_state()
    assert LIGHT.read(b"\x01\x80", state) == {"on_off": True, "level": 50.2}
    assert LIGHT.read(b"\x00\x80", state) == {"on_off": False, "level": 0.0}
    assert state["level"] == 0x80
    assert STRIP.read(bytes.fromhex("6604010000ff99"), state) == {"on_off": True, "color": (240.0, 100.0)}


@pytest.mark.parametrize("data", ["", "66", "6704010000ff99", "6604010000ff98"])
def test_a_report_of_another_form_is_refused(data: str) -> None:
    with pytest.raises(WireError):
        STRIP.read(bytes.fromhex(data), LIGHT.unknown_state())


def test_a_command_without_a_frame_is_refused() -> None:
    with pytest.raises(RefusedError, match="no frame"):
        STRIP.write("level", 50.0, LIGHT.unknown_state())
