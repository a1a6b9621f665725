"""Ends a session at the broker: a client that says good-bye for ever leaves nothing there.

MQTT 3.1.1 has one way to it: connect once more under the same client id, with a clean session, and leave.
Source: MQTT Version 3.1.1, section 3.1.2.4; MQTT Version 5.0, section 3.1.2.4.
"""

from __future__ import annotations

import socket
import ssl
from typing import Literal

import anyio

from homebot.errors import LinkError
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Connect, Disconnect, ProtocolVersion, encode

__all__ = ["end_session"]

_VERSIONS = {"5": ProtocolVersion.V5, "3.1.1": ProtocolVersion.V311}


async def end_session(options: MqttOptions, version: Literal["5", "3.1.1"], sock: socket.socket) -> None:
    """Let the broker forget the session of ``options.client_id``; *sock* is connected to it, and closed in the end.

    Raises:
        LinkError: The broker did not answer.
    """
    codec = _VERSIONS[version]
    password = None if options.password is None else options.password.get_secret_value().encode()
    connect = Connect(client_id=options.client_id, version=codec, username=options.user, password=password)
    try:
        sock.send(encode(connect, codec))
        await _answer(sock)
        sock.send(encode(Disconnect(), codec))
    except OSError as error:
        raise LinkError(f"the session could not be ended: {error.strerror}") from error
    finally:
        sock.close()


async def _answer(sock: socket.socket) -> None:
    """Wait for the first bytes of the answer; whatever it says, there is no more to do."""
    while True:
        try:
            sock.recv(1024)
        except (BlockingIOError, ssl.SSLWantReadError):
            await anyio.wait_readable(sock)
        else:
            return
