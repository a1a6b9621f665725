"""The configuration file: what is refused, and how the error reads."""

import tomllib
from pathlib import Path

import pytest
from pydantic import AliasChoices, BaseModel, ConfigDict, Field
from tests.guide import blocks_in, guide

from homebot.config import load_config, parse_settings
from homebot.errors import ConfigError
from homebot.gateways.mqtt.settings import MqttGatewaySettings


@pytest.fixture
def write(tmp_path: Path) -> Path:
    return tmp_path / "homebot.toml"


def test_a_full_file_is_read_into_its_tables(write: Path) -> None:
    """The tables of plug-ins are handed on as they are."""
    write.write_text(
        '[home]\nname = "villa"\n[gateways.mqtt]\nurl = "mqtt://b"\n[apps.light_service]\n[door]\nport = 1\n'
    )
    config = load_config(write)

    assert config.home.name == "villa"
    assert config.gateways == {"mqtt": {"url": "mqtt://b"}}
    assert config.apps == {"light_service": {}}
    assert config.door == {"port": 1}


def test_the_table_for_mqtt_that_the_guide_shows_is_valid() -> None:
    tables = [tomllib.loads(block) for block in blocks_in(guide("configuration"), "toml")]
    (mqtt,) = [table["gateways"]["mqtt"] for table in tables if "mqtt" in table.get("gateways", {})]
    assert MqttGatewaySettings.model_validate(mqtt).act


def test_an_empty_file_is_a_home_with_nothing_in_it(write: Path) -> None:
    """Defaults everywhere."""
    write.write_text("")
    assert load_config(write).gateways == {}


@pytest.mark.parametrize(
    ("text", "key", "reason"),
    [
        ("[hoome]", "hoome", "unknown key; did you mean home?"),
        ('[home]\nnmae = "x"', "home.nmae", "unknown key; did you mean name"),
        ("[home]\nname = 5", "home.name", "must be a text in quotes, got 5"),
        ('[home]\nname = ""', "home.name", "at least 1 character"),
        ('[home]\nzone = "Europe/Berln"', "home.zone", "no time zone 'Europe/Berln'; did you mean Europe/Berlin"),
        ('[home]\nzone = "berlin"', "home.zone", "no time zone 'berlin'; did you mean Europe/Berlin"),
        ('[home]\nzone = "Europe"', "home.zone", "no time zone 'Europe'; did you mean"),
        ('[home]\nzone = "../etc/passwd"', "home.zone", "no time zone '../etc/passwd'"),
        ("[home]\nlatitude = 95.0\nlongitude = 13", "home.latitude", "less than or equal to 90, got 95"),
        ("[home]\nlatitude = 52.5\nlongitude = -181", "home.longitude", "greater than or equal to -180, got -181"),
        ("[home]\nlatitude = 52.5", "home", "give latitude and longitude, or neither"),
        ("gateways = 3", "gateways", "must be a table, as in [gateways], got 3"),
        ('source = "x"', "source", "unknown key"),
        ('[gateways."front door"]', "gateways.front door", "has a character that is not allowed in names"),
        ("[apps.2nd]", "apps.2nd", "starts with a digit"),
    ],
)
def test_a_mistake_is_told_with_file_key_and_reason(write: Path, text: str, key: str, reason: str) -> None:
    """In that order, in one line."""
    write.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_config(write)
    message = str(caught.value)
    assert message.startswith(f"{write}: {key}: ")
    assert reason in message
    assert "\n" not in message


def test_what_is_no_toml_is_told_with_its_line(write: Path) -> None:
    """The parser knows where."""
    write.write_text("[home\n")
    with pytest.raises(ConfigError, match=r"is invalid TOML.*line 1"):
        load_config(write)


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    """Missing, and not text."""
    with pytest.raises(ConfigError, match="does not exist"):
        load_config(tmp_path / "missing.toml")
    (tmp_path / "binary").write_bytes(b"\xff\xfe")
    with pytest.raises(ConfigError, match="not UTF-8"):
        load_config(tmp_path / "binary")


@pytest.mark.parametrize(
    "text", ["home = " + "[" * 100_000, "[home" + ".x" * 5000 + "]", "home = " + "[" * 70 + "]" * 70]
)
def test_a_file_that_is_nested_too_deep_is_told_so(tmp_path: Path, text: str) -> None:
    """Whoever notices first."""
    file = tmp_path / "homebot.toml"
    file.write_text(text)
    with pytest.raises(ConfigError, match="nested too deep"):
        load_config(file)


def test_a_model_that_says_nothing_of_further_keys_has_none() -> None:
    """An author's own settings ignored a misspelt key, as pydantic's models do."""

    class Own(BaseModel):
        quiet: str = "5m"

    class Open(Own):
        model_config = ConfigDict(extra="ignore")

    class Renamed(Own):
        quiet: str = Field("5m", validation_alias=AliasChoices("quiet", "silent"))

    with pytest.raises(ConfigError, match=r"here: apps\.hall\.quiett: unknown key; did you mean quiet\?"):
        parse_settings(Own, {"class": "hall:Hall", "quiett": "3m"}, "here", "apps.hall")
    assert parse_settings(Own, {"class": "hall:Hall", "quiet": "3m"}, "here", "apps.hall").quiet == "3m"
    assert parse_settings(Open, {"quiett": "3m"}, "here", "apps.hall").quiet == "5m"
    assert parse_settings(Renamed, {"silent": "3m"}, "here", "apps.hall") == Renamed(silent="3m")
