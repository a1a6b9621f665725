"""Prints all that happens in a day of a house; run as a program by tests, as ``a_day.py thesis|family SEED``."""

import asyncio
import sys
import tomllib
from pathlib import Path

import structlog

from homebot.house import thesis_world
from homebot.house.description import parse_world
from homebot.testing import EventLog, VirtualTimeLoop, virtual_house_of

FAMILY = tomllib.loads((Path(__file__).parents[2] / "examples" / "houses" / "family.toml").read_text("utf-8"))


async def thesis(seed: int) -> str:
    """Also with chance in it: the broker is away for a while, so that everybody's back-off draws lots."""
    async with (
        virtual_house_of("light_service", world=thesis_world(), seed=seed) as house,
        EventLog.of(house) as log,
    ):
        await house.run_until("00:40")
        await house.broker.stop(abrupt=True)
        await house.run_for("17m")
        await house.broker.start()
        await house.run_until("01:30")
        for lamp in ("roomlights405", "philips165"):
            await house.press(lamp, "on")
        await house.run_until("03:00")
        return str(log)


async def family(seed: int) -> str:
    """The log, and behind it what the world itself wrote down."""
    world = parse_world(FAMILY, "family.toml", seed=seed)
    async with (
        virtual_house_of("light_service", world=world, seed=seed) as house,
        EventLog.of(house) as log,
    ):
        await house.run_for("1d")
        return f"{log}{world.event_log.text()}"


if __name__ == "__main__":
    structlog.configure(logger_factory=structlog.PrintLoggerFactory(sys.stderr))
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        day = runner.run({"thesis": thesis, "family": family}[sys.argv[1]](int(sys.argv[2])))
    # With PYTHONUNBUFFERED set, sys.stdout drops the rest of what a pipe takes only in part.
    with open(sys.stdout.fileno(), "w", encoding="utf-8", closefd=False) as out:
        out.write(day)
