"""Both clients that reach a broker by TCP, one after the other."""

from typing import Any

import pytest
from tests.mqtt.client.scripted_broker import MakeClient

from homebot.mqtt.client import MqttClient
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.options import MqttOptions

ClientKind = type[AiomqttClient] | type[NativeClient]


@pytest.fixture(params=[AiomqttClient, NativeClient], ids=["aiomqtt", "native"])
def client_kind(request: pytest.FixtureRequest) -> ClientKind:
    kind: ClientKind = request.param
    return kind


@pytest.fixture
def make(client_kind: ClientKind) -> MakeClient:
    return maker_of(client_kind)


@pytest.fixture
def make_native() -> MakeClient:
    """For the one promise of the port that aiomqtt does not keep; `test_aiomqtt_adapter` has what it does instead."""
    return maker_of(NativeClient)


def maker_of(kind: ClientKind) -> MakeClient:
    def make(port: int, *, timeout: float = 60.0, **settings: Any) -> MqttClient:
        return kind(MqttOptions(host="127.0.0.1", port=port, timeout=timeout, **settings))

    return make
