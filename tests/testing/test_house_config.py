"""What a test says, and what suits a test for the rest."""

from __future__ import annotations

import pytest

from homebot.config import parse_config
from homebot.testing.house import house_config, mqtt_gateway_of

OURS = "mqtt://127.0.0.1:4711"


def test_nothing_said_is_one_gateway_that_acts_and_a_free_port() -> None:
    made = house_config(["light_service"], "villa", OURS)
    assert made.gateways == {"mqtt": {"root": "villa", "act": True, "url": OURS}}
    assert made.apps == {"app_1": {"class": "light_service"}}
    assert made.door == {"port": 0}


@pytest.mark.parametrize("url", ["mqtts://broker.example:8883", "mqtt://192.168.1.2", "embedded"])
def test_a_real_house_is_never_touched(url: str) -> None:
    """Nor are the secrets for it read."""
    at_home = {"url": url, "root": "home", "user": "robot", "password_file": "/no/such/file", "stale_after": 60.0}
    given = parse_config({"gateways": {"field": {"class": "mqtt", **at_home}}, "door": {"port": 7}}, "homebot.toml")
    made = house_config([], "villa", OURS, given)
    assert made.gateways == {"field": {"class": "mqtt", "url": OURS, "root": "home", "act": True, "stale_after": 60.0}}
    assert made.door == {"port": 7}
    settings = mqtt_gateway_of(made)
    assert settings is not None
    assert settings.options().url == OURS


def test_a_broker_on_this_computer_is_taken_as_it_is_said() -> None:
    table = {"url": "mqtt://localhost:1999", "user": "u", "act": False, "root": ""}
    made = house_config([], "villa", OURS, parse_config({"gateways": {"mqtt": table}}, "tables"))
    assert made.gateways == {"mqtt": table}


def test_other_gateways_are_left_alone() -> None:
    fake = {"class": "homebot.testing:FakeGateway"}
    unknown = {"class": "no_such"}
    made = house_config([], "villa", OURS, parse_config({"gateways": {"fake": fake, "other": unknown}}, "tables"))
    assert made.gateways == {"fake": fake, "other": unknown}
    assert mqtt_gateway_of(made) is None


def test_an_app_that_the_configuration_has_runs_once_with_its_settings() -> None:
    tables = {"apps": {"lights_out": {"quiet_after": 60}, "mine": {"class": "my_app:MyApp"}}}
    made = house_config(["lights_out", "my_app:MyApp", "light_service"], "villa", OURS, tables)
    assert made.apps == tables["apps"] | {"app_3": {"class": "light_service"}}
