"""Runs inside Home Assistant's venv: measures its event bus and its services.

Each line of standard input is a job, each line of standard output its figure. Nothing of homebot is imported.
"""

from __future__ import annotations

import asyncio
import inspect
import json
import logging
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

from homeassistant.const import __version__
from homeassistant.core import Event, HomeAssistant, ServiceCall, callback

EVENT = "reading"


async def deliver(hass: HomeAssistant, job: dict[str, Any]) -> float:
    """Fire events to many listeners; return deliveries per second.

    The burst's listeners run before the next burst, as for every other contender.
    """
    messages, burst, count = job["messages"], job["burst"], 0

    async def on_event(_event: Event) -> None:
        nonlocal count
        count += 1

    @callback
    def on_event_now(_event: Event) -> None:
        nonlocal count
        count += 1

    fastest = (
        {"run_immediately": True} if "run_immediately" in inspect.signature(hass.bus.async_listen).parameters else {}
    )
    cancels: list[Callable[[], None]] = [
        hass.bus.async_listen(EVENT, on_event)
        if job["kind"] == "async"
        else hass.bus.async_listen(EVENT, on_event_now, **fastest)
        for _ in range(job["listeners"])
    ]
    data = {"sensor": "kitchen", "celsius": 21.5, "sequence": 7}
    fire, wanted = hass.bus.async_fire, 0
    built = job["built"]
    started = time.perf_counter()
    for _ in range(messages // burst):
        if built:
            for number in range(burst):
                fire(EVENT, {"sensor": "kitchen", "celsius": 21.5, "sequence": number})
        else:
            for _ in range(burst):
                fire(EVENT, data)
        wanted += burst * job["listeners"]
        while count < wanted:
            await asyncio.sleep(0)
    elapsed = time.perf_counter() - started
    for cancel in cancels:
        cancel()
    return count / elapsed


async def call(hass: HomeAssistant, job: dict[str, Any]) -> float:
    """Call a service and wait for it, many times in a row; return calls per second."""
    count = 0

    async def on_call(_call: ServiceCall) -> None:
        nonlocal count
        count += 1

    @callback
    def on_call_now(_call: ServiceCall) -> None:
        nonlocal count
        count += 1

    hass.services.async_register("bench", "add", on_call if job["kind"] == "async" else on_call_now)
    await asyncio.sleep(0)
    async_call, data = hass.services.async_call, {"a": 1, "b": 2}
    started = time.perf_counter()
    for _ in range(job["calls"]):
        await async_call("bench", "add", data, blocking=True)
    elapsed = time.perf_counter() - started
    if count != job["calls"]:
        raise RuntimeError(f"{count} of {job['calls']} calls were served")
    return count / elapsed


async def main() -> None:
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    print(json.dumps({"version": __version__}), flush=True)
    with tempfile.TemporaryDirectory() as directory:
        hass = HomeAssistant(directory)
        for line in sys.stdin:  # blocks the loop between two jobs, when nothing runs on it
            job = json.loads(line)
            figure = await {"deliver": deliver, "call": call}[job["job"]](hass, job)
            print(json.dumps({"per_second": figure}), flush=True)


asyncio.run(main())
