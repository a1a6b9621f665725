"""The pytest plug-in: a real MQTT broker for tests, without configuration, for any asyncio plug-in or none.

The fixtures for a whole house are in :mod:`homebot.testing.house_fixtures`, which pytest loads with this.

As pytest loads it wherever homebot is installed, it imports homebot only when a fixture is used.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from homebot.testing.mqtt import BlockingTestBroker, TestBroker
    from homebot.testing.mqtt.fixture_brokers import FixtureBrokers

pytest_plugins = ("homebot.testing.house_fixtures",)

_MARK_HELP = (
    "mqtt_broker(user=None, password=None, tls=False, keep_alive=None, refuse_filter=(), limits=None, "
    "allow_protocol_errors=False): what the broker of the fixtures mqtt_broker and mqtt_broker_thread is to be like; "
    "clients that break the protocol fail the test unless that is allowed."
)
_KINDS = (
    "AirConditioner|AlarmPanel|Closure|DoorLock|Fan|Handle|LawnMower|Light|MediaPlayer|Plug|RoboticVacuumCleaner|Siren|Switch"
    "|Thermostat|WaterValve|WindowCovering|_Opening|_Switchable|TestHouse|VirtualHouse|TestBroker"
)
_FORGOTTEN_COMMANDS = (
    f"error:coroutine '({_KINDS})[.].* was never awaited:RuntimeWarning",
    f"error:Exception ignored in. <coroutine object ({_KINDS})[.]:pytest.PytestUnraisableExceptionWarning",
)


def pytest_configure(config: pytest.Config) -> None:
    """Register the mark, also for ``--strict-markers``, and make tests with a step that is not awaited fail."""
    config.addinivalue_line("markers", _MARK_HELP)
    for warning in _FORGOTTEN_COMMANDS:
        config.addinivalue_line("filterwarnings", warning)


@pytest.fixture
def mqtt_broker(request: pytest.FixtureRequest, _mqtt_brokers: FixtureBrokers) -> Iterator[TestBroker]:
    """A new MQTT broker on a free port of 127.0.0.1, for a test on an asyncio loop."""
    with _mqtt_brokers.serve(request.node) as broker:
        yield broker


@pytest.fixture(scope="session")
def mqtt_broker_session(_mqtt_brokers: FixtureBrokers) -> Iterator[TestBroker]:
    """An MQTT broker shared by all tests of the session."""
    with _mqtt_brokers.serve() as broker:
        yield broker


@pytest.fixture
def mqtt_broker_thread(request: pytest.FixtureRequest, _mqtt_brokers: FixtureBrokers) -> Iterator[BlockingTestBroker]:
    """A new MQTT broker for a test without a loop; its methods block."""
    with _mqtt_brokers.serve_blocking(request.node) as broker:
        yield broker


@pytest.fixture(scope="session")
def _mqtt_brokers(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Iterator[FixtureBrokers]:
    """The factory of all brokers of the session, which run in its thread."""
    from homebot.testing.mqtt import fixture_brokers  # noqa: PLC0415 - on first use

    pytestconfig.pluginmanager.register(fixture_brokers)  # its hooks
    with fixture_brokers.FixtureBrokers.running(lambda: tmp_path_factory.mktemp("mqtt_broker_tls")) as brokers:
        yield brokers
