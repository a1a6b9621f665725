"""The families of devices that there are in houses, as they speak over MQTT, by their names there. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from homebot.house.dialect import Dialect
from homebot.house.dialects.homeassistant import HomeAssistantDialect
from homebot.house.dialects.homie import HomieDialect
from homebot.house.dialects.shelly import ShellyDialect
from homebot.house.dialects.shelly_rpc import ShellyRpcDialect
from homebot.house.dialects.tasmota import TasmotaDialect
from homebot.house.dialects.thesis import ThesisDialect
from homebot.house.dialects.zigbee2mqtt import Zigbee2MqttDialect

__all__ = ["DIALECTS"]

DIALECTS: Mapping[str, Dialect] = MappingProxyType(
    {
        "thesis": ThesisDialect(),
        "homeassistant": HomeAssistantDialect(),
        "homeassistant_device": HomeAssistantDialect(whole_devices=True),
        "zigbee2mqtt": Zigbee2MqttDialect(),
        "tasmota": TasmotaDialect(),
        "shelly": ShellyDialect(),
        "shelly_rpc": ShellyRpcDialect(),
        "homie": HomieDialect(),
    }
)
"""Every dialect."""
