"""The event loop of a test: of pytest-asyncio, of anyio's plug-in, or of homebot if neither runs it.

Fixtures of homebot are not coroutines, as their runners differ from test to test: each asks for the loop of its test.
A test in virtual time gets its own :class:`homebot.testing.VirtualTimeLoop`; all others keep theirs.
"""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import Collection, Coroutine, Iterator
from contextlib import contextmanager
from contextvars import Context
from typing import TYPE_CHECKING, NoReturn, TypeVar

import pytest

if TYPE_CHECKING:
    from homebot.support.virtual_time import VirtualTimeLoop

ResultT = TypeVar("ResultT")

VIRTUAL_TIME = "_homebot_virtual_time"
"""The fixture that marks a test as one in virtual time, as others may use names such as ``house``."""

BROKERS = "_mqtt_brokers"
"""The fixture that marks a test as one with an MQTT broker."""

PYTEST_ASYNCIO = "asyncio"
"""The plug-in name of pytest-asyncio."""

RUNNER_FIXTURE = "_function_scoped_runner"
"""The fixture of pytest-asyncio with the runner of a test."""

_CHOOSES_LOOPS = "_asyncio_loop_factory"
"""Available in pytest-asyncio since 1.4, which warns of policies, the only way before."""

_RUNNER = pytest.StashKey[asyncio.Runner]()


@pytest.fixture(name=VIRTUAL_TIME)
def virtual_time() -> None:
    """See :data:`VIRTUAL_TIME`."""


@pytest.fixture(name="_homebot_anyio_loop")
async def anyio_loop(anyio_backend: object) -> asyncio.AbstractEventLoop:  # noqa: ARG001 - selects the backend
    """The loop of a test that anyio's plug-in runs."""
    return asyncio.get_running_loop()


@pytest.fixture(name="_homebot_own_loop")
def own_loop(request: pytest.FixtureRequest) -> Iterator[asyncio.AbstractEventLoop]:
    """The loop of a test without another runner."""
    with asyncio.Runner(loop_factory=_virtual_loop if VIRTUAL_TIME in request.fixturenames else None) as runner:
        request.node.stash[_RUNNER] = runner
        yield runner.get_loop()
        del request.node.stash[_RUNNER]


def loop_of(request: pytest.FixtureRequest, fixture: str) -> asyncio.AbstractEventLoop:
    """Return the loop that runs the test of *request*, which is stopped while fixtures are set up.

    If there is none, the test fails with a message about *fixture*.
    """
    test = request.node
    function = getattr(test, "obj", None)
    hypothesis = getattr(function, "hypothesis", None)
    if not inspect.iscoroutinefunction(function if hypothesis is None else hypothesis.inner_test):
        _fail(f"`{fixture}` needs an async test: write `async def {test.originalname}(…):`")
    if _runs_on_pytest_asyncio(test):
        if "anyio_backend" in request.fixturenames:
            _fail(
                f"`{fixture}` has one loop, but two plug-ins claim this test: pytest-asyncio in its mode `auto`, and "
                "anyio's by a mark or fixture; take the test from one of them"
            )
        return _loop_from(request, f"_homebot_{_loop_scope(test)}_loop")
    if "anyio_backend" not in request.fixturenames:
        return _loop_from(request, "_homebot_own_loop")
    backend = request.getfixturevalue("anyio_backend")
    name = backend if isinstance(backend, str) else backend[0]
    if name != "asyncio":
        _fail(
            f'`{fixture}` runs on asyncio, this test on {name}: write a fixture `anyio_backend` that returns "asyncio"'
        )
    return _loop_from(request, "_homebot_anyio_loop")


def virtual_loop_of(request: pytest.FixtureRequest, fixture: str) -> asyncio.AbstractEventLoop:
    """Return the virtual loop of the test of *request*; the test fails if it has another one."""
    loop = loop_of(request, fixture)
    if not isinstance(loop, _virtual_loop_class()):
        _fail(
            f"`{fixture}` needs a loop of virtual time, and this test runs on a {type(loop).__name__}, which could not "
            "be replaced. Async fixtures of a wider scope keep their loop for all tests: give them the scope "
            '"function"; and do not parametrize anyio_backend or event_loop_policy for this test'
        )
    return loop


@contextmanager
def own_runner(test: pytest.Item) -> Iterator[asyncio.Runner | None]:
    """Create a loop for *test* if it has no other runner and one of homebot's fixtures needs a loop."""
    runner = test.stash.get(_RUNNER, None)
    if runner is None and _is_left_with_a_broker(test):
        with asyncio.Runner() as runner:
            yield runner
    else:
        yield runner


