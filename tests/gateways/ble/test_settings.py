"""The table of a Bluetooth gateway."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from homebot.config import parse_config
from homebot.errors import ConfigError, UsageError
from homebot.gateways.ble import BleGateway, BleGatewaySettings
from homebot.runtime.plan import make_plan, plan_errors

ADDRESS = "A4:C1:38:0A:0B:0C"
KEY = "231d39c1d7cc1ab1aee224cd096db932"


def settings(**given: object) -> BleGatewaySettings:
    return BleGatewaySettings.model_validate(given)


@pytest.mark.rooms("bthome", "sensor_libraries", "switchbot")
def test_homebots_own_parsers_are_used_unless_others_are_named() -> None:
    assert settings().parsers == ("beacon", "bthome", "sensor_libraries", "switchbot")


def test_a_bind_key_is_read_from_a_private_file(tmp_path: Path) -> None:
    file = tmp_path / "attic.key"
    file.write_text(f"{KEY}\n")
    file.chmod(0o600)
    found = settings(devices={ADDRESS.lower(): {"bind_key_file": str(file)}})
    assert found.bind_keys() == {ADDRESS: bytes.fromhex(KEY)}
    BleGateway.check(found)


def test_a_file_that_others_can_change_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "attic.key"
    file.write_text(KEY)
    file.chmod(0o666)
    with pytest.raises(UsageError, match=f'devices."{ADDRESS}".bind_key_file'):
        BleGateway.check(settings(devices={ADDRESS: {"bind_key_file": str(file)}}))


@pytest.mark.parametrize("text", ["secret-that-is-no-key", KEY + "00", ""])
def test_an_invalid_key_is_refused_and_not_shown(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ATTIC_KEY", text)
    with pytest.raises(UsageError, match="32 hexadecimal digits") as caught:
        settings(devices={ADDRESS: {"bind_key_env": "ATTIC_KEY"}}).bind_keys()
    assert not text or text not in str(caught.value)


def test_a_variable_that_is_not_set_is_named() -> None:
    with pytest.raises(UsageError, match="HOMEBOT_NO_SUCH_KEY is not set"):
        BleGateway.check(settings(devices={ADDRESS: {"bind_key_env": "HOMEBOT_NO_SUCH_KEY"}}))


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"devices": {"attic": {}}}, "is not an address"),
        ({"devices": {ADDRESS: {"profile": "disco"}}}, "'disco' is unknown; known are none"),
        ({"devices": {ADDRESS: {"bind_key": KEY}}}, "Extra inputs"),
        ({"devices": {ADDRESS: {"bind_key_env": "A", "bind_key_file": "b"}}}, "not both"),
        ({"profiles": {"lamp": {"service": "xyz", "command": "ffd9", "on": "01", "off": "00"}}}, "is not a UUID"),
        ({"profiles": {"lamp": {"service": "ffd5", "command": "ffd9", "on": "0", "off": "00"}}}, "neither two"),
        ({"profiles": {"lamp": {"service": "ffd5", "command": "ffd9", "on": "{x}", "off": "00"}}}, "is not a field"),
        ({"profiles": {"lamp": {"service": "ffd5", "command": "ffd9", "on": "..", "off": "00"}}}, "every byte"),
        ({"profiles": {"lamp": {"service": "ffd5", "command": "1", "on": "01", "off": "00"}}}, "is not a UUID"),
        (
            {"profiles": {"lamp": {"service": "ffd5", "command": "ffd9", "on": "01", "off": "00", "state": "ffd4"}}},
            "state needs report",
        ),
        ({"scan": "loud"}, "'active' or 'passive'"),
        ({"max_connections": 0}, "greater than or equal to 1"),
    ],
)
def test_a_mistake_is_named(given: dict[str, object], named: str) -> None:
    with pytest.raises(ValidationError, match=named):
        settings(**given)


def test_a_second_gateway_with_proxies_is_refused_because_the_library_has_one_place_for_them() -> None:
    second = {"class": "ble", "proxies": True}
    tables = {"gateways": {"ble": {"proxies": True}, "attic": second}}
    problem = "gateways.attic: only one gateway can have Bluetooth proxies, and gateways.ble has them"
    config = parse_config(tables, "test")
    with pytest.raises(ConfigError, match=problem):
        make_plan(config)
    assert [str(error) for error in plan_errors(config)] == [f"test: {problem}"]
    del second["proxies"]
    assert len(make_plan(parse_config(tables, "test")).gateways) == 2
