"""The next message on a topic, over a connection of its own: nothing waits behind a large one."""

import secrets
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import anyio

from homebot.errors import LinkError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions

_COMES_WITHIN: Final = 8.0
_MAX_BYTES: Final = 3_000_000


async def next_message(topic: str, options: MqttOptions, make_client: Callable[[MqttOptions], MqttClient]) -> bytes:
    """Return the next payload on *topic*, of at most 3 MB, which comes at once if the broker keeps one.

    Args:
        options: The broker and the login; the rest is its own.

    Raises:
        LinkError: None comes within eight seconds.
    """
    name = f"homebot-{secrets.token_hex(4)}"
    own = replace(options, client_id=name, session_expiry=0, will=None, maximum_packet_size=_MAX_BYTES)
    with anyio.move_on_after(_COMES_WITHIN):
        async with MqttConnection(own, make_client, status_topic=None) as connection:
            await connection.subscribe(MqttSubscription(topic))
            while True:
                for message in await connection.receive():
                    if message.payload:
                        return message.payload
    raise LinkError(f"no message came on {topic} within {_COMES_WITHIN:g} s")
