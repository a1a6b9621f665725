"""A Mosquitto of our own on a free loopback port."""

from __future__ import annotations

import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["mosquitto"]

# Its own defaults but for one: no limit to its queues, else it drops what the slower of the contenders has not read.
CONFIG = """
listener {port} 127.0.0.1
allow_anonymous true
max_queued_messages 0
"""


@contextmanager
def mosquitto(program: str) -> Iterator[int]:
    """Run *program* inside the block; the value is its port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = int(probe.getsockname()[1])
    with tempfile.TemporaryDirectory() as directory:
        config = Path(directory, "mosquitto.conf")
        config.write_text(CONFIG.format(port=port))
        with subprocess.Popen([program, "-c", str(config)], stderr=subprocess.DEVNULL) as process:
            try:
                _wait_for(port)
                yield port
            finally:
                process.terminate()


def _wait_for(port: int) -> None:
    deadline = time.monotonic() + 5
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
        except ConnectionRefusedError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.02)
        else:
            return
