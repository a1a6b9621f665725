"""Threads for work that nothing can cancel, such as that of another's library without time limits."""

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar, final

import anyio

T = TypeVar("T")


@final
class BoundedThreads:
    """At most *most* threads at a time; one that its caller has left counts until it ends, or the program does."""

    def __init__(self, most: int, name: str) -> None:
        self._places = anyio.CapacityLimiter(most)
        self._name = name

    async def run(self, work: Callable[[], T]) -> T:
        """Return the result of *work*, or raise its exception; a cancelled caller leaves it alone."""
        place, loop = object(), asyncio.get_running_loop()
        done: asyncio.Future[T] = loop.create_future()

        def end(result: T | None, error: BaseException | None) -> None:
            self._places.release_on_behalf_of(place)
            if done.done():
                return
            if error is None:
                done.set_result(result)  # type: ignore[arg-type]  # T may be None
            else:
                done.set_exception(error)

        def thread() -> None:
            result, error = None, None
            try:
                result = work()
            except BaseException as exc:  # noqa: BLE001 - raised for the caller
                error = exc
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(end, result, error)

        await self._places.acquire_on_behalf_of(place)
        threading.Thread(target=thread, daemon=True, name=self._name).start()
        return await done
