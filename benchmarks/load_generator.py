"""The publisher, in a process of its own, so that it shares no interpreter with what is measured.

Each line of standard input is a job, each line of standard output its result.
"""

from __future__ import annotations

import json
import select
import sys
import time
from collections.abc import Callable
from typing import Any

from raw_mqtt import PUBACK, PUBLISH, PacketStream, connect, publish_packet, subscribe

CHUNK = 100
UNACKNOWLEDGED = 1000
PATIENCE = 2.0


def flood(port: int, topics: list[str], count: int, qos: int) -> dict[str, Any]:
    """Publish *count* messages as fast as the broker takes them; the payload is the number in 8 digits.

    Returns:
        When the first was sent, and how long it took until the broker had them all; by ``time.perf_counter``.
    """
    packets = [
        publish_packet(topics[number % len(topics)], b"%08d" % number, qos, number % 65_535 + 1)
        for number in range(count)
    ]
    with connect(port, "bench-load") as sock:
        stream, acknowledged = PacketStream(sock), 0
        started = time.perf_counter()
        for position in range(0, count, CHUNK):
            sock.sendall(b"".join(packets[position : position + CHUNK]))
            while qos and position + CHUNK - acknowledged > UNACKNOWLEDGED:
                acknowledged += sum(first >> 4 == PUBACK for first, _ in stream.read())
        while qos and acknowledged < count:
            acknowledged += sum(first >> 4 == PUBACK for first, _ in stream.read())
        if not qos:
            sock.sendall(publish_packet("bench-load/end", b"", 1, 1))
            while not any(first >> 4 == PUBACK for first, _ in stream.read()):
                pass
        return {"started": started, "elapsed": time.perf_counter() - started}


def pace(port: int, out: str, back: str, rate: int, count: int) -> dict[str, Any]:
    """Publish *count* messages of QoS 1 on *out*, *rate* a second, and take the time until each is back on *back*.

    Returns:
        The round trips in seconds, those that came back.
    """
    sent: list[float] = []
    round_trips: dict[int, float] = {}
    with connect(port, "bench-load") as sock:
        subscribe(sock, back, 0)
        stream = PacketStream(sock)
        started = time.perf_counter()
        while len(round_trips) < count:
            now = time.perf_counter()
            if len(sent) < count and now >= started + len(sent) / rate:
                sent.append(time.perf_counter())
                number = len(sent) - 1
                sock.sendall(publish_packet(out, b"%08d" % number, 1, number % 65_535 + 1))
                continue
            due = started + len(sent) / rate if len(sent) < count else sent[-1] + PATIENCE
            if not select.select([sock], [], [], max(0.0, due - now))[0]:
                if len(sent) == count:
                    break
                continue
            for first, body in stream.read():
                if first >> 4 == PUBLISH:
                    number = int(body[-8:])
                    round_trips.setdefault(number, time.perf_counter() - sent[number])
    return {"round_trips": list(round_trips.values())}


def main() -> None:
    print(json.dumps({}), flush=True)
    jobs: dict[str, Callable[..., dict[str, Any]]] = {"flood": flood, "pace": pace}
    for line in sys.stdin:
        facts = json.loads(line)
        print(json.dumps(jobs[facts.pop("job")](**facts)), flush=True)


if __name__ == "__main__":
    main()
