"""The brokers of the fixtures: their settings from marks, and their records of a test.

A plug-in of pytest, registered with the first of them.
"""

from collections.abc import Callable, Generator, Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Final, Self, final

import pytest

from homebot.errors import UsageError
from homebot.testing.mqtt.broker import BlockingTestBroker, BrokerT, TestBroker, serve_broker
from homebot.testing.mqtt.settings import BrokerSettings, TestTls
from homebot.testing.mqtt.thread import BrokerThread, broker_thread

_MARK: Final = "mqtt_broker"
_MAX_PACKETS_SHOWN: Final = 100
_SHOWN = pytest.StashKey[bool]()


@final
class FixtureBrokers:
    """The factory of the brokers of a session.

    Args:
        make_folder: Creates a folder for their certificate, for tests with TLS.
    """

    def __init__(self, thread: BrokerThread, make_folder: Callable[[], Path]) -> None:
        self._thread = thread
        self._make_folder = make_folder

    @classmethod
    @contextmanager
    def running(cls, make_folder: Callable[[], Path]) -> Iterator[Self]:
        """Run the thread of the brokers during the block."""
        with broker_thread() as thread:
            yield cls(thread, make_folder)

    def serve(self, test: pytest.Item | None = None) -> AbstractContextManager[TestBroker]:
        """Run a new broker during the block, as described by the marks of *test*."""
        return self._serve(TestBroker, test)

    def serve_blocking(self, test: pytest.Item) -> AbstractContextManager[BlockingTestBroker]:
        """Run a broker like :meth:`serve`, for a blocking test."""
        return self._serve(BlockingTestBroker, test)

    def _serve(self, kind: type[BrokerT], test: pytest.Item | None) -> AbstractContextManager[BrokerT]:
        settings = BrokerSettings() if test is None else _settings(test)
        return serve_broker(self._thread, kind, settings, self._tls if settings.tls else None)

    @cached_property
    def _tls(self) -> TestTls:
        return TestTls.make(self._make_folder(), datetime.now(UTC))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, None, None]:
    """Fail the test after its fixtures if its client violated the protocol."""
    try:
        yield
    finally:
        problems = []
        for name, broker in _brokers(item):
            problems += [f"{name}: {error}" for error in broker.protocol_errors]
            broker.forget_protocol_errors()  # so that a shared broker starts its next test clean
        if problems and not _settings(item).allow_protocol_errors:
            hint = "to allow it, mark the test with @pytest.mark.mqtt_broker(allow_protocol_errors=True)"
            pytest.fail("\n".join([*problems, hint]), pytrace=False)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show the packets of brokers and their clients when a test fails."""
    report = yield
    if report.failed and report.when != "setup" and _SHOWN not in item.stash:
        item.stash[_SHOWN] = True
        logs = ((name, broker.packet_log.text(_MAX_PACKETS_SHOWN)) for name, broker in _brokers(item))
        report.sections += [(f"MQTT packets of {name}", text) for name, text in logs if text]
    return report


def _brokers(test: pytest.Item) -> Iterator[tuple[str, TestBroker | BlockingTestBroker]]:
    for name, value in getattr(test, "funcargs", {}).items():
        if isinstance(value, TestBroker | BlockingTestBroker):
            yield name, value


def _settings(test: pytest.Item) -> BrokerSettings:
    arguments: dict[str, object] = {}
    for mark in test.iter_markers(_MARK):
        if mark.args:
            pytest.fail(f"@pytest.mark.{_MARK}: name the arguments, as in keep_alive=5", pytrace=False)
        arguments = {**mark.kwargs, **arguments}
    try:
        return BrokerSettings.parse(arguments)
    except UsageError as error:
        pytest.fail(f"@pytest.mark.{_MARK}: {error}", pytrace=False)
