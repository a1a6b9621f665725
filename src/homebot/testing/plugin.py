"""The pytest plug-in: a real MQTT broker for tests, without configuration, with any asyncio plug-in or none.

Loaded by pytest wherever homebot is installed, so it imports nothing of homebot before a fixture is asked for.
"""

from __future__ import annotations

import sys
from collections.abc import Generator, Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from homebot.testing.mqtt import BlockingTestBroker, BrokerThread, TestBroker

__all__ = ["mqtt_broker", "mqtt_broker_session", "mqtt_broker_thread"]

_MAX_PACKETS_SHOWN = 100


@pytest.fixture
def mqtt_broker(_mqtt_broker_loop: BrokerThread) -> Iterator[TestBroker]:
    """A fresh MQTT broker on a free port of 127.0.0.1, for a test on an asyncio loop."""
    from homebot.testing.mqtt import serve_broker  # noqa: PLC0415 - only for those who use it

    with serve_broker(_mqtt_broker_loop) as broker:
        yield broker


@pytest.fixture(scope="session")
def mqtt_broker_session(_mqtt_broker_loop: BrokerThread) -> Iterator[TestBroker]:
    """An MQTT broker that all tests of the session share."""
    from homebot.testing.mqtt import serve_broker  # noqa: PLC0415 - as above

    with serve_broker(_mqtt_broker_loop) as broker:
        yield broker


@pytest.fixture
def mqtt_broker_thread(_mqtt_broker_loop: BrokerThread) -> Iterator[BlockingTestBroker]:
    """A fresh MQTT broker for a test without a loop; its methods block."""
    from homebot.testing.mqtt import serve_blocking_broker  # noqa: PLC0415 - as above

    with serve_blocking_broker(_mqtt_broker_loop) as broker:
        yield broker


@pytest.fixture(scope="session")
def _mqtt_broker_loop() -> Iterator[BrokerThread]:
    """The thread that all brokers of the session live on."""
    from homebot.testing.mqtt import broker_thread  # noqa: PLC0415 - as above

    with broker_thread() as thread:
        yield thread


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show what the brokers and their clients said when a test fails."""
    report = yield
    if report.failed and report.when == "call" and "homebot.testing.mqtt" in sys.modules:
        for name, text in _packet_logs(item):
            report.sections.append((f"MQTT packets of {name}", text))
    return report


def _packet_logs(item: pytest.Item) -> Iterator[tuple[str, str]]:
    from homebot.testing.mqtt import BlockingTestBroker, TestBroker  # noqa: PLC0415 - as above

    for name, value in getattr(item, "funcargs", {}).items():
        if isinstance(value, TestBroker | BlockingTestBroker):
            text = value.packet_log.text(_MAX_PACKETS_SHOWN)
            if text:
                yield name, text
