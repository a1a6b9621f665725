"""As much of MQTT 3.1.1 on a plain socket as the load generator and the raw peers need.

Source: MQTT Version 3.1.1, sections 2.2.3 and 3.1 to 3.9.
"""

from __future__ import annotations

import socket
from collections.abc import Iterator

__all__ = [
    "PUBACK",
    "PUBLISH",
    "PacketStream",
    "connect",
    "connect_packet",
    "publish_packet",
    "subscribe",
    "subscribe_packet",
]

PUBLISH = 3
PUBACK = 4

_READ = 64 * 1024

# A broker without TCP_NODELAY, such as Mosquitto by default, holds a packet back until its last one is acknowledged,
# which Linux does 40 ms later unless it is told, after each read, to do so at once.
_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)


def connect(port: int, client_id: str) -> socket.socket:
    """Return a logged-in socket with TCP_NODELAY set, keep-alive off."""
    sock = socket.create_connection(("127.0.0.1", port))
    sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    sock.sendall(connect_packet(client_id))
    _expect(sock, b"\x20\x02\x00\x00")
    return sock


def subscribe(sock: socket.socket, topic_filter: str, qos: int) -> None:
    sock.sendall(subscribe_packet(topic_filter, qos))
    _expect(sock, b"\x90\x03\x00\x01" + bytes([qos]))


def connect_packet(client_id: str) -> bytes:
    return _packet(0x10, _text("MQTT") + b"\x04\x02\x00\x00" + _text(client_id))


def subscribe_packet(topic_filter: str, qos: int) -> bytes:
    """With packet identifier 1."""
    return _packet(0x82, b"\x00\x01" + _text(topic_filter) + bytes([qos]))


def publish_packet(topic: str, payload: bytes, qos: int = 0, packet_id: int = 0) -> bytes:
    identifier = packet_id.to_bytes(2, "big") if qos else b""
    return _packet(0x30 | qos << 1, _text(topic) + identifier + payload)


class PacketStream:
    """Cuts what a socket receives into packets.

    Args:
        sock: Logged in.
    """

    def __init__(self, sock: socket.socket) -> None:
        self._sock = sock
        self._rest = b""

    def read(self) -> Iterator[tuple[int, bytes]]:
        """Wait for bytes once; yield first byte and body of each packet that is whole now."""
        data = _receive(self._sock, _READ)
        data, position = self._rest + data, 0
        while (found := _body(data, position)) is not None:
            start, end = found
            yield data[position], data[start:end]
            position = end
        self._rest = data[position:]


def _receive(sock: socket.socket, most: int) -> bytes:
    data = sock.recv(most)
    if not data:
        raise ConnectionError("the broker closed the connection")
    if _QUICKACK is not None:
        sock.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
    return data


def _body(data: bytes, position: int) -> tuple[int, int] | None:
    length = shift = 0
    for index in range(position + 1, len(data)):
        length |= (data[index] & 0x7F) << shift
        shift += 7
        if data[index] < 0x80:
            end = index + 1 + length
            return (index + 1, end) if end <= len(data) else None
    return None


def _packet(first: int, body: bytes) -> bytes:
    length = bytearray()
    rest = len(body)
    while rest > 0x7F:
        length.append(rest & 0x7F | 0x80)
        rest >>= 7
    length.append(rest)
    return bytes([first]) + bytes(length) + body


def _text(text: str) -> bytes:
    data = text.encode()
    return len(data).to_bytes(2, "big") + data


def _expect(sock: socket.socket, answer: bytes) -> None:
    got = b""
    while len(got) < len(answer):
        got += _receive(sock, len(answer) - len(got))
    if got != answer:
        raise ConnectionError(f"the broker answered {got.hex(' ')} instead of {answer.hex(' ')}")
