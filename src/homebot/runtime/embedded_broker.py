"""The broker that homebot brings along, on the usual port or the next free one."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import structlog

from homebot.clock import Clock
from homebot.mqtt.broker import Broker, PortTakenError

__all__ = ["embedded_broker"]

STARTED = "runtime.broker_started"

FIRST_PORT = 1883
LAST_PORT = 1903

_log = structlog.get_logger(node="/homebot")


@asynccontextmanager
async def embedded_broker(clock: Clock) -> AsyncIterator[Broker]:
    """Run the embedded broker on 127.0.0.1, port 1883 or the next free one up to 1903, and say which.

    Raises:
        PortTakenError: All of them are taken.
    """
    broker = await _start(clock)
    async with broker:
        taken = f"; port {FIRST_PORT} was taken" if broker.port != FIRST_PORT else ""
        _log.info(STARTED, message=f"embedded MQTT broker on {broker.url}{taken}", url=broker.url)
        yield broker


async def _start(clock: Clock) -> Broker:
    for port in range(FIRST_PORT, LAST_PORT):
        broker = Broker(port=port, clock=clock)
        try:
            await broker.start()
        except PortTakenError:
            continue
        return broker
    return Broker(port=LAST_PORT, clock=clock)
