"""The pytest plug-in: a real MQTT broker for tests, without configuration, with any asyncio plug-in or none.

The fixtures for a whole house are in :mod:`homebot.testing.house_fixtures`, which pytest loads with this.

Loaded by pytest wherever homebot is installed, so it imports nothing of homebot before a fixture is asked for.
"""

from __future__ import annotations

import sys
from collections.abc import Generator, Iterator
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from homebot.testing.mqtt import BlockingTestBroker, BrokerSettings, BrokerThread, TestBroker, TestTls

__all__ = ["mqtt_broker", "mqtt_broker_session", "mqtt_broker_thread"]

pytest_plugins = ("homebot.testing.house_fixtures",)

_MAX_PACKETS_SHOWN = 100
_MARK = "mqtt_broker"
_MARK_HELP = (
    "mqtt_broker(user=None, password=None, tls=False, keep_alive=None, refuse_filter=(), limits=None, "
    "allow_protocol_errors=False): what the broker of the fixtures mqtt_broker and mqtt_broker_thread is to be like; "
    "clients that break the protocol fail the test unless that is allowed."
)
_KINDS = (
    "AirConditioner|AlarmPanel|Closure|DoorLock|Fan|Handle|LawnMower|Light|Plug|RoboticVacuumCleaner|Siren|Switch"
    "|Thermostat|WaterValve|WindowCovering|_Opening|_Switchable"
)
_FORGOTTEN_COMMANDS = (
    f"error:coroutine '({_KINDS})[.].* was never awaited:RuntimeWarning",
    f"error:Exception ignored in. <coroutine object ({_KINDS})[.]:pytest.PytestUnraisableExceptionWarning",
)
_shown = pytest.StashKey[bool]()


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark, also for ``--strict-markers``, and fail tests with a command that is never awaited."""
    config.addinivalue_line("markers", _MARK_HELP)
    for warning in _FORGOTTEN_COMMANDS:
        config.addinivalue_line("filterwarnings", warning)


@pytest.fixture
def mqtt_broker(request: pytest.FixtureRequest, _mqtt_broker_loop: BrokerThread) -> Iterator[TestBroker]:
    """A fresh MQTT broker on a free port of 127.0.0.1, for a test on an asyncio loop."""
    from homebot.testing.mqtt import serve_broker  # noqa: PLC0415 - on first use

    settings = _settings(request.node)
    with serve_broker(_mqtt_broker_loop, settings, _tls(request, settings)) as broker:
        yield broker


@pytest.fixture(scope="session")
def mqtt_broker_session(_mqtt_broker_loop: BrokerThread) -> Iterator[TestBroker]:
    """An MQTT broker that all tests of the session share."""
    from homebot.testing.mqtt import serve_broker  # noqa: PLC0415 - as above

    with serve_broker(_mqtt_broker_loop) as broker:
        yield broker


@pytest.fixture
def mqtt_broker_thread(request: pytest.FixtureRequest, _mqtt_broker_loop: BrokerThread) -> Iterator[BlockingTestBroker]:
    """A fresh MQTT broker for a test without a loop; its methods block."""
    from homebot.testing.mqtt import serve_blocking_broker  # noqa: PLC0415 - as above

    settings = _settings(request.node)
    with serve_blocking_broker(_mqtt_broker_loop, settings, _tls(request, settings)) as broker:
        yield broker


@pytest.fixture(scope="session")
def _mqtt_broker_loop() -> Iterator[BrokerThread]:
    """The thread that all brokers of the session live on."""
    from homebot.testing.mqtt import broker_thread  # noqa: PLC0415 - as above

    with broker_thread() as thread:
        yield thread


@pytest.fixture(scope="session")
def _mqtt_broker_tls(tmp_path_factory: pytest.TempPathFactory) -> TestTls:
    """The certificate that all brokers of the session show, where a test asks for TLS."""
    from homebot.testing.mqtt import TestTls  # noqa: PLC0415 - as above

    return TestTls.make(tmp_path_factory.mktemp("mqtt_broker_tls"), datetime.now(UTC))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, None, None]:
    """Fail the test after its fixtures if its client violated the protocol."""
    try:
        yield
    finally:
        if "homebot.testing.mqtt" in sys.modules:
            _check_protocol(item)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show the packets of brokers and their clients when a test fails."""
    report = yield
    is_due = report.failed and report.when != "setup" and _shown not in item.stash
    if is_due and "homebot.testing.mqtt" in sys.modules:
        item.stash[_shown] = True
        for name, text in _packet_logs(item):
            report.sections.append((f"MQTT packets of {name}", text))
    return report


def _packet_logs(item: pytest.Item) -> Iterator[tuple[str, str]]:
    for name, broker in _brokers(item):
        text = broker.packet_log.text(_MAX_PACKETS_SHOWN)
        if text:
            yield name, text


def _check_protocol(item: pytest.Item) -> None:
    problems = []
    for name, broker in _brokers(item):
        problems += [f"{name}: {each}" for each in broker.protocol_errors]
        broker.forget_protocol_errors()  # a shared broker starts its next test clean
    if problems and not _settings(item).allow_protocol_errors:
        hint = "to allow it, mark the test with @pytest.mark.mqtt_broker(allow_protocol_errors=True)"
        pytest.fail("\n".join([*problems, hint]), pytrace=False)


def _brokers(item: pytest.Item) -> Iterator[tuple[str, TestBroker | BlockingTestBroker]]:
    from homebot.testing.mqtt import BlockingTestBroker, TestBroker  # noqa: PLC0415 - as above

    for name, value in getattr(item, "funcargs", {}).items():
        if isinstance(value, TestBroker | BlockingTestBroker):
            yield name, value


def _settings(item: pytest.Item) -> BrokerSettings:
    """Collect the settings of a test's marks; the nearest counts most."""
    from homebot.errors import UsageError  # noqa: PLC0415 - as above
    from homebot.testing.mqtt import BrokerSettings  # noqa: PLC0415 - as above

    arguments: dict[str, object] = {}
    for mark in item.iter_markers(_MARK):
        if mark.args:
            pytest.fail(f"@pytest.mark.{_MARK}: name the arguments, as in keep_alive=5", pytrace=False)
        arguments = {**mark.kwargs, **arguments}
    try:
        return BrokerSettings.parse(arguments)
    except UsageError as error:
        pytest.fail(f"@pytest.mark.{_MARK}: {error}", pytrace=False)


def _tls(request: pytest.FixtureRequest, settings: BrokerSettings) -> TestTls | None:
    return request.getfixturevalue("_mqtt_broker_tls") if settings.tls else None
