"""The gateway to MQTT brokers, and the conventions by which devices use them."""

from homebot.conventions.convention import Convention
from homebot.gateways.mqtt.gateway import MqttGateway
from homebot.gateways.mqtt.settings import MqttGatewaySettings

__all__ = ["Convention", "MqttGateway", "MqttGatewaySettings"]
