"""The configuration of a homebot in a test: what the test says, and for the rest what suits a test."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from homebot.bridges.rosbridge.admission import is_loopback
from homebot.config import Config, Table, parse_settings
from homebot.errors import PluginError
from homebot.gateways.mqtt import MqttGateway
from homebot.gateways.mqtt.settings import EMBEDDED, MqttGatewaySettings
from homebot.mqtt.options import MqttOptions
from homebot.plugins import load_plugin

__all__ = ["house_config", "mqtt_gateway_of"]

GATEWAYS = "homebot.gateways"

LOGIN: Final = frozenset({"user", "password_file", "password_env", "ca_file", "cert_file", "key_file", "client_id"})
"""What a gateway's table says about a broker that the test's own one replaces."""


def house_config(apps: Sequence[str], root: str, url: str, given: Config | None = None) -> Config:
    """Return *given* with *apps* and made for a test.

    A gateway for MQTT without a broker on this computer gets the one at *url* and acts: a test never touches a real
    house. Its root is *root* unless it has one; where there is no gateway, it is the only one. The door's port is any
    free one unless it has one.

    Args:
        apps: Each a plug-in's name or ``module:Class``; they come last.
        root: The home: first level of the topics.
        url: The test's broker.
        given: What the test says.

    Raises:
        UsageError: The address of a broker cannot be read.
    """
    given = given or Config(source="test")
    gateways = given.gateways or {"mqtt": {}}
    return given.model_copy(
        update={
            "gateways": {name: _on_test_broker(name, table, root, url) for name, table in gateways.items()},
            "apps": given.apps | {f"app_{number}": {"class": app} for number, app in enumerate(apps, 1)},
            "door": {"port": 0} | given.door,
        }
    )


def mqtt_gateway_of(config: Config) -> MqttGatewaySettings | None:
    """Return the settings of the first gateway for MQTT in *config*.

    Raises:
        ConfigError: Its table is wrong.
    """
    for name, table in config.gateways.items():
        if _is_for_mqtt(name, table):
            return parse_settings(MqttGatewaySettings, table, config.source, f"gateways.{name}", config.folder)
    return None


def _on_test_broker(name: str, table: Table, root: str, url: str) -> Table:
    if not _is_for_mqtt(name, table):
        return table
    table = {"root": root} | table
    if _is_here(table.get("url", EMBEDDED)):
        return table
    kept = {key: value for key, value in table.items() if key not in LOGIN}
    return {"act": True} | kept | {"url": url}


def _is_here(url: object) -> bool:
    """Return whether *url* is a broker that a test may talk to; what is no text is refused later, by its key."""
    return not isinstance(url, str) or (url != EMBEDDED and is_loopback(MqttOptions.from_url(url).host))


def _is_for_mqtt(name: str, table: Table) -> bool:
    try:
        kind = load_plugin(GATEWAYS, str(table.get("class", name)))
    except PluginError:  # the runtime says so, with its key
        return False
    return issubclass(kind, MqttGateway)
