"""A house with one device of every model that Zigbee2MQTT knows, as its broker has it: until homebot knows them all.

The npm package zigbee2mqtt makes the messages, see ``zigbee_house.js``; `make bench` installs it.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from mosquitto import mosquitto
from plan import Plan
from raw_mqtt import connect, publish_packet
from report import MissingPeerError, Report, verdict

__all__ = ["run"]

HERE = Path(__file__).parent
PACKAGES = HERE.parent / ".venv-bench-zigbee"
TITLE = "zigbee_house: all models of Zigbee2MQTT, retained, until every device is known"
HEADINGS = ("what the broker has", "messages", "devices", "parts", "processor time", "aim", "find() of all", "aim")
FIND = 1.0
EACH_QUICK = 20
RETAIN = 0x01
PINGREQ, PINGRESP = b"\xc0\x00", b"\xd0\x00"

CASES: tuple[tuple[str, tuple[str, ...], float], ...] = (
    ("discovery of Home Assistant", ("homeassistant/",), 10.0),
    ("the same, bridge/devices and availability", ("homeassistant/", "zigbee2mqtt/"), 14.0),
)
"""Name, first levels of the topics, and the processor seconds that are aimed at."""


def run(plan: Plan) -> Report:
    node = shutil.which("node")
    if plan.mosquitto is None or node is None or not (PACKAGES / "node_modules").exists():
        raise MissingPeerError("Mosquitto, Node.js or the npm package zigbee2mqtt is not installed")
    each = EACH_QUICK if plan.quick else 1
    command = [node, str(HERE / "zigbee_house.js"), str(PACKAGES), str(each)]
    made = subprocess.run(command, stdout=subprocess.PIPE, check=True)
    messages = [tuple(json.loads(line)) for line in made.stdout.splitlines()]
    rows: list[tuple[str, ...]] = [HEADINGS]
    for name, levels, aim in CASES:
        retained = [message for message in messages if message[0].startswith(levels)]
        with mosquitto(plan.mosquitto) as port:
            publish_retained(port, retained)
            worker = [sys.executable, str(HERE / "zigbee_house_homebot.py"), str(port)]
            done = subprocess.run(worker, stdout=subprocess.PIPE, check=True)
        rows.append(_row(name, len(retained), json.loads(done.stdout), aim))
    return Report(TITLE, [], [f"Every {each}th model: the aims are for all."] if each > 1 else [], rows)


def publish_retained(port: int, messages: Iterable[tuple[str, str]]) -> None:
    """Put *messages* on the broker, and wait until it has them."""
    with connect(port, "bench-house") as sock:
        for topic, payload in messages:
            packet = bytearray(publish_packet(topic, payload.encode(), 0))
            packet[0] |= RETAIN
            sock.sendall(packet)
        sock.sendall(PINGREQ)
        answer = b""
        while not answer.endswith(PINGRESP):
            answer += sock.recv(100)


def _row(name: str, messages: int, found: dict[str, Any], aim: float) -> tuple[str, ...]:
    return (
        name,
        f"{messages:,}",
        f"{found['devices']:,}",
        f"{found['parts']:,}",
        f"{found['processor']:.1f} s",
        _verdict(found["processor"], aim),
        f"{found['find']:.2f} s",
        _verdict(found["find"], FIND),
    )


def _verdict(figure: float, aim: float) -> str:
    return f"<= {aim:g} s: {verdict(figure <= aim)}"
