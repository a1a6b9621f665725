"""Several machines as one house, each a process of its own: readings, commands and 10,000 devices across, on loopback.

The peer is one machine, with the same lamps in the homebot that has the index and the control.
"""

from __future__ import annotations

import json
import socket
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from plan import Plan
from report import Aim, Comparison, MissingPeerError, Report, megabytes, milliseconds
from rounds import Samples, median
from worker import Worker, worker

__all__ = ["run"]

ACROSS, ALONE = "two machines", "one machine"
LAMPS = 100
RATE, SECONDS = 2000, 10.0
COMMANDS = 200
MACHINES, DEVICES = 4, 10_000
LAMPS_CLASS = "machines_gateway:Lamps"


def run(plan: Plan) -> Report:
    if find_spec("zenoh") is None:
        raise MissingPeerError("Zenoh is not installed: homebot[ros2]")
    seconds = SECONDS / (10 if plan.quick else 1)
    comparisons: list[Comparison] = []
    cpu: Samples = {ACROSS: [], ALONE: []}
    took: Samples = {ACROSS: [], ALONE: []}
    for _ in range(plan.rounds(3)):
        for name, machines in ((ACROSS, 1), (ALONE, 0)):
            with house(machines, LAMPS) as (first, others):
                done(first, "find", count=LAMPS)
                cpu[name].append(_reported((first, *others), seconds))
                took[name].append(median(done(first, "turn_on", times=plan.count(COMMANDS))["took"]))
    comparisons.append(_compared(f"CPU of {RATE} readings a second", cpu, lambda one: f"{one:.2f} cores"))
    comparisons.append(_compared("turn_on until its report, p50", took, milliseconds))
    found: Samples = {ACROSS: [], ALONE: []}
    asked: Samples = {ACROSS: [], ALONE: []}
    memory: Samples = {ACROSS: [], ALONE: []}
    count = plan.count(DEVICES)
    for name, machines in ((ACROSS, MACHINES), (ALONE, 0)):
        with house(machines, count // (machines or 1)) as (first, _):
            answer = done(first, "find", count=count)
            found[name].append(answer["seconds"])
            asked[name].append(answer["query"])
            memory[name].append(done(first, "use")["kilobytes"] * 1024)
    case = f"{count} lamps on {MACHINES} machines"
    comparisons.append(_compared(f"{case}: found after the start of the first", found, milliseconds))
    comparisons.append(_compared(f"{case}: a query, p50", asked, milliseconds))
    comparisons.append(_compared(f"{case}: memory of the first", memory, megabytes))
    return Report("Several machines as one house", comparisons, ())


def _reported(machines: Sequence[Worker], seconds: float) -> float:
    """Return the cores that all *machines* take together at the rate, while the lamps of the last one report."""
    before = sum(done(one, "use")["cpu"] for one in machines)
    sent = done(machines[-1], "report", seconds=seconds, rate=RATE)["sent"]
    spent: float = sum(done(one, "use")["cpu"] for one in machines) - before
    rate: float = spent / sent * RATE
    return rate


def _compared(case: str, samples: Samples, show: Any, aim: Aim | None = None) -> Comparison:
    return Comparison(case, ACROSS, ALONE, samples[ACROSS], samples[ALONE], show, aim)


def done(machine: Worker, job: str, **facts: Any) -> dict[str, Any]:
    machine.start(job, **facts)
    return machine.result()


@contextmanager
def house(machines: int, lamps: int) -> Iterator[tuple[Worker, list[Worker]]]:
    """Run the first machine and *machines* others, each with *lamps*; with none, the first has them itself."""
    with TemporaryDirectory() as name, ExitStack() as stack:
        folder, address = Path(name), f"tcp/127.0.0.1:{_free_port()}"
        own = {"class": LAMPS_CLASS, "devices": lamps, "max_devices": lamps}
        gateways: dict[str, dict[str, Any]] = {} if machines else {"lamps": own}
        others = []
        for number in range(machines):
            machine = f"machine{number}"
            token = folder / f"{machine}.token"
            token.touch(0o600)
            token.write_text(f"secret of {machine}\n")
            gateways[machine] = {"class": "homebot", "token_file": token.name}
            link = {"connect": [address], "machine": machine, "password_file": token.name}
            tables = {"home": {"name": "villa"}, "ros": link, "gateways": {"lamps": own}}
            others.append(
                stack.enter_context(worker("machines_worker.py", sys.executable, json.dumps(tables), str(folder)))
            )
        tables = {"home": {"name": "villa"}, "gateways": gateways}
        if machines:
            tables["ros"] = {"listen": address}
        yield stack.enter_context(worker("machines_worker.py", sys.executable, json.dumps(tables), str(folder))), others


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
