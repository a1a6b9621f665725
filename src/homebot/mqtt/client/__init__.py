"""MQTT clients: the contract, the client on our own codec with its transports, and the adapter of aiomqtt."""

from homebot.mqtt.client.client import MqttClient
from homebot.mqtt.client.login import SessionGrant
from homebot.mqtt.client.receiver import MqttCounters
from homebot.mqtt.packets import MqttSubscription

__all__ = ["MqttClient", "MqttCounters", "MqttSubscription", "SessionGrant"]