def use_virtual_loop(metafunc: pytest.Metafunc) -> None:
    """Use a virtual loop for the test if its fixtures ask for one, in any runner."""
    if VIRTUAL_TIME not in metafunc.fixturenames:
        return
    if "anyio_backend" in metafunc.fixturenames:
        _parametrize(metafunc, "anyio_backend", ("asyncio", {"loop_factory": _virtual_loop}))
    plugin = metafunc.config.pluginmanager.get_plugin(PYTEST_ASYNCIO)
    if plugin is None:
        return
    _assign_loop(metafunc.definition)
    if hasattr(plugin, _CHOOSES_LOOPS):
        metafunc.fixturenames.append(RUNNER_FIXTURE)
        _parametrize(metafunc, RUNNER_FIXTURE, _VirtualRunner())
    elif "event_loop_policy" in metafunc.fixturenames:
        _parametrize(metafunc, "event_loop_policy", _virtual_policy())


def use_loop_of_its_own(test: pytest.Item) -> None:
    """Keep pytest-asyncio from running a test in virtual time on the loop of a whole module or session."""
    if VIRTUAL_TIME in getattr(test, "fixturenames", ()):
        _assign_loop(test)


def close_virtual_loop(test: pytest.Item) -> None:
    """Close the loop of :func:`use_virtual_loop` after all fixtures of *test*."""
    given = getattr(test, "callspec", None)
    runner = None if given is None else given.params.get(RUNNER_FIXTURE)
    if isinstance(runner, _VirtualRunner):
        runner.close()


class _VirtualRunner:
    """The part of ``asyncio.Runner`` used by pytest-asyncio; opened on first use, and again for a repeated test."""

    def __init__(self) -> None:
        self._runner: asyncio.Runner | None = None

    def get_loop(self) -> asyncio.AbstractEventLoop:
        return self._open().get_loop()

    def run(self, coroutine: Coroutine[object, object, ResultT], *, context: Context | None = None) -> ResultT:
        return self._open().run(coroutine, context=context)

    def close(self) -> None:
        if self._runner is not None:
            self._runner.close()
            self._runner = None

    def _open(self) -> asyncio.Runner:
        if self._runner is None:
            self._runner = asyncio.Runner(loop_factory=_virtual_loop)
        return self._runner


def _virtual_loop_class() -> type[VirtualTimeLoop]:
    from homebot.support.virtual_time import VirtualTimeLoop  # noqa: PLC0415 - on first use

    return VirtualTimeLoop


def _virtual_loop() -> asyncio.AbstractEventLoop:
    return _virtual_loop_class()()


def _virtual_policy() -> asyncio.AbstractEventLoopPolicy:
    """Return the loop policy with virtual loops for pytest-asyncio before 1.4."""

    class Policy(asyncio.DefaultEventLoopPolicy):
        def new_event_loop(self) -> asyncio.AbstractEventLoop:
            return _virtual_loop()

    return Policy()


def _assign_loop(test: pytest.Item) -> None:
    if test.get_closest_marker("asyncio") is not None:
        test.add_marker(pytest.mark.asyncio(loop_scope="function"), append=False)


def _parametrize(metafunc: pytest.Metafunc, fixture: str, value: object) -> None:
    """Set *fixture* to *value* in the test of *metafunc*, unless the test sets it itself."""
    for mark in metafunc.definition.iter_markers("parametrize"):
        names: str | Collection[str] = mark.args[0] if mark.args else mark.kwargs["argnames"]
        if fixture in (names.replace(" ", "").split(",") if isinstance(names, str) else names):
            return
    shown = getattr(pytest, "HIDDEN_PARAM", "virtual")
    metafunc.definition.add_marker(pytest.mark.parametrize(fixture, [value], ids=[shown]))


def _runs_on_pytest_asyncio(test: pytest.Item) -> bool:
    if not test.config.pluginmanager.has_plugin(PYTEST_ASYNCIO):
        return False
    from pytest_asyncio import is_async_test  # noqa: PLC0415 - it is there, but need not be elsewhere

    return is_async_test(test)


def _is_left_with_a_broker(test: pytest.Item) -> bool:
    fixtures = getattr(test, "fixturenames", ())
    is_plain = BROKERS in fixtures and inspect.iscoroutinefunction(getattr(test, "obj", None))
    return is_plain and "anyio_backend" not in fixtures and not _runs_on_pytest_asyncio(test)


def _loop_scope(test: pytest.Item) -> str:
    mark = test.get_closest_marker("asyncio")
    scope = {} if mark is None else mark.kwargs
    return scope.get("loop_scope") or scope.get("scope") or str(test.config.getini("asyncio_default_test_loop_scope"))


def _loop_from(request: pytest.FixtureRequest, fixture: str) -> asyncio.AbstractEventLoop:
    loop = request.getfixturevalue(fixture)
    assert isinstance(loop, asyncio.AbstractEventLoop)  # noqa: S101 - ours
    return loop


def _fail(reason: str) -> NoReturn:
    pytest.fail(reason, pytrace=False)
