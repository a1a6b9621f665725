"""The families of devices that there are in houses, as they speak over MQTT, by their names there. Pure."""

from collections.abc import Mapping
from typing import Final

from homebot.house.dialect import Dialect, ThesisDialect
from homebot.house.dialects.homeassistant import HomeAssistantDialect
from homebot.house.dialects.homie import HomieDialect
from homebot.house.dialects.shelly import ShellyDialect, ShellyRpcDialect
from homebot.house.dialects.tasmota import TasmotaDialect
from homebot.house.dialects.zigbee2mqtt import Zigbee2MqttDialect

__all__ = ["DIALECTS"]

DIALECTS: Final[Mapping[str, Dialect]] = {
    "thesis": ThesisDialect(),
    "homeassistant": HomeAssistantDialect(),
    "homeassistant_device": HomeAssistantDialect(whole_devices=True),
    "zigbee2mqtt": Zigbee2MqttDialect(),
    "tasmota": TasmotaDialect(),
    "shelly": ShellyDialect(),
    "shelly_rpc": ShellyRpcDialect(),
    "homie": HomieDialect(),
}
"""Every dialect."""
