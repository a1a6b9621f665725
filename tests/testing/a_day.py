"""Prints all that happens in a day of the thesis's house; run as a program of its own by test_virtual_house."""

from __future__ import annotations

import asyncio
import sys

import structlog

from homebot.house import thesis_world
from homebot.testing import EventLog, VirtualTimeLoop, virtual_house_of


async def a_day(seed: int) -> str:
    """Also with chance in it: the broker is away for a while, so that everybody's back-off draws lots."""
    async with (
        virtual_house_of("light_service", world=thesis_world(), seed=seed) as house,
        EventLog.of(house) as log,
    ):
        await house.run_until("08:00")
        await house.broker.stop(abrupt=True)
        await house.run_for("17m")
        await house.broker.start()
        await house.run_until("12:00")
        for lamp in ("roomlights405", "roomlights406"):
            await house.says(f"home425/lights/{lamp}/out", "on")
        await house.run_until("00:00")
        return str(log)


if __name__ == "__main__":
    structlog.configure(logger_factory=structlog.PrintLoggerFactory(sys.stderr))
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        sys.stdout.write(runner.run(a_day(int(sys.argv[1]))))
