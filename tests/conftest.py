"""What holds for every test: no task is left behind, and no code of homebot blocks the event loop."""

import asyncio
import functools
import gc
import logging
import os
import re
import shutil
import signal
import sys
from collections.abc import AsyncIterator, Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from subprocess import DEVNULL
from tempfile import TemporaryDirectory

import anyio
import pytest
import pytest_asyncio
import structlog
from blockbuster import blockbuster_ctx
from hypothesis import HealthCheck, settings
from tests.mqtt.client.mosquitto_broker import until_it_answers
from tests.ports import reserve_port
from tests.sizes import EXAMPLES, NIGHTLY
from tests.skips import pytest_sessionfinish, pytest_terminal_summary  # noqa: F401 - hooks of pytest

from homebot.cli.main import gc_paused
from homebot.feature import find_features
from homebot.mqtt.broker import Broker
from homebot.testing import VirtualTimeLoop

# How fast an example is made or runs is no test's business: the machine may be busy.
settings.register_profile("nightly", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("usual", settings.get_profile("nightly"), max_examples=EXAMPLES, derandomize=True)
find_features()  # as a start does before its event loop: their files are read
settings.load_profile("nightly" if NIGHTLY else "usual")

_SLOW = {
    Path(__file__).parent / folder
    for folder in (
        *("bridges/home_api", "bridges/rosbridge", "cli", "days", "mqtt/broker"),
        *(f"gateways/{name}" for name in ("ble", "coap", "drivers", "matter", "mdns", "nfc", "thing_directory")),
        *("packages", "system", "testing"),
    )
}
"""Folders of slow tests: programs, real sockets, whole days and generated cases; so are the contracts of gateways."""


@functools.cache
def _is_slow(path: Path) -> bool:
    return path.name.startswith("test_contract_") or path.parent.name == "fuzz" or not _SLOW.isdisjoint(path.parents)


_HERE = Path(__file__).parent
_SOURCE = _HERE.parent / "src" / "homebot"
_ROOMS = {
    re.compile(r"homebot\.integrations\.([a-z0-9_]+)"): _SOURCE / "integrations",
    re.compile(r"homebot\.features\.([a-z0-9_]+)"): _SOURCE / "features",
    re.compile(r"tests\.features\.([a-z0-9_]+)"): _HERE / "features",
    re.compile(r'tests\.integrations\.([a-z0-9_]+)|"integrations" / "([a-z0-9_]+)'): _HERE / "integrations",
}


_IMPORTED = re.compile(r"^ *(?:from|import) tests\.([\w.]+)", re.MULTILINE)


@functools.cache
def _lacks_a_folder(path: Path) -> bool:
    """Return whether a module of tests, or one that it imports, needs an integration or feature that was taken out."""
    text = path.read_text("utf-8")
    named = (folder / "".join(found.groups("")) for shape, folder in _ROOMS.items() for found in shape.finditer(text))
    if any(not (one.exists() or one.with_suffix(".py").exists()) for one in named):
        return True
    imported = (_HERE.joinpath(*name.split(".")).with_suffix(".py") for name in _IMPORTED.findall(text))
    return any(one.exists() and _lacks_a_folder(one) for one in imported)


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Leave out tests of an integration or feature that was taken out."""
    path = collection_path / "conftest.py" if collection_path.is_dir() else collection_path
    is_ours = path.suffix == ".py" and path.is_relative_to(_HERE) and path.exists()
    return True if is_ours and _lacks_a_folder(path) else None


@functools.cache
def _is_there(name: str) -> bool:
    return any(_SOURCE.glob(f"*/{name}/__init__.py"))


def pytest_itemcollected(item: pytest.Item) -> None:
    named = {name for mark in item.iter_markers("rooms") for name in mark.args}
    if gone := sorted(one for one in named if not _is_there(one)):
        item.add_marker(pytest.mark.skip(reason=f"taken out: {', '.join(gone)}"))
    if _is_slow(item.path):
        item.add_marker(pytest.mark.slow)
    if item.path.parent.name == "peers":
        item.add_marker(pytest.mark.peers)
    if pytest_asyncio.is_async_test(item) and "_watch_tasks" not in item.fixturenames:
        item.fixturenames.insert(0, "_watch_tasks")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "virtual_time: runs on an event loop whose time jumps; no sockets, no threads")
    config.addinivalue_line("markers", "real_time: runs on the usual event loop, among tests of virtual time")
    # A shell lets its background jobs ignore SIGINT, nohup SIGHUP, and programs hand that on to those that they start:
    # ours would not hear the signals of a test.
    for number, handler in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, lambda *_: None)):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, handler)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect without a search for garbage, which takes almost half of the time; later ones leave out all tests.

    They are rarer than usual: at the usual threshold they take a tenth of the processor.
    """
    gc.collect()  # what is garbage now may have something to warn of
    with gc_paused():
        collected = yield
    gc.freeze()
    gc.set_threshold(10_000, 20, 20)
    return collected


def pytest_asyncio_loop_factories(
    config: pytest.Config, item: pytest.Item
) -> Mapping[str, Callable[[], asyncio.AbstractEventLoop]]:
    """Run tests marked ``virtual_time`` on a loop whose time jumps, the others on the real one."""
    if item.get_closest_marker("virtual_time") and not item.get_closest_marker("real_time"):
        return {"virtual": VirtualTimeLoop}
    return {"real": asyncio.SelectorEventLoop}


@pytest.fixture
def pass_time(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Moves the clock of the running event loop forward, also of a real one: what waits for that long is due now.

    What needs sockets or threads, and so real time, waits for events and not for the clock of a busy machine.
    """

    def move(seconds: float) -> None:
        loop = asyncio.get_running_loop()
        before = loop.time
        monkeypatch.setattr(loop, "time", lambda: before() + seconds)

    return move


@pytest.hookimpl(wrapper=True)
def pytest_runtestloop() -> Generator[None, object, object]:
    """Run the tests where code of homebot that blocks the loop is an error, and the user's data is out of reach.

    These are no fixtures, and neither is what goes before each test: each costs time with every one of thousands.
    """
    with blocking_is_an_error(), pytest.MonkeyPatch.context() as patch, TemporaryDirectory() as data:
        patch.setenv("HOMEBOT_DATA", data)  # also where a test starts homebot as a program
        # bumble writes each packet with all fields in colours for its log, which is off: a sixth of a radio's time.
        if hci := sys.modules.get("bumble.hci"):
            patch.setattr(hci.HCI_Object, "format_fields", lambda *_, **__: "")
        return (yield)


@contextmanager
def blocking_is_an_error() -> Iterator[None]:
    with blockbuster_ctx("homebot", excluded_modules=["homebot.testing.gateway_contract"]) as blockbuster:
        for function in blockbuster.functions.values():
            # Start-up: plug-ins and passwords are read before anything is served.
            function.can_block_in(
                "homebot/plugins.py",
                {"_entry_point", "_entry_points", "_own_entry_points", "_load_entry_point", "_load_class"},
            )
            function.can_block_in("homebot/integrations/sensor_libraries/formats.py", {"_libraries"})
            function.can_block_in("homebot/gateways/mqtt/settings.py", {"check_files"})
            function.can_block_in("homebot/support/file_access.py", {"read_secret"})
            function.can_block_in("homebot/messages/interfaces/interfaces.py", {"read_folder"})
            # The tables of languages, 120 kB of ours, are read with the first text of a routine, and the first mistake.
            function.can_block_in("homebot/words/own_language.py", {"_table"})
            function.can_block_in("homebot/words/mistakes.py", {"_table"})
            # The text of a type is read when it is first named, as its module would be: some hundred bytes of ours.
            function.can_block_in("homebot/messages/interfaces/interfaces.py", {"_read"})
            # Not ours: pydantic looks for its plug-ins once, when the first model is built.
            function.can_block_in("pydantic/plugin/_loader.py", {"get_plugins"})
            function.can_block_in("homebot/gateways/coap/aiocoap_client.py", {"_load"})
            # Not ours: OSCORE has its sequence number on the disk before it uses it.
            function.can_block_in("aiocoap/oscore.py", {"_store", "_save", "_destroy", "post_seqnoincrease"})
            # Not ours: a datagram socket is connected, which only looks for a route.
            function.can_block_in("aiocoap/util/asyncio/getaddrinfo_addrconfig.py", {"getaddrinfo_routechecked"})
            # The standard streams may block; in a test, a command of another thread may have wrapped them just now.
            function.can_block_in("homebot/support/output.py", {"write"})
            # Not ours: the tracer that measures coverage, while another thread of the tests has its turn.
            function.can_block_in("coverage/collector.py", {"lock_data"})
        yield


_PLAIN = structlog.dev.ConsoleRenderer(colors=False, exception_formatter=structlog.dev.plain_traceback)


def pytest_runtest_setup() -> None:
    """Let logs be plain, as in production: structlog's default draws tracebacks with rich, which reads files."""
    structlog.reset_defaults()  # a command that ran in the process may have chosen a level
    logging.captureWarnings(capture=False)  # and have taken warnings, which pytest takes back
    structlog.configure(processors=[structlog.processors.add_log_level, _PLAIN])


_PANIC = re.compile(r"^thread '.*panicked at .*", re.MULTILINE)
_OF_ZENOH = re.compile(r"^thread '(net|rx|tx)-.*/zenoh/src/net/routing/dispatcher/(resource|face)\.rs")
"""Where Zenoh 1.10 may panic in threads of its own while a peer leaves (compare its issue 2624): here both ends of
a link close at the same time. If a session that goes on were hit, its later calls would panic elsewhere."""


def panics_in(stderr: str) -> list[str]:
    """Return the panics of Rust that were printed: a thread of a library has ended, and nothing is raised here."""
    return [found for found in _PANIC.findall(stderr) if not _OF_ZENOH.match(found)]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Fail a test with a panic in its output."""
    report = yield
    if report.when == "teardown" and report.passed and (panics := panics_in(report.capstderr)):
        report.outcome, report.longrepr = "failed", "\n".join(panics)
    return report


@pytest.fixture
async def _watch_tasks() -> AsyncIterator[None]:
    before = asyncio.all_tasks()
    yield
    left = asyncio.all_tasks() - before - {asyncio.current_task()}
    if left:
        pytest.fail(f"left behind: {', '.join(sorted(repr(task.get_coro()) for task in left))}")


@pytest.fixture
async def embedded_broker_url() -> AsyncIterator[str]:
    """A fresh embedded broker on a free port."""
    async with Broker() as broker:
        yield broker.url


@pytest.fixture
async def mosquitto_url(tmp_path: Path) -> AsyncIterator[str]:
    """A fresh Mosquitto on a free port; the test is skipped where it is not installed."""
    program = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin:/usr/local/sbin")
    if program is None:
        pytest.skip("mosquitto is not installed")
    port = reserve_port()
    config = tmp_path / "mosquitto.conf"
    config.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    async with await anyio.open_process([program, "-c", str(config)], stdout=DEVNULL, stderr=DEVNULL) as process:
        await until_it_answers(port)
        yield f"mqtt://127.0.0.1:{port}"
        process.terminate()
