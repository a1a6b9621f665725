"""The gateways by the five criteria of the literature on discovery: storage, discovery time, traffic, success rate and
reliability, which is here the time until a death is noticed.

Each gateway is measured in a process of its own, where possible with a loopback interface of its own.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from discovery_houses import HOUSES
from plan import Plan
from report import Report

__all__ = ["run"]

TITLE = "discovery: devices that come, and die without a word"
HEADINGS = (
    "gateway, device",
    "found after, p50 / p95",
    "joins",
    "death noticed after, p50 / p95",
    "deaths",
    "traffic each",
    "memory each",
)
PATIENCE = 330.0
"""Seconds that deaths are waited for: a little longer than the longest rule, five minutes of a sensor on a battery."""

ALONE = "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo"


def run(plan: Plan) -> Report:
    count, patience = (10, 5.0) if plan.quick else (100, PATIENCE)
    alone = _has_own_network()
    rows, notes, missing = [], [], []
    with TemporaryDirectory() as scratch, ThreadPoolExecutor() as waiters:
        measured = [(name, _start(name, count, patience, waiters, scratch, alone=alone)) for name in HOUSES]
    for name, (joined, later) in measured:
        noticed = later.result()
        if joined is None or noticed is None:
            missing.append(f"{name}, whose error is above")
            continue
        rows.append(_row(name, count, joined, noticed["noticed"], alone=alone))
        notes.append(f"{name}: {_how(noticed['noticed'])}; by the rules: {HOUSES[name].rule}.")
        found, further = joined["further"]
        if found < further:
            notes.append(f"{name}: of {further} further devices, for the memory, only {found} were found.")
    if plan.quick:
        notes.append(f"Deaths were waited for no longer than {patience:.0f} s.")
    if not alone:
        missing.append("traffic, which needs Linux, root, unshare and ip")
    return Report(TITLE, (), notes, [HEADINGS, *rows], missing)


def _start(
    name: str, count: int, patience: float, waiters: ThreadPoolExecutor, scratch: str, *, alone: bool
) -> tuple[dict[str, Any] | None, Future[dict[str, Any] | None]]:
    """Measure until all have joined; the rest is waited for while the next gateway is measured."""
    script = str(Path(__file__).with_name("discovery_worker.py"))
    command = [sys.executable, script, name, str(count), str(patience)]
    if alone:
        command = ["unshare", "--net", "sh", "-c", f'{ALONE} && exec "$@"', "sh", *command]
    paths = os.pathsep.join(filter(None, (str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH"))))  # has tests/
    environment = {**os.environ, "TMPDIR": scratch, "PYTHONPATH": paths}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    return _line(process), waiters.submit(_last_line, process)


def _line(process: subprocess.Popen[str]) -> dict[str, Any] | None:
    assert process.stdout is not None
    line = process.stdout.readline()
    return json.loads(line) if line else None


def _last_line(process: subprocess.Popen[str]) -> dict[str, Any] | None:
    with process:
        return _line(process)


def _has_own_network() -> bool:
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return False
    done = subprocess.run(["unshare", "--net", "sh", "-c", ALONE], capture_output=True, check=False)
    return done.returncode == 0


def _row(
    name: str, count: int, joined: dict[str, Any], noticed: list[tuple[float, str]], *, alone: bool
) -> tuple[str, ...]:
    is_radio = HOUSES[name].gateway == "ble"
    size, packets = joined["traffic"]
    return (
        name,
        _percentiles(joined["times"]),
        f"{len(joined['times'])} of {count}",
        _percentiles([seconds for seconds, _ in noticed]),
        f"{len(noticed)} of {len(joined['times'])}",
        "not measured" if is_radio or not alone else f"{size / 1024:.1f} KiB, {packets:.0f} packets",
        f"{joined['memory'] / 1024:.0f} KiB",
    )


def _how(noticed: list[tuple[float, str]]) -> str:
    counts = Counter(how for _, how in noticed)
    return ", ".join(f"{count} {how}" for how, count in counts.most_common()) or "no death was noticed"


def _percentiles(figures: list[float]) -> str:
    if not figures:
        return "-"
    ranked = sorted(figures)
    return " / ".join(_seconds(ranked[min(len(ranked) - 1, int(share * len(ranked)))]) for share in (0.5, 0.95))


def _seconds(figure: float) -> str:
    return f"{figure:.1f} s" if figure >= 1 else f"{figure * 1e3:.0f} ms"
