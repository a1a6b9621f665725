"""The event loop of a homebot in production: one that is watched, and that no stray ``sys.exit()`` stops."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from typing import Any, TypeVar, final

from homebot.loop_watch import LoopWatch, WatchedSelector

__all__ = ["ProductionLoop"]

T = TypeVar("T")


@final
class ProductionLoop(asyncio.SelectorEventLoop):
    """A selector loop on every platform, as the MQTT client needs ``add_reader``.

    asyncio lets a SystemExit of any task stop the loop. Here it ends that task alone, unless the loop runs for it.

    Attributes:
        watch: Tells what blocks the loop, once it is entered.
    """

    def __init__(self) -> None:
        selector = WatchedSelector()
        super().__init__(selector)
        self.watch = LoopWatch(self, selector)
        self._main: asyncio.Future[Any] | None = None  # of whatever it is that the loop runs for

    def run_until_complete(self, future: Awaitable[T]) -> T:  # type: ignore[override]  # typeshed knows two kinds of it
        """As of any loop."""
        main = asyncio.ensure_future(future, loop=self)
        before, self._main = self._main, main
        try:
            return super().run_until_complete(main)
        finally:
            self._main = before

    def run_forever(self) -> None:
        """As of any loop; a SystemExit of a task that is not the main one is recorded."""
        while True:
            try:
                super().run_forever()
            except SystemExit as exc:
                if self._main is None or (self._main.done() and self._main.exception() is exc):
                    raise
                self.watch.record_exit(exc)
                if self._main.done():
                    return
            else:
                return
