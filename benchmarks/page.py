"""The page with a large house: 1,000 lamps of Zigbee2MQTT in 50 rooms, of which 100 change in a second.

homebot, the browser and the lamps are processes of their own, so the browser's own work also delays homebot where the
computer has few cores.
"""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

from bench_ingest import RETAIN, light_config
from mosquitto import mosquitto
from plan import Plan
from raw_mqtt import connect, publish_packet
from report import MissingPeerError, Report, verdict
from worker import Worker, worker

__all__ = ["run"]

LAMPS = 1000
ROOMS = 50
RATE = 100
SECONDS = 30
TITLE = f"page: {LAMPS:,} lamps, {RATE} changes a second"
HEADINGS = (
    "the page",
    "loop lag p99",
    "aim",
    "longest",
    "processor",
    "changes shown",
    "frame p99",
    "aim",
    "longest",
    "first paint, all listed after",
    "heap",
)
LAG = 20.0  # ms
FRAME = 50.0  # ms
CLOSED, OPEN = 1, 50
"""The first levels, so that each message changes something."""

HERE = Path(__file__).parent
PYTHON = HERE.parent / ".venv" / "bin" / "python"
"""The environment of the tests against other programs, which has selenium."""


def run(plan: Plan) -> Report:
    if plan.mosquitto is None or shutil.which("chromedriver") is None or not _has_selenium():
        raise MissingPeerError("Mosquitto, Chromium, its driver or selenium is not installed")
    seconds = plan.count(SECONDS)
    with mosquitto(plan.mosquitto) as port:
        _announce(port)
        with worker("page_homebot.py", sys.executable, str(port)) as homebot:
            rows = [HEADINGS, _unseen(homebot, port, seconds), _seen(homebot, port, seconds)]
    return Report(TITLE, [], [], rows)


def _has_selenium() -> bool:
    return (
        PYTHON.exists()
        and not subprocess.run([PYTHON, "-c", "import selenium"], stderr=subprocess.DEVNULL, check=False).returncode
    )


def _announce(port: int) -> None:
    """Keep with the broker that there are lamps in rooms, which can be reached, and are on."""
    with connect(port, "bench-lamps") as sock:
        for number in range(LAMPS):
            topic, config = light_config(number)
            config = config.replace(b'"device": {', b'"device": {"suggested_area": "room %d", ' % (number % ROOMS))
            _retain(sock, topic, config)
            _retain(sock, f"zigbee2mqtt/lamp {number}/availability", b'{"state":"online"}')
            _retain(sock, f"zigbee2mqtt/lamp {number}", _state(0))
        _retain(sock, "zigbee2mqtt/bridge/state", b'{"state":"online"}')


def _retain(sock: socket.socket, topic: str, payload: bytes) -> None:
    packet = bytearray(publish_packet(topic, payload))
    packet[0] |= RETAIN
    sock.sendall(packet)


def _unseen(homebot: Worker, port: int, seconds: int) -> tuple[str, ...]:
    time.sleep(5.0)  # what it does after the last lamp
    homebot.start("report")
    homebot.result()
    _change(port, seconds, CLOSED)
    return ("closed", *_loop(homebot), "", "", "", "", "", "")


def _seen(homebot: Worker, port: int, seconds: int) -> tuple[str, ...]:
    url = f"http://127.0.0.1:{homebot.greeting['port']}/"
    with worker("page_browser.py", PYTHON, url, str(LAMPS)) as browser:
        for one in (homebot, browser):
            one.start("report")
            one.result()
        _change(port, seconds, OPEN)
        browser.start("report")
        frames = browser.result()
        row = (
            "open",
            *_loop(homebot),
            f"{frames['changes']:,}",
            f"{frames['p99']:.1f} ms",
            _verdict(frames["p99"], FRAME),
        )
        shown = browser.greeting
        times = f"{shown['painted']:.2f} s, {shown['listed']:.2f} s"
        return (*row, f"{frames['longest']:.1f} ms", times, f"{shown['heap']:.1f} MB")


def _change(port: int, seconds: int, level: int) -> None:
    """Change one lamp after the other, in the first turn to *level*."""
    began = time.perf_counter()
    with connect(port, "bench-changes") as sock:
        for number in range(RATE * seconds):
            time.sleep(max(0.0, began + number / RATE - time.perf_counter()))
            sock.sendall(publish_packet(f"zigbee2mqtt/lamp {number % LAMPS}", _state(level + number // LAMPS)))


def _state(level: int) -> bytes:
    return json.dumps({"state": "ON", "brightness": 2 * level, "color_temp": 250, "linkquality": level}).encode()


def _loop(homebot: Worker) -> tuple[str, ...]:
    homebot.start("report")
    found = homebot.result()
    p99, longest = found["p99"], found["longest"]
    return (f"{p99:.1f} ms", _verdict(p99, LAG), f"{longest:.1f} ms", f"{found['cpu']:.0%}")


def _verdict(figure: float, aim: float) -> str:
    return f"<= {aim:g} ms: {verdict(figure <= aim)}"
