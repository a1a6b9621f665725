"""Zigbee devices as Zigbee2MQTT itself announces them, without Home Assistant's discovery."""

from homebot.integrations.zigbee2mqtt.formats.convention import Zigbee2Mqtt, Zigbee2MqttSettings

__all__ = ["Zigbee2Mqtt", "Zigbee2MqttSettings"]
