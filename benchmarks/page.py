"""The page with a large house: 1,000 lamps of Zigbee2MQTT in 50 rooms, a tile each, of which 100 change in a second;
then the changes of a day, one after the other.

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
from collections import defaultdict
from pathlib import Path
from typing import Any

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
DAY = 432_000  # changes, five a second
FAST = 1000  # changes a second of that day
TITLE = f"page: {LAMPS:,} lamps, {RATE} changes a second"
HEADINGS = ("what", "measured", "aim")
CLOSED, OPEN = 1, 50
"""The first levels, so that each message changes something, also as a percentage."""

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
            rows = [*_unseen(homebot, port, seconds), *_seen(homebot, port, seconds, plan.count(DAY))]
    return Report(TITLE, [], [], [HEADINGS, *rows])


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


def _unseen(homebot: Worker, port: int, seconds: int) -> list[tuple[str, ...]]:
    time.sleep(5.0)  # what it does after the last lamp
    _loop(homebot, "")
    _change(port, RATE * seconds, RATE, CLOSED)
    return _loop(homebot, "closed")


def _seen(homebot: Worker, port: int, seconds: int, day: int) -> list[tuple[str, ...]]:
    url = f"http://127.0.0.1:{homebot.greeting['port']}/"
    with worker("page_browser.py", PYTHON, url, str(LAMPS)) as browser:
        loaded = browser.greeting
        _change(port, 3 * LAMPS, FAST, CLOSED)  # what each tile keeps from its first changes on
        time.sleep(1.0)
        _loop(homebot, "")
        _report(browser)
        sent = _change(port, RATE * seconds, RATE, OPEN)
        time.sleep(1.0)  # what is under way
        live = _report(browser)
        rows = _loop(homebot, "open")
        before = _report(browser, "rest")["heap"]
        _change(port, day, FAST, OPEN)
        time.sleep(1.0)
        grown = _report(browser, "rest")["heap"] - before
    delays = _delays(sent, live["shown"])
    return [
        *rows,
        _row("first load, compressed", loaded["loaded"], "kB", 60),
        _row("first paint", loaded["painted"], "s", 1),
        _row(f"{LAMPS:,} tiles drawn", loaded["drawn"], "s", 1),
        _row(f"heap with {LAMPS:,} tiles", loaded["heap"], "MB", 12),
        _row(f"its growth in {day:,} changes", grown, "MB", 1),
        _row(f"change to pixel, p99 of {len(delays):,}", 1e3 * delays[int(0.99 * len(delays))], "ms", 50),
        _row(f"frame p99, longest {live['longest']:.0f} ms", live["p99"], "ms", 50),
    ]


def _report(process: Worker, job: str = "report") -> dict[str, Any]:
    process.start(job)
    return process.result()


def _delays(sent: dict[int, list[float]], shown: list[tuple[int, float]]) -> list[float]:
    """Return the seconds from each change to its frame, of lamps of which each change was shown, sorted.

    Raises:
        RuntimeError: Most were not shown, so that nothing is measured.
    """
    seen = defaultdict(list)
    for lamp, at in shown:
        seen[lamp].append(at)
    whole = [lamp for lamp, times in sent.items() if len(times) == len(seen[lamp])]
    if len(whole) < len(sent) / 2:
        raise RuntimeError(f"the page shows each change of {len(whole)} of {len(sent)} lamps")
    return sorted(then - at for lamp in whole for at, then in zip(sent[lamp], seen[lamp], strict=True))


def _change(port: int, count: int, rate: int, level: int) -> dict[int, list[float]]:
    """Change one lamp after the other, in the first turn to *level*; return when, by lamp."""
    began, sent = time.perf_counter(), defaultdict(list)
    with connect(port, "bench-changes") as sock:
        for number in range(count):
            time.sleep(max(0.0, began + number / rate - time.perf_counter()))
            sent[number % LAMPS].append(time.time())
            sock.sendall(publish_packet(f"zigbee2mqtt/lamp {number % LAMPS}", _state(level + number // LAMPS % 50)))
    return sent


def _state(level: int) -> bytes:
    return json.dumps({"state": "ON", "brightness": 2 * level, "color_temp": 250, "linkquality": level}).encode()


def _loop(homebot: Worker, page: str) -> list[tuple[str, ...]]:
    found = _report(homebot)
    about = f"event loop late, p99, longest {found['longest']:.0f} ms, processor {found['cpu']:.0%}"
    return [_row(f"page {page}: {about}", found["p99"], "ms", 20)]


def _row(what: str, figure: float, unit: str, most: float) -> tuple[str, ...]:
    return what, f"{figure:.1f} {unit}", f"<= {most:g} {unit}: {verdict(figure <= most)}"
