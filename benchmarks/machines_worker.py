"""A homebot that is one machine of a house, in a process of its own: ``python machines_worker.py TABLES FOLDER``.

TABLES is its configuration as a JSON object. It carries out one job a line, see :class:`Jobs`.
"""

from __future__ import annotations

import asyncio
import json
import resource
import sys
import time
from pathlib import Path
from typing import Any

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.names import QUERY_DEVICES
from homebot.devices.outcomes import Confirmed
from homebot.devices.query.term_messages import query_terms
from homebot.devices.services import QueryDevices
from homebot.graph import Node
from homebot.log import configure_logging
from homebot.runtime import Runtime
from homebot.words.queries import parse_query
from machines_gateway import Lamps
from rounds import median

__all__: list[str] = []

GAP, LOOK, QUERIES = 0.02, 0.25, 21
"""Seconds between two commands, and between two looks at what was found, which take 30 ms each; queries a figure."""


class Jobs:
    """The jobs of one homebot, each of which returns facts."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._ask = node.create_client(QueryDevices, QUERY_DEVICES)

    async def use(self) -> dict[str, Any]:
        """Return the CPU time and the memory of the process."""
        return {"cpu": time.process_time(), "kilobytes": _kilobytes()}

    async def report(self, seconds: float, rate: int) -> dict[str, Any]:
        """Let the lamps here report."""
        (lamps,) = Lamps.running
        return {"sent": await lamps.report_for(seconds, rate)}

    async def find(self, count: int) -> dict[str, Any]:
        """Wait until *count* lamps are found; return the seconds, and those of a query."""
        began = time.perf_counter()
        while (found := await self._asked("light")) < count:
            await asyncio.sleep(LOOK)
        seconds, took = time.perf_counter() - began, []
        for _ in range(QUERIES):
            asked = time.perf_counter()
            await self._asked("off light and level > 5")
            took.append(time.perf_counter() - asked)
        return {"found": found, "seconds": seconds, "query": median(took)}

    async def turn_on(self, times: int) -> dict[str, Any]:
        """Turn one lamp after the other on, then off; return the seconds of each until its own report confirmed it."""
        took, lamps = [], await Devices(self._node).find(Light)
        for number in range(times):
            rounds, lamp = divmod(number, len(lamps))
            began = time.perf_counter()
            outcome = await (lamps[lamp].turn_off() if rounds % 2 else lamps[lamp].turn_on())
            took.append(time.perf_counter() - began)
            assert isinstance(outcome, Confirmed), outcome
            await asyncio.sleep(GAP)
        return {"took": took}

    async def _asked(self, query: str) -> int:
        return (await self._ask.call(QueryDevices.Request(query=query_terms(parse_query(query)), limit=1))).total


def _kilobytes() -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1])
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


async def main() -> None:
    configure_logging(level="error")
    config = parse_config(json.loads(sys.argv[1]), "machines", Path(sys.argv[2]))
    async with (
        Runtime(config, with_door=False, trusts_apps=True) as runtime,
        Node(runtime.graph, "benchmark") as node,
    ):
        jobs = Jobs(node)
        print(json.dumps({}), flush=True)
        while line := await asyncio.to_thread(sys.stdin.readline):
            asked = json.loads(line)
            print(json.dumps(await getattr(jobs, asked.pop("job"))(**asked)), flush=True)


if __name__ == "__main__":
    asyncio.run(main())
