"""How long a program takes by itself, on however busy a machine: what it waits for a processor is left out."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from pathlib import Path

__all__ = ["own_time_until_end"]


def own_time_until_end(process: subprocess.Popen[str], within: float = 120.0) -> float:
    """Wait until *process* has ended, without reaping it, and return the seconds that it took from now.

    Without those for which its main thread was ready to go on and others had the processor, as Linux counts them
    (``/proc/PID/schedstat``, the second field); elsewhere with them. It is killed after *within* seconds.
    """
    started, queued = time.monotonic(), _queued(process.pid)
    guard = threading.Timer(within, process.kill)
    guard.start()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
    guard.cancel()
    return time.monotonic() - started - (_queued(process.pid) - queued)


def _queued(pid: int) -> float:
    """Seconds for which the main thread of *pid* waited for a processor."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    except OSError:
        return 0.0
