"""The broker alone: messages delivered a second, next to Mosquitto under the same load generator.

Three processes: the broker, the generator, and this one, which waits.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from mosquitto import mosquitto
from plan import Plan
from report import Aim, Comparison, MissingPeerError, Report, compare, per_second
from rounds import Measure, measure_interleaved
from worker import Worker, worker

__all__ = ["run"]

TITLE = "Broker: messages of 100 bytes delivered per second"
OURS = "homebot broker"
PEER = "Mosquitto"

# Subscribers, QoS, messages published in one round.
CASES = ((1, 0, 60_000), (1, 1, 30_000), (50, 0, 4_000), (50, 1, 2_000))


def run(plan: Plan) -> Report:
    if plan.mosquitto is None:
        raise MissingPeerError("Mosquitto is not installed")
    comparisons: list[Comparison] = []
    missing: dict[str, int] = {}
    with homebot_broker() as ours, mosquitto(plan.mosquitto) as peer, worker("broker_generator.py") as generator:
        for subscribers, qos, normal in CASES:
            count = plan.count(normal)
            contenders: dict[str, Measure] = {
                name: partial(deliver, generator, name, port, (subscribers, count, qos), missing)
                for name, port in ((OURS, ours), (PEER, peer))
            }
            samples = measure_interleaved(contenders, plan.rounds(7))
            pairs = [(OURS, PEER, Aim("at least", 1.0))]
            comparisons += compare(f"1 -> {subscribers}, QoS {qos}", samples, pairs, per_second)
    lost = ", ".join(f"{name}: {number}" for name, number in missing.items() if number) or "none by anybody"
    return Report(TITLE, comparisons, (f"Messages lost, over all rounds: {lost}.",))


def deliver(generator: Worker, name: str, port: int, load: tuple[int, int, int], missing: dict[str, int]) -> float:
    subscribers, count, qos = load
    generator.start("fan_out", port=port, subscribers=subscribers, count=count, qos=qos)
    result = generator.result()
    missing[name] = missing.get(name, 0) + int(result["missing"])
    return (subscribers * count - int(result["missing"])) / float(result["elapsed"])


@contextmanager
def homebot_broker() -> Iterator[int]:
    """Run ``homebot broker`` inside the block; the value is its port."""
    command = [sys.executable, "-m", "homebot", "broker", "--listen", "127.0.0.1:0", "--log-format", "json"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            yield int(json.loads(process.stderr.readline())["url"].rpartition(":")[2])
        finally:
            process.terminate()
