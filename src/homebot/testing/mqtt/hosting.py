"""Starts and stops the brokers of tests."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from homebot.mqtt.broker import BrokerLimits
from homebot.testing.mqtt.blocking_broker import BlockingTestBroker
from homebot.testing.mqtt.broker import TestBroker
from homebot.testing.mqtt.core import BrokerCore
from homebot.testing.mqtt.thread import BrokerThread

__all__ = ["serve_blocking_broker", "serve_broker"]


@contextmanager
def serve_broker(thread: BrokerThread, limits: BrokerLimits | None = None) -> Iterator[TestBroker]:
    """A fresh broker on *thread*, for tests on an event loop; gone at the end of the block."""
    with _core(thread, limits) as core:
        yield TestBroker(core, thread)


@contextmanager
def serve_blocking_broker(thread: BrokerThread, limits: BrokerLimits | None = None) -> Iterator[BlockingTestBroker]:
    """A fresh broker on *thread*, for tests that block; gone at the end of the block."""
    with _core(thread, limits) as core:
        yield BlockingTestBroker(core, thread)


@contextmanager
def _core(thread: BrokerThread, limits: BrokerLimits | None) -> Iterator[BrokerCore]:
    core = thread.call(_start, limits)
    try:
        yield core
    finally:
        thread.call(_stop, core)


async def _start(limits: BrokerLimits | None) -> BrokerCore:
    core = BrokerCore(limits)
    await core.broker.start()
    return core


async def _stop(core: BrokerCore) -> None:
    core.rules.lift_all()
    await core.broker.stop(abrupt=True)
