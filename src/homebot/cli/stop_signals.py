"""SIGINT and SIGTERM, heard also while the event loop is blocked."""

from __future__ import annotations

import asyncio
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final

__all__ = ["at_stop_signals"]

_STOP_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def at_stop_signals(at_once: Callable[[], None], in_the_loop: Callable[[], None]) -> Iterator[None]:
    """Call both at SIGINT and SIGTERM; to be entered in the main thread, within its event loop.

    Args:
        at_once: Called from any thread, perhaps twice a signal, also while the event loop is blocked.
        in_the_loop: Called by the event loop.
    """
    loop = asyncio.get_running_loop()

    def handle(_number: int, _frame: FrameType | None) -> None:
        at_once()
        loop.call_soon_threadsafe(in_the_loop)

    with _in_a_thread(at_once):
        before = {number: signal.signal(number, handle) for number in _STOP_SIGNALS}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


@contextmanager
def _in_a_thread(at_once: Callable[[], None]) -> Iterator[None]:
    """Call *at_once* in a thread of its own at each of the signals.

    Python runs handlers in the main thread, between two instructions. A call into C that began just before the signal,
    or a signal that another thread took, leaves them waiting until that call returns.
    """
    received, written = socket.socketpair()
    written.settimeout(0)  # as Python asks for: a handler must not wait

    def read() -> None:
        with received:
            while numbers := received.recv(64):
                if not set(_STOP_SIGNALS).isdisjoint(numbers):
                    at_once()

    threading.Thread(target=read, name="signals", daemon=True).start()
    with written:
        before = signal.set_wakeup_fd(written.fileno(), warn_on_full_buffer=False)
        try:
            yield
        finally:
            signal.set_wakeup_fd(before)
