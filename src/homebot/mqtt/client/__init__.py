"""MQTT clients: the port, the client on our own codec with its transports, and the adapter of aiomqtt."""

from homebot.mqtt.client.port import MqttClient, MqttCounters, MqttSubscription, PublishResult, SessionGrant

__all__ = ["MqttClient", "MqttCounters", "MqttSubscription", "PublishResult", "SessionGrant"]
