"""The embedded broker in a process of its own, to be attacked, and what that costs it.

``with attacked_broker() as broker`` starts it; ``broker.toll()`` tells what was seen since the last reading. A turn of
its event loop is measured in CPU time, so that a busy machine does not count.
"""

from __future__ import annotations

import asyncio
import json
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tests.patience import PATIENCE
from tests.system.attack_probe import ROOT, open_files, rss

from homebot.log import configure_logging
from homebot.mqtt.broker import Broker, BrokerStats
from homebot.mqtt.packets import Connack, Connect, Packet, PacketReader, ProtocolVersion, encode

PASSWORD = "right"


@dataclass(frozen=True)
class Toll:
    """What the broker is like now, and what its loop did since the last reading.

    Attributes:
        turn: CPU seconds of the longest turn of the loop.
        rss: Resident memory in MiB.
        files: Open files and sockets.
        stats: All counts.
    """

    turn: float
    rss: float
    files: int
    stats: BrokerStats

    def __str__(self) -> str:
        return f"longest turn {self.turn * 1000:.0f} ms of CPU time, {self.rss:.0f} MiB, {self.files} files"

    @property
    def left_open(self) -> tuple[int, int, int, int]:
        """What must be after a flood as it was before it."""
        return self.files, self.stats.clients, self.stats.sessions, self.stats.subscriptions


class AttackedBroker:
    """A broker in a process of its own.

    Attributes:
        pid: Its process.
        port: Where it listens.
        sockets: Those that were opened to it; closed at the end.
    """

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.pid = process.pid
        self.sockets: list[socket.socket] = []
        self._process = process
        self.port = int(self._answer()["port"])

    def toll(self) -> Toll:
        """Read what was seen since the last reading."""
        assert self._process.stdin is not None
        self._process.stdin.write("toll\n")
        self._process.stdin.flush()
        seen = self._answer()
        return Toll(seen["turn"], rss(self.pid), open_files(self.pid), BrokerStats(**seen["stats"]))

    def settled(self, before: Toll, within: float = PATIENCE) -> Toll:
        """Return the toll once as much is open as *before*, or the last one after *within*."""
        deadline = time.monotonic() + within
        now = self.toll()
        while now.left_open != before.left_open and time.monotonic() < deadline:
            time.sleep(0.2)
            now = self.toll()
        return now

    def open(self, data: bytes = b"") -> socket.socket:
        """Open a socket and send *data*."""
        opened = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)
        self.sockets.append(opened)
        if data:
            opened.sendall(data)
        return opened

    def client(self, client_id: str, version: ProtocolVersion = ProtocolVersion.V5, **more: Any) -> Client:
        """Log a client in."""
        return Client(self.open(), Connect(client_id, version, **more))

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "the broker ended"
        answer: dict[str, Any] = json.loads(line)
        return answer


class Client:
    """A client that waits for what it wants to see.

    Attributes:
        socket: Its socket.
        connack: How it was welcomed.
    """

    def __init__(self, opened: socket.socket, connect: Connect) -> None:
        self.socket = opened
        self._version = connect.version
        self._packets = PacketReader(connect.version)
        self.send(connect)
        welcome = self.take()
        assert isinstance(welcome, Connack)
        self.connack = welcome

    def send(self, *packets: Packet) -> None:
        """Send all in one piece."""
        self.socket.sendall(b"".join(encode(packet, self._version) for packet in packets))

    def take(self) -> Packet:
        """The next packet."""
        while (packet := self._packets.pop()) is None:
            data = self.socket.recv(65_536)
            assert data, "the broker closed the connection"
            self._packets.feed(data)
        return packet

    def close(self) -> None:
        """Close the socket without a word."""
        self.socket.close()


@contextmanager
def attacked_broker(*, user: str = "") -> Iterator[AttackedBroker]:
    """Run a broker on a free port; with *user*, whose password is ``right``, it lets nobody else in."""
    command = [sys.executable, "-m", __name__, user]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT)
    with process:
        try:
            broker = AttackedBroker(process)
            with closing(broker.sockets):
                yield broker
        finally:
            process.kill()


@contextmanager
def closing(sockets: Sequence[socket.socket]) -> Iterator[None]:
    """Close them after the block."""
    try:
        yield
    finally:
        for each in sockets:
            each.close()


def is_closed(opened: socket.socket) -> bool:
    """Whether the far side has closed *opened*; what came before that is thrown away."""
    opened.settimeout(0)
    try:
        while opened.recv(65_536):
            pass
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True


class _MeasuredLoop(asyncio.SelectorEventLoop):
    """Notes the CPU time of its longest turn."""

    longest = 0.0

    def _run_once(self) -> None:
        before = time.thread_time()
        super()._run_once()  # type: ignore[misc] # asyncio's own
        self.longest = max(self.longest, time.thread_time() - before)


async def _serve(loop: _MeasuredLoop, user: str) -> None:
    told = asyncio.Event()
    lines = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(lines), sys.stdin)
    async with Broker(credentials={user: PASSWORD} if user else None) as broker:
        print(json.dumps({"port": broker.port}), flush=True)
        while not told.is_set() and await lines.readline():
            turn, loop.longest = loop.longest, 0.0
            print(json.dumps({"turn": turn, "stats": asdict(broker.stats)}), flush=True)


def _main() -> None:
    configure_logging(level="error")
    loop = _MeasuredLoop()
    with asyncio.Runner(loop_factory=lambda: loop) as runner:
        runner.run(_serve(loop, sys.argv[1]))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(ROOT)))
    _main()
