"""The pytest fixtures ``house`` and ``homebot``, and their hooks."""

from __future__ import annotations

from asyncio import AbstractEventLoop
from collections.abc import Callable, Generator, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

import pytest

from homebot.testing import pytest_loops as loops
from homebot.testing.pytest_loops import anyio_loop as anyio_loop
from homebot.testing.pytest_loops import own_loop as own_loop
from homebot.testing.pytest_loops import virtual_time as virtual_time

if TYPE_CHECKING:
    from homebot.testing.house import TestHouse
    from homebot.testing.virtual_house import VirtualHouse

_REPORTS = pytest.StashKey[list[Callable[[], tuple[str, str]]]]()
"""Functions for the title and the text about each house of a test."""

_FAILED = pytest.StashKey[bool]()

_OF_REAL_TIME = {"homebot_config": "homebot", loops.BROKERS: "mqtt_broker"}
"""Names of homebot's internal fixtures, and of those for tests."""


@pytest.fixture
def house(request: pytest.FixtureRequest, _homebot_virtual_time: None) -> Iterator[VirtualHouse]:
    """A simulated house in virtual time: ``await house.run_for("8h")``; ``@pytest.mark.house`` describes it."""
    for used, other in _OF_REAL_TIME.items():
        if used in request.fixturenames:
            pytest.fail(
                f"`house` has its own time and broker, `{other}` runs in real time: use only one of them", pytrace=False
            )
    yield from _house_of_test(request, "house", loops.virtual_loop_of)


@pytest.fixture
def homebot(request: pytest.FixtureRequest, homebot_config: object) -> Iterator[TestHouse]:
    """A running homebot with its own broker; ``@pytest.mark.homebot`` names its apps."""
    yield from _house_of_test(request, "homebot", loops.loop_of, homebot_config)


@pytest.fixture
def homebot_config(request: pytest.FixtureRequest) -> object:
    """The configuration of ``homebot``, tables or a file: that of its mark, unless you write your own fixture."""
    from homebot.testing.house_marks import config_of  # noqa: PLC0415 - on first use

    return config_of(request.node)


def pytest_configure(config: pytest.Config) -> None:
    """Register the marks, and the fixtures that need pytest-asyncio if that is installed."""
    config.addinivalue_line(
        "markers",
        "house(*apps, world=…, config=…, root='home425', start='2026-01-01 00:00', seed=0, heartbeat=300): what is in "
        "the fixture `house`: apps, a simulated world (a TOML file, a World, or a function that returns one), and a "
        "configuration (tables or a TOML file); "
        "allow_crashes=True for a test in which an app crashes",
    )
    config.addinivalue_line(
        "markers",
        "homebot(*apps, config=…, root='home425'): what runs in the fixture `homebot`: apps, and a configuration "
        "(tables or a TOML file); allow_crashes=True for a test in which an app crashes",
    )
    if config.pluginmanager.has_plugin(loops.PYTEST_ASYNCIO):
        config.pluginmanager.import_plugin("homebot.testing.pytest_asyncio_loops")


@pytest.hookimpl(wrapper=True)
def pytest_generate_tests(metafunc: pytest.Metafunc) -> Generator[None, None, None]:
    """Choose the loop before other plug-ins generate tests."""
    loops.use_virtual_loop(metafunc)
    yield


def pytest_itemcollected(item: pytest.Item) -> None:
    """Give each test in virtual time its own loop."""
    loops.use_loop_of_its_own(item)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Run a test with one of homebot's fixtures if no other plug-in does."""
    with loops.own_runner(pyfuncitem) as runner:
        if runner is None:
            return None
        names = pyfuncitem._fixtureinfo.argnames  # noqa: SLF001 - as pytest itself does; there is no public way
        runner.run(pyfuncitem.obj(**{name: pyfuncitem.funcargs[name] for name in names}))
    return True


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item) -> Generator[None, None, None]:
    """Close the loop after all fixtures."""
    try:
        yield
    finally:
        loops.close_virtual_loop(item)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show the event logs of a failed test's houses."""
    report = yield
    if report.failed and report.when == "call":
        item.stash[_FAILED] = True
    if report.failed:
        report.sections += [make() for make in item.stash.get(_REPORTS, [])]
    return report


def _house_of_test(
    request: pytest.FixtureRequest, fixture: str, loop_of: Callable[..., AbstractEventLoop], *config: object
) -> Iterator[Any]:
    """Provide the house described by the marks; if the test or an app fails, its report shows the events."""
    from homebot.testing.house_marks import house_of_test  # noqa: PLC0415 - on first use

    test = request.node
    reports = test.stash.setdefault(_REPORTS, [])
    has_failed = partial(test.stash.get, _FAILED, False)  # noqa: FBT003 - as of a dict
    yield from house_of_test(test, fixture, loop_of(request, fixture), reports, has_failed, *config)
    reports.clear()
