"""A simulated device that is served to a client of its maker, a program that prints what it sees."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.simulated.http.served_web_device import ServedWebDevice

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

LAMP = SimulatedDeviceInfo("home", "lamp", "Shelf", "lights", "hall")


@asynccontextmanager
async def served(device: ServedWebDevice) -> AsyncIterator[None]:
    device.begin(DeviceState(text="off", brightness=0.4), has_power=True)
    async with anyio.create_task_group() as tasks:
        await tasks.start(device.serve)
        yield
        tasks.cancel_scope.cancel()


def facts_in(printed: str) -> list[dict[str, object]]:
    """Return what a client printed: one JSON object each line."""
    try:
        return [json.loads(line) for line in printed.splitlines()]
    except ValueError:
        pytest.fail(f"the client printed {printed}")
