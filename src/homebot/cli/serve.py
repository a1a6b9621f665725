"""Runs a service until Ctrl-C, SIGTERM or the end of a given time, and then stops it in order."""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Collection, Coroutine, Iterator, Mapping
from contextlib import (
    AbstractAsyncContextManager,
    AbstractContextManager,
    asynccontextmanager,
    contextmanager,
    nullcontext,
)
from types import FrameType, TracebackType
from typing import Final, Self, TypeVar, final

import anyio

from homebot.cli.main import has_terminal
from homebot.support.logger import get_logger
from homebot.support.production_loop import ProductionLoop, own_time

Result = TypeVar("Result")
_HANGUP: Final[signal.Signals | None] = getattr(signal, "SIGHUP", None)  # Windows has none
_STOP_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, *(() if _HANGUP is None else (_HANGUP,)))
_log = get_logger(node="/homebot")

LEFT_BEHIND = "runtime.left_behind"
WARN_AFTER = 4.5
EXIT_AFTER = 4.8
"""Seconds from :meth:`Watchdog.start` to the end of the process: below five, with some margin.

Time does not count in which the process could not run, because the computer slept or was too busy.
"""

_LOOK_EVERY = 0.1

COLLECT_AFTER: Final = (5_000, -1, 10)
"""Thresholds of Python's garbage collector. With the defaults, half of the time to discover ten thousand devices is
spent on it (measured), mostly on permanent objects, and everything else waits.

So it examines each 5,000 new objects once, which takes at most 2 ms: with -1, never together with the 5,000 before, of
which nearly all have come to stay. Each tenth time it examines all that is not frozen, as libraries leave circular
garbage that is not young, such as connections. The longest of these collections took 15 ms of processor time while 300
devices were discovered and 45 ms while they and 20 clients talked, on a busy machine; of 4,000 devices 17 ms and, when
nearly all values had changed since, 100 ms; of 10,000 75 ms. Discovery took 4 to 7 % more."""

_OLDEST: Final = 2
_GROWN: Final = 1.1
"""What survives such a collection is frozen, and not examined again, if Python's memory has grown by a tenth since the
last time, as when a house is discovered. What is in use then, and circular garbage later, is never freed: without that
condition, more and more where much comes and goes."""

_SWITCH_EVERY: Final = 0.001
"""Seconds for which a thread that works keeps the interpreter, each time that the event loop has looked at the network:
by default 5 ms, so an answer of ten turns came 50 ms later."""


def on_an_event_loop(main: Coroutine[object, object, Result]) -> Result:
    """Run *main* on its own event loop, which is watched."""
    sys.setswitchinterval(_SWITCH_EVERY)
    with short_collections(), asyncio.Runner(loop_factory=ProductionLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, ProductionLoop)  # noqa: S101 - for the type checker: it was made the line before
        with loop.watch:
            return runner.run(main)


@contextmanager
def short_collections() -> Iterator[None]:
    """Keep garbage collections short during the block, in the whole process."""
    before, freezer = gc.get_threshold(), _Freezer()
    gc.set_threshold(*COLLECT_AFTER)
    gc.callbacks.append(freezer)
    try:
        yield
    finally:
        gc.callbacks.remove(freezer)
        gc.set_threshold(*before)


class _Freezer:
    """A callback of the garbage collector that exempts from it what has come to stay."""

    def __init__(self) -> None:
        self._blocks = 0

    def __call__(self, phase: str, info: Mapping[str, int]) -> None:
        if phase == "stop" and info["generation"] == _OLDEST and sys.getallocatedblocks() > _GROWN * self._blocks:
            gc.freeze()
            self._blocks = sys.getallocatedblocks()


async def serve(
    service: AbstractAsyncContextManager[object],
    seconds: float | None,
    cut_start_short: Callable[[], None] | None = None,
    reload: Callable[[], Awaitable[object]] | None = None,
    until: Callable[[], Awaitable[None]] | None = None,
) -> bool:
    """Enter *service*, wait for SIGINT, SIGTERM or the end of *seconds*, leave it, and return whether they were over.

    Leaving takes at most 4.8 s: then the process is ended with code 1 in any case. The service manager that started the
    process, if any, is notified.

    Args:
        service: Entering means ready, leaving means gone.
        seconds: How long to run; None for no limit.
        cut_start_short: Called at a signal, so that *service* does not have to finish its start first.
        until: Runs concurrently; the service is left when it returns.
        reload: Called at SIGHUP; without it, or when the terminal of the process is closed, SIGHUP stops too.
    """
    requests = _Requests(cut_start_short)
    on_hangup = None if reload is None else requests.reload
    with Watchdog() as watchdog, _at_stop_signals(watchdog.start, requests.stop, on_hangup):
        async with service, _service_manager() as reloading:
            loop = asyncio.get_running_loop()
            if isinstance(loop, ProductionLoop):
                loop.watch.has_started()
            async with anyio.create_task_group() as tasks:
                if until is not None:
                    tasks.start_soon(_stop_after, until, requests)
                with anyio.move_on_after(seconds) as time:
                    while await requests.wait() and reload is not None:
                        with reloading():
                            await reload()
                watchdog.start()
                tasks.cancel_scope.cancel()
    return time.cancelled_caught


