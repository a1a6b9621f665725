"""How long a program takes by itself, on however busy a machine: what it waits for a processor is left out."""

import os
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

_TICK = 0.02


@contextmanager
def own_time(pid: int) -> Iterator[Callable[[], float]]:
    """Yield what returns the seconds since the block began, as the program *pid* would have seen them alone.

    Without those for which its main thread was ready to go on and others had the processor, as Linux counts them
    (``/proc/PID/schedstat``, the second field), or without those in which this program got nothing done either, as the
    whole machine stood still: the more of the two.
    """
    started, queued, stood_still = time.monotonic(), _queued(pid), 0.0
    is_over = threading.Event()

    def watch() -> None:
        nonlocal stood_still
        while not is_over.is_set():
            before = time.monotonic()
            is_over.wait(_TICK)
            stood_still += max(0.0, time.monotonic() - before - 5 * _TICK)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield lambda: time.monotonic() - started - max(stood_still, _queued(pid) - queued)
    finally:
        is_over.set()
        thread.join()


def own_time_until_end(process: subprocess.Popen[str], within: float = 120.0) -> float:
    """Wait until *process* has ended, without reaping it, and return the :func:`own_time` that it took from now.

    It is killed after *within* seconds.
    """
    started = time.monotonic()
    with own_time(process.pid) as seconds:
        while os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG) is None:
            time.sleep(_TICK)
            if time.monotonic() - started > within:
                process.kill()
        return seconds()


def _queued(pid: int) -> float:
    """Seconds for which the main thread of *pid* waited for a processor."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    except OSError:
        return 0.0
