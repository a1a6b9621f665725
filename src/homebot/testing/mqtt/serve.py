"""Starts and stops the brokers of tests."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from homebot.testing.mqtt.blocking_broker import BlockingTestBroker
from homebot.testing.mqtt.broker import TestBroker
from homebot.testing.mqtt.core import BrokerCore
from homebot.testing.mqtt.settings import BrokerSettings
from homebot.testing.mqtt.thread import BrokerThread
from homebot.testing.mqtt.tls import TestTls

__all__ = ["serve_blocking_broker", "serve_broker"]

_DEFAULTS = BrokerSettings()


@contextmanager
def serve_broker(
    thread: BrokerThread, settings: BrokerSettings = _DEFAULTS, tls: TestTls | None = None
) -> Iterator[TestBroker]:
    """A fresh broker on *thread*, for tests on an event loop; gone at the end of the block.

    Args:
        thread: Where it lives.
        settings: What it is to be like.
        tls: Needed where *settings* ask for TLS.
    """
    with _core(thread, settings, tls) as core:
        yield TestBroker(core, thread)


@contextmanager
def serve_blocking_broker(
    thread: BrokerThread, settings: BrokerSettings = _DEFAULTS, tls: TestTls | None = None
) -> Iterator[BlockingTestBroker]:
    """As :func:`serve_broker`, for tests that block."""
    with _core(thread, settings, tls) as core:
        yield BlockingTestBroker(core, thread)


@contextmanager
def _core(thread: BrokerThread, settings: BrokerSettings, tls: TestTls | None) -> Iterator[BrokerCore]:
    core = thread.call(_start, settings, tls)
    try:
        yield core
    finally:
        thread.call(_stop, core)


async def _start(settings: BrokerSettings, tls: TestTls | None) -> BrokerCore:
    core = BrokerCore(settings, tls)
    await core.broker.start()
    return core


async def _stop(core: BrokerCore) -> None:
    core.rules.lift_all()
    await core.turn()  # what clients have sent is heard, so that a breach in it is noticed
    await core.broker.stop(abrupt=True)
