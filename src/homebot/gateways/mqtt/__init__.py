"""The gateway to MQTT brokers, and the conventions by which devices use them."""

from homebot.gateways.mqtt.convention import Convention, TopicDevice
from homebot.gateways.mqtt.gateway import MqttGateway
from homebot.gateways.mqtt.settings import MqttGatewaySettings
from homebot.gateways.mqtt.thesis import ThesisLayout

__all__ = ["Convention", "MqttGateway", "MqttGatewaySettings", "ThesisLayout", "TopicDevice"]
