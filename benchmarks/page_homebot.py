"""homebot with its door and a house on MQTT, which watches its own event loop.

``python page_homebot.py PORT`` prints a JSON line with the port of the door once it listens; for each line on its input
it prints the delays of its event loop since the line before: ``p99`` and ``longest`` in milliseconds, and ``cpu`` as a
share of the time.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time

from homebot.cli.serve import short_collections
from homebot.config import parse_config
from homebot.log import configure_logging
from homebot.runtime import Runtime

EVERY = 0.005  # s between two looks at the loop


class Loop:
    """How late the event loop wakes a timer."""

    def __init__(self) -> None:
        self.delays: list[float] = []
        self.since, self.spent = time.perf_counter(), time.process_time()

    async def watch(self) -> None:
        while True:
            due = time.perf_counter() + EVERY
            await asyncio.sleep(EVERY)
            self.delays.append(time.perf_counter() - due)

    def report(self) -> str:
        delays = sorted(self.delays)
        cpu = (time.process_time() - self.spent) / (time.perf_counter() - self.since)
        self.delays = []
        self.since, self.spent = time.perf_counter(), time.process_time()
        p99 = delays[int(0.99 * len(delays))]
        return json.dumps({"p99": 1e3 * p99, "longest": 1e3 * delays[-1], "cpu": cpu})


async def main(port: int) -> None:
    tables = {
        "home": {"name": "bench"},
        "door": {"port": 0},
        "gateways": {"mqtt": {"url": f"mqtt://127.0.0.1:{port}", "act": True}},
    }
    loop = Loop()
    async with Runtime(parse_config(tables, "page_homebot")) as runtime:
        assert runtime.rosbridge is not None
        print(json.dumps({"port": runtime.rosbridge.port}), flush=True)
        watching = asyncio.ensure_future(loop.watch())
        while await asyncio.to_thread(sys.stdin.readline):
            print(loop.report(), flush=True)
        watching.cancel()


configure_logging(level="error")
with short_collections():
    asyncio.run(main(int(sys.argv[1])))