async def _stop_after(until: Callable[[], Awaitable[None]], requests: _Requests) -> None:
    await until()
    requests.stop()


@asynccontextmanager
async def _service_manager() -> AsyncIterator[Callable[[], AbstractContextManager[None]]]:
    if "NOTIFY_SOCKET" not in os.environ:
        yield nullcontext
        return
    from homebot.cli.service_manager import service_manager  # noqa: PLC0415 - for a service alone

    async with service_manager() as manager:
        yield manager.reloading


class _Requests:
    """The pending signals, in the event loop."""

    def __init__(self, cut_start_short: Callable[[], None] | None) -> None:
        self._cut_start_short = cut_start_short
        self._has_some = anyio.Event()
        self._is_stopping = False

    def stop(self) -> None:
        """Request the end."""
        self._is_stopping = True
        self._has_some.set()
        if self._cut_start_short is not None:
            self._cut_start_short()

    def reload(self) -> None:
        """Request a reload."""
        self._has_some.set()

    async def wait(self) -> bool:
        """Wait for a request; return True for a reload, False for the end."""
        await self._has_some.wait()
        self._has_some = anyio.Event()
        return not self._is_stopping


@contextmanager
def _at_stop_signals(
    at_once: Callable[[], None], in_the_loop: Callable[[], None], on_hangup: Callable[[], None] | None
) -> Iterator[None]:
    """Call both at stop signals; must be entered in the main thread, within its event loop.

    An ignored signal stops nothing, such as a hangup under ``nohup``.

    Args:
        at_once: Called from any thread, perhaps twice per signal, even while the event loop is blocked.
        in_the_loop: Called by the event loop.
        on_hangup: Called by the event loop instead of both at a SIGHUP that does not come from a closed terminal.
    """
    loop = asyncio.get_running_loop()
    had_terminal = has_terminal()
    ignored = {number for number in _STOP_SIGNALS if signal.getsignal(number) is signal.SIG_IGN}

    def handle(number: int, _frame: FrameType | None) -> None:
        if number == _HANGUP and on_hangup is not None and (number in ignored or had_terminal == has_terminal()):
            loop.call_soon_threadsafe(on_hangup)
            return
        at_once()
        if number == _HANGUP:
            loop.call_soon_threadsafe(_log_hangup)
        loop.call_soon_threadsafe(in_the_loop)

    wanted = [
        stop_signal
        for stop_signal in _STOP_SIGNALS
        if stop_signal not in ignored or (stop_signal == _HANGUP and on_hangup is not None)
    ]
    with _in_a_thread([stop_signal for stop_signal in wanted if stop_signal != _HANGUP], at_once):
        before = {number: signal.signal(number, handle) for number in wanted}
        if _HANGUP is not None:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {_HANGUP})  # one may have waited since the start
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


@contextmanager
def _in_a_thread(wanted: Collection[int], at_once: Callable[[], None]) -> Iterator[None]:
    """Call *at_once* in its own thread at each of the *wanted* signals.

    Python runs handlers in the main thread, between two instructions. A C call that began just before the signal, or a
    signal delivered to another thread, delays them until that call returns.
    """
    received, written = socket.socketpair()
    written.settimeout(0)  # required by Python: a handler must not block

    def read() -> None:
        with received:
            while numbers := received.recv(64):
                if not set(wanted).isdisjoint(numbers):
                    at_once()

    threading.Thread(target=read, name="signals", daemon=True).start()
    with written:
        before = signal.set_wakeup_fd(written.fileno(), warn_on_full_buffer=False)
        try:
            yield
        finally:
            signal.set_wakeup_fd(before)


def _log_hangup() -> None:
    _log.warning("runtime.hangup", message="SIGHUP was received: homebot stops")


@final
class Watchdog:
    """``with Watchdog() as watchdog``: once started, it gives the block 4.8 s more and then ends the process.

    It runs in its own threads, so that neither a blocked event loop nor a terminal that accepts no more text keeps the
    process alive.
    """

    def __init__(self) -> None:
        self._over = threading.Event()
        actions = ((WARN_AFTER, _warn), (EXIT_AFTER, _exit))
        self._threads = [
            threading.Thread(target=self._run, args=action, name="watchdog", daemon=True) for action in actions
        ]
        self._is_started = False
        self._lock = threading.RLock()  # reentrant, because a signal may interrupt a start

    def start(self) -> None:
        """Start the time; idempotent, and safe in signal handlers and any thread."""
        with self._lock:
            if self._is_started:
                return
            self._is_started = True
            for thread in self._threads:
                thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._over.set()

    def _run(self, seconds: float, act: Callable[[], None]) -> None:
        left, looked, used = seconds, time.monotonic(), time.process_time()
        while left > 0:
            wait = min(left, _LOOK_EVERY)
            if self._over.wait(wait):
                return
            before, looked = looked, time.monotonic()
            used_before, used = used, time.process_time()
            left -= own_time(looked - before, used - used_before, wait)
        act()


def _warn() -> None:
    _log.critical(LEFT_BEHIND, message="not everything stopped in time; exiting anyway")


def _exit() -> None:
    os._exit(1)
