"""The clients by the names that a configuration has for them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeAlias

from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.client.port import MqttClient
from homebot.mqtt.options import MqttOptions

__all__ = ["MqttClientName", "client_maker"]

MqttClientName: TypeAlias = Literal["aiomqtt", "native"]


def client_maker(name: MqttClientName) -> Callable[[MqttOptions], MqttClient]:
    """Return the factory for clients of this name."""
    if name == "native":
        return NativeClient
    from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient  # noqa: PLC0415 - its libraries take long to import

    return AiomqttClient
