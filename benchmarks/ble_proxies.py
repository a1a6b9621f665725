"""Processor time of homebot, with its directory, while two Bluetooth proxies tell it of a hundred sensors.

Each sensor is heard by both proxies and sends each content five times. The figure has what an idle homebot takes too.
"""

from __future__ import annotations

import asyncio
import importlib.util
import sys
import time

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.graph import Node
from homebot.runtime import Runtime
from plan import Plan
from report import MissingPeerError, Report, verdict
from worker import worker

__all__ = ["run"]

PER_MINUTE = 20_000
MOST = 0.08
"""Of one core."""

TITLE = f"ble_proxies: share of one core at {PER_MINUTE:,} advertisements a minute"


def run(plan: Plan) -> Report:
    if importlib.util.find_spec("bleak_esphome") is None:
        raise MissingPeerError("homebot[ble-proxies] is not installed")
    with worker("ble_proxies_worker.py", sys.executable, str(PER_MINUTE / 60)) as proxies:
        ports = proxies.greeting["ports"]
        shares = [asyncio.run(measure(ports, 5.0 if plan.quick else 20.0)) for _ in range(plan.rounds(3))]
    rows = [("round", "share of a core", "devices", f"at most {MOST:.0%}")]
    rows += [
        (str(number), f"{share:.1%}", str(devices), verdict(share <= MOST))
        for number, (share, devices) in enumerate(shares, 1)
    ]
    return Report(TITLE, [], table=rows)


async def measure(ports: list[int], seconds: float) -> tuple[float, int]:
    """Return the share of a core that homebot takes, and how many devices it knows."""
    listed = [{"kind": "esphome", "address": "127.0.0.1", "port": port} for port in ports]
    config = parse_config({"home": {"name": "bench"}, "gateways": {"ble": {"proxies": listed}}}, "benchmark")
    async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "asker") as asker:
        await asyncio.sleep(5)
        began, spent = time.perf_counter(), time.process_time()
        await asyncio.sleep(seconds)
        share = (time.process_time() - spent) / (time.perf_counter() - began)
        return share, len(await Devices(asker).find())
