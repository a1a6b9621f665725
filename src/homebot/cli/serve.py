"""Serving until Ctrl-C, SIGTERM or the end of the given time, and then stopping in order."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import AbstractAsyncContextManager
from typing import TypeVar

import anyio

from homebot.cli.stop_signals import at_stop_signals
from homebot.cli.watchdog import Watchdog
from homebot.production_loop import ProductionLoop

__all__ = ["on_an_event_loop", "serve"]

Result = TypeVar("Result")


def on_an_event_loop(main: Coroutine[object, object, Result]) -> Result:
    """Run *main* on an event loop of its own, which is watched."""
    with asyncio.Runner(loop_factory=ProductionLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, ProductionLoop)  # noqa: S101 - for the type checker: it was made the line before
        with loop.watch:
            return runner.run(main)


async def serve(
    service: AbstractAsyncContextManager[object],
    seconds: float | None,
    cut_start_short: Callable[[], None] | None = None,
) -> None:
    """Enter *service*, wait for SIGINT, SIGTERM or the end of *seconds*, and leave it.

    Leaving takes 4.8 s at most: then the process is ended with code 1, whatever hangs.

    Args:
        service: Entering means ready, leaving means gone.
        seconds: How long it goes on; None for ever.
        cut_start_short: Called at a signal, so that *service* does not have to finish its start first.
    """
    stop_requested = anyio.Event()

    def stop() -> None:
        stop_requested.set()
        if cut_start_short is not None:
            cut_start_short()

    with Watchdog() as watchdog, at_stop_signals(watchdog.start, stop):
        async with service:
            loop = asyncio.get_running_loop()
            if isinstance(loop, ProductionLoop):
                loop.watch.has_started()
            with anyio.move_on_after(seconds):
                await stop_requested.wait()
            watchdog.start()
