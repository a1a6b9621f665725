"""Messages of state in a house of Zigbee lamps: five values as JSON, to whoever follows the lamps, in processor time.

Each figure is of a process of its own. It counts from the moment when all lamps are known and on, so that nothing of
the start is in it, until the last lamp has its last level.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from bench_ingest import RETAIN, seed
from mosquitto import mosquitto
from plan import Plan
from raw_mqtt import connect, publish_packet
from report import Aim, MissingPeerError, Report, compare
from rounds import Samples

__all__ = ["run"]

LAMPS = 200
TURNS = 50
LAST_LEVEL = 254
PAUSE = 0.05
"""Seconds between two turns: in a burst the newest state of a lamp takes the place of those before, as it should."""

TITLE = "States: processor time for each message of 200 lamps, with a follower of all lights"
HOMEBOT = "homebot, gateway and directory, native client"
AIOMQTT = "homebot, the same with aiomqtt"
HOME_ASSISTANT = "Home Assistant, MQTT integration"


def run(plan: Plan) -> Report:
    if plan.mosquitto is None:
        raise MissingPeerError("Mosquitto is not installed")
    here = Path(__file__).parent
    ours = [sys.executable, str(here / "states_homebot.py")]
    contenders = {HOMEBOT: [*ours, "native"], AIOMQTT: [*ours, "aiomqtt"]}
    if plan.home_assistant_python is not None:
        contenders[HOME_ASSISTANT] = [str(plan.home_assistant_python), str(here / "states_home_assistant.py")]
    turns = plan.count(TURNS)
    samples: Samples = {name: [] for name in contenders}
    with mosquitto(plan.mosquitto) as port:
        seed(port, LAMPS)
        _say_online(port)
        for number in range(plan.rounds(5)):
            names = list(contenders)
            for name in reversed(names) if number % 2 else names:
                samples[name].append(_cpu(contenders[name], port, turns) / (LAMPS * turns))
    pairs: list[tuple[str, str, Aim | None]] = [(HOMEBOT, AIOMQTT, None)]
    if HOME_ASSISTANT in contenders:
        pairs += [(HOMEBOT, HOME_ASSISTANT, Aim("at most", 1 / 3)), (AIOMQTT, HOME_ASSISTANT, None)]
    return Report(TITLE, compare("one message", samples, pairs, _microseconds))


def _say_online(port: int) -> None:
    """Keep with the broker that all can be reached, without which Home Assistant shows no state."""
    topics = ["zigbee2mqtt/bridge/state", *(f"zigbee2mqtt/lamp {number}/availability" for number in range(LAMPS))]
    with connect(port, "bench-availability") as sock:
        for topic in topics:
            packet = bytearray(publish_packet(topic, b'{"state":"online"}'))
            packet[0] |= RETAIN
            sock.sendall(packet)


def _cpu(command: list[str], port: int, turns: int) -> float:
    """Return the seconds of processor time that a worker took for the messages of so many *turns* of all lamps."""
    with subprocess.Popen(
        [*command[:2], str(port), str(LAMPS), *command[2:]], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as worker:
        assert worker.stdin is not None
        assert worker.stdout is not None
        with connect(port, "bench-lamps") as sock:
            _answer(worker.stdout)  # it knows the lamps
            for turn in range(turns):
                sock.sendall(b"".join(_turn(turn, LAST_LEVEL if turn == turns - 1 else turn % LAST_LEVEL)))
                time.sleep(PAUSE)
            figure: float = _answer(worker.stdout)["cpu"]
    return figure


def _turn(number: int, level: int) -> Iterator[bytes]:
    """Yield a state of each lamp, in which three of the five values are new; no two lamps say the same."""
    state = {"state": "ON", "brightness": level, "color_mode": "color_temp", "color_temp": 250 + number % 100}
    for lamp in range(LAMPS):
        payload = json.dumps({**state, "linkquality": (number + lamp) % 255}).encode()
        yield publish_packet(f"zigbee2mqtt/lamp {lamp}", payload)


def _answer(worker: IO[bytes]) -> dict[str, float]:
    line = worker.readline()
    assert line, "the worker ended"
    answer: dict[str, float] = json.loads(line)
    return answer


def _microseconds(seconds: float) -> str:
    return f"{1e6 * seconds:.1f} µs"
