"""The MQTT client port on our own codec: over TCP and TLS, or over a link in memory without socket and thread.

It keeps every promise of the port.
"""

from __future__ import annotations

from random import Random
from typing import final

from homebot.clock import Clock
from homebot.mqtt.client.base import BaseClient, ClientLink
from homebot.mqtt.client.protocol import ClientProtocol
from homebot.mqtt.client.receiver import Receiver
from homebot.mqtt.client.requests import Requests
from homebot.mqtt.client.tcp_transport import dial_tcp
from homebot.mqtt.client.transport import Dial
from homebot.mqtt.client.version_choice import MqttVersion
from homebot.mqtt.options import MqttOptions

__all__ = ["NativeClient"]


@final
class NativeClient(BaseClient):
    """The `MqttClient` port on our own codec; make it inside a running event loop.

    Args:
        options: Broker, login and limits.
        dial: The way to the broker.
        clock: Paces log lines.
        random: Chooses the first packet identifier.
    """

    def __init__(
        self,
        options: MqttOptions,
        dial: Dial = dial_tcp,
        *,
        clock: Clock | None = None,
        random: Random | None = None,
    ) -> None:
        super().__init__(options, clock)
        self._dial = dial
        self._requests = Requests(Random() if random is None else random)  # noqa: S311 - identifiers are no secret

    async def _open(self, options: MqttOptions, version: MqttVersion, receiver: Receiver) -> ClientLink:
        protocol = ClientProtocol(options, version, receiver, self._requests)
        await protocol.open(self._dial)
        return protocol
