"""The table of an MQTT gateway: what it accepts, and where the password comes from."""

from pathlib import Path

import pytest

from homebot.config import parse_settings
from homebot.conventions.installed_conventions import find_conventions
from homebot.errors import ConfigError, UsageError
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.mqtt.clients import HostedBroker

HOME_ASSISTANT = pytest.mark.rooms("homeassistant")


def settings(**table: object) -> MqttGatewaySettings:
    return parse_settings(MqttGatewaySettings, table, "homebot.toml", "gateways.mqtt")


def test_an_empty_table_means_the_embedded_broker_and_inboxes() -> None:
    """The defaults of the issue."""
    empty = settings()
    assert (empty.url, empty.delivery, empty.act, empty.max_payload) == ("embedded", "inbox", None, 256 * 1024)


@pytest.mark.parametrize(
    ("table", "client"),
    [
        ({}, "native"),
        ({"client": "aiomqtt"}, "aiomqtt"),
        ({"url": "mqtt://broker"}, None),
        ({"url": "mqtt://broker", "client": "native"}, "native"),
    ],
)
def test_on_the_own_broker_the_own_client_is_the_default(table: dict[str, object], client: str | None) -> None:
    resolved = MqttGateway.resolve(settings(**table), GatewayContext.of(HostedBroker("mqtt://127.0.0.1:1883")))
    assert isinstance(resolved, MqttGatewaySettings)
    assert resolved.client == client


@pytest.mark.parametrize(
    ("table", "key", "reason"),
    [
        ({"url": "http://broker"}, "url", "must start with mqtt:// or mqtts://"),
        ({"url": 5}, "url", "must be a text in quotes"),
        ({"url": "embedded:0"}, "url", "no whole number from 1 to 65535"),
        ({"root": "home/+"}, "root", "wildcard"),
        ({"root": "home/"}, "root", "empty level"),
        ({"delivery": "post"}, "delivery", "'inbox' or 'mirror'"),
        ({"act": "yes"}, "act", "must be true or false, without quotes"),
        ({"client": "paho"}, "client", "'aiomqtt' or 'native'"),
        ({"rooot": "home"}, "rooot", "unknown key; did you mean root?"),
        ({"max_payload": 3}, "max_payload", "greater than or equal to 1024"),
        ({"stale_after": -1}, "stale_after", "greater than 0"),
        *(
            pytest.param(table, key, reason, marks=HOME_ASSISTANT)
            for table, key, reason in (
                ({"homeassistant": {"prefixes": [1]}}, "homeassistant.prefixes.0", "valid string"),
                ({"homeassistant": {"prefxes": []}}, "homeassistant.prefxes", "unknown key; did you mean prefixes?"),
                ({"homeassistant": 3}, "homeassistant", "should be an object"),
                (
                    {"conventions": ["thesis"], "homeassistant": {}},
                    "homeassistant",
                    "`conventions` does not name: thesis",
                ),
                ({"share": "attic"}, "share", 'would reach one of the group alone; add conventions = \\["thesis"\\]'),
            )
        ),
        ({"share": "attic", "conventions": ["thesis"], "act": True}, "share", "needs act = false"),
        ({"share": "attic", "conventions": ["thesis"], "protocol": "3.1.1"}, "share", "needs MQTT 5"),
        ({"share": "attic/+", "conventions": ["thesis"]}, "share", "one level of a topic filter"),
    ],
)
def test_a_wrong_value_is_refused_with_file_key_and_reason(table: dict[str, object], key: str, reason: str) -> None:
    """Everything that a person needs to mend it."""
    with pytest.raises(ConfigError, match=reason) as caught:
        settings(**table)
    assert str(caught.value).startswith(f"homebot.toml: gateways.mqtt.{key}: ")


@HOME_ASSISTANT
def test_a_convention_has_a_table_of_its_own() -> None:
    given = settings(conventions=["thesis", "homeassistant"], homeassistant={"prefixes": ["ha"]})
    thesis, discovery = find_conventions(given.conventions, given.tables, "home425")
    assert thesis.filters()[0].startswith("home425/")
    assert discovery.filters()[0].startswith("ha/")


def test_the_home_of_the_layout_is_that_of_the_gateway_unless_its_table_names_another() -> None:
    given = settings(conventions=["thesis"], thesis={"root": "villa"})
    (thesis,) = find_conventions(given.conventions, given.tables, "home425")
    assert thesis.filters()[0] == "villa/+/+/out"


@HOME_ASSISTANT
def test_announcements_may_be_larger_than_other_messages() -> None:
    url = "mqtt://broker"
    assert settings(url=url, conventions=["thesis"]).options().maximum_packet_size == 256 * 1024
    assert settings(url=url, conventions=["homeassistant"]).options().maximum_packet_size == 32 * 1024 * 1024


def test_the_password_comes_from_the_first_line_of_its_file(tmp_path: Path) -> None:
    """A final line break is no part of it, and it shows nowhere."""
    file = tmp_path / "password"
    file.touch(mode=0o600)
    file.write_text("s3cret\n")
    options = settings(url="mqtt://broker", user="robot", password_file=str(file)).options()

    assert options.password is not None
    assert options.password.get_secret_value() == "s3cret"
    assert "s3cret" not in repr(options)


def test_a_password_that_cannot_be_read_is_a_clear_error(tmp_path: Path) -> None:
    """It names the file, or the variable."""
    with pytest.raises(UsageError, match="missing"):
        settings(url="mqtt://broker", user="a", password_file=str(tmp_path / "missing")).options()
    with pytest.raises(UsageError, match="HOMEBOT_NOT_SET"):
        settings(url="mqtt://broker", user="a", password_env="HOMEBOT_NOT_SET").options()


def test_an_address_with_a_password_never_shows_it_in_an_error() -> None:
    """Not even when the address is wrong."""
    with pytest.raises(ConfigError) as caught:
        settings(url="mqtt://robot:s3cret@broker:port")
    assert "s3cret" not in str(caught.value)
    assert caught.value.__cause__ is None


def test_a_name_for_this_run_replaces_a_default_name() -> None:
    """And its session still ends with the run."""
    given = MqttGatewaySettings(url="mqtt://h").with_client_id("mine").options()
    chosen = MqttGatewaySettings(url="mqtt://h", client_id="chosen").with_client_id("mine").options()
    assert (given.client_id, given.session_ends_on_close) == ("mine", True)
    assert (chosen.client_id, chosen.session_ends_on_close) == ("chosen", False)
