"""A house in a test: what it says and hears, a clear word when nothing comes, and what suits it for the rest."""

import re
from ast import literal_eval

import pytest
from tests.patience import until

from homebot.config import parse_config
from homebot.errors import UsageError
from homebot.testing import TestHouse, house_of
from homebot.testing.house import house_config, mqtt_gateway_of


async def test_an_app_in_a_house_hears_devices_and_is_heard() -> None:
    async with house_of("light_service", root="villa") as house:
        await house.says("villa/lights/a/out", "on")
        await house.says("villa/lights/b/out", "on")
        assert await house.hears("villa/lights/b/in") == "off"
        assert await house.hears("villa/lights/a/in") == "off"


async def test_what_does_not_come_is_told_with_what_came_instead() -> None:
    async with house_of("light_service") as house:
        await house.says("home425/lights/a/out", "on")
        await until(lambda: house._received.get("home425/lights/a/in"))
        with pytest.raises(TimeoutError) as caught:
            await house.hears("home425/lights/b/in", within="300ms")
    told = r"nothing came on home425/lights/b/in within 0\.3 s; received elsewhere: (\{.*\}); crashed: nothing"
    assert (found := re.fullmatch(told, str(caught.value)))
    assert literal_eval(found[1])["home425/lights/a/in"] == ["off"]  # and perhaps what the gateway says when it begins


def test_pytest_does_not_take_the_house_for_a_test() -> None:
    assert not TestHouse.__test__


async def test_a_test_hears_wherever_it_listens_and_not_itself() -> None:
    """Also what was said before it listens, and outside of the home; it used to say that nothing came."""
    async with house_of(root="villa") as house, house.client("somebody") as somebody:
        await somebody.wait_connected()
        await house.says("attic/lamp/orders", "mine")
        await somebody.publish("attic/lamp/orders", b"OFF", qos=1)
        assert await house.hears("attic/lamp/orders") == "OFF"
        with pytest.raises(TimeoutError, match="nothing came on attic/lamp/orders within"):
            await house.hears("attic/lamp/orders", within=0.01)


async def test_a_test_listens_on_one_topic() -> None:
    async with house_of() as house:
        with pytest.raises(UsageError, match="give a topic without wildcards"):
            await house.hears("attic/#")


OURS = "mqtt://127.0.0.1:4711"


def test_nothing_said_is_one_gateway_that_acts_and_a_free_port() -> None:
    made = house_config(["light_service"], "villa", OURS)
    assert made.gateways == {"mqtt": {"root": "villa", "act": True, "url": OURS}}
    assert made.apps == {"light_service": {}}
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
    assert made.apps == tables["apps"] | {"light_service": {}}
