"""One publisher and its subscribers, in a process of their own that shares no interpreter with what is measured.

Each line of standard input is a job, each line of standard output its result. The publisher stays at most a window
ahead of the slowest subscriber, so that nobody has a reason to drop a message, and every one is accounted for.
"""

from __future__ import annotations

import json
import selectors
import socket
import sys
import time
from typing import Any

from raw_mqtt import connect, publish_packet, subscribe

CHUNK = 100
WINDOW = 1000
PATIENCE = 20.0
READ = 256 * 1024
TOPIC = "bench/broker"
PAYLOAD = 100

_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)  # as in raw_mqtt


class Subscriber:
    """Counts fixed-size messages; at QoS 1 acknowledges each block of them at once."""

    def __init__(self, port: int, number: int, qos: int) -> None:
        self.sock = connect(port, f"bench-sub-{number}")
        subscribe(self.sock, TOPIC, qos)
        self.sock.setblocking(False)
        self.received = 0
        self._qos = qos
        self._size = len(publish_packet(TOPIC, bytes(PAYLOAD), qos, 1))
        self._id_at = self._size - PAYLOAD - 2
        self._rest = b""

    def read(self) -> None:
        data = self._rest + _read(self.sock)
        whole = len(data) // self._size
        self._rest = data[whole * self._size :]
        self.received += whole
        if self._qos and whole:
            starts = range(self._id_at, whole * self._size, self._size)
            acks = b"".join(b"\x40\x02" + data[start : start + 2] for start in starts)
            sent = self.sock.send(acks)
            assert sent == len(acks), "the broker does not read the acknowledgements"


class Publisher:
    """Sends chunks as far as its window and its socket let it."""

    def __init__(self, port: int, count: int, qos: int) -> None:
        self.sock = connect(port, "bench-pub")
        self.sock.setblocking(False)
        self.chunks = [
            b"".join(
                publish_packet(TOPIC, bytes(PAYLOAD), qos, each % 65_535 + 1)
                for each in range(start, min(start + CHUNK, count))
            )
            for start in range(0, count, CHUNK)
        ]
        self.sent = 0
        self.acknowledged_bytes = 0
        self._rest = b""

    def write(self, delivered: int) -> bool:
        """Send what may be sent; return whether the socket is full."""
        while True:
            if not self._rest:
                position = self.sent // CHUNK
                if position == len(self.chunks) or self.sent + CHUNK - delivered > WINDOW:
                    return False
                self._rest = self.chunks[position]
                self.sent += CHUNK
            try:
                self._rest = self._rest[self.sock.send(self._rest) :]
            except BlockingIOError:
                return True

    def read(self) -> None:
        self.acknowledged_bytes += len(_read(self.sock))


def fan_out(port: int, subscribers: int, count: int, qos: int) -> dict[str, Any]:
    """Publish *count* messages to *subscribers*.

    Returns:
        Seconds from the first byte sent until everybody has everything, QoS 1 acknowledged; messages missing.
    """
    readers = [Subscriber(port, number, qos) for number in range(subscribers)]
    publisher = Publisher(port, count, qos)
    with selectors.DefaultSelector() as selector:
        for reader in readers:
            selector.register(reader.sock, selectors.EVENT_READ, reader.read)
        selector.register(publisher.sock, selectors.EVENT_READ, publisher.read)
        started = time.perf_counter()
        while True:
            slowest = min(reader.received for reader in readers)
            if slowest == count and publisher.acknowledged_bytes == (4 * count if qos else 0):
                break
            full = publisher.write(slowest)
            wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if full else 0)
            selector.modify(publisher.sock, wanted, publisher.read)
            ready = selector.select(PATIENCE)
            if not ready:
                break
            for key, events in ready:
                if events & selectors.EVENT_READ:
                    key.data()
        elapsed = time.perf_counter() - started
    for sock in (*(reader.sock for reader in readers), publisher.sock):
        sock.close()
    return {"elapsed": elapsed, "missing": sum(count - reader.received for reader in readers)}


def _read(sock: socket.socket) -> bytes:
    data = sock.recv(READ)
    if not data:
        raise ConnectionError("the broker closed the connection")
    if _QUICKACK is not None:
        sock.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
    return data


def main() -> None:
    print(json.dumps({}), flush=True)
    for line in sys.stdin:
        facts = json.loads(line)
        assert facts.pop("job") == "fan_out"
        print(json.dumps(fan_out(**facts)), flush=True)


if __name__ == "__main__":
    main()
