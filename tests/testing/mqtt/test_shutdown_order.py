"""The end of a virtual house, in which many tasks are cancelled at once, is the same for the same seed too."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.sizes import size

A_SHUTDOWN = Path(__file__).with_name("a_shutdown.py")
PROCESSES = size(2, 20)


def run(number: int) -> bytes:
    """What one process says; each has other hashes, and its tasks elsewhere in memory."""
    command = [sys.executable, str(A_SHUTDOWN), "7", str(13 * number)]
    environment = {**os.environ, "PYTHONHASHSEED": str(number)}
    return subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout


def test_what_is_said_up_to_the_end_is_the_same_in_every_process() -> None:
    with ThreadPoolExecutor(2) as two_at_a_time:
        said = list(two_at_a_time.map(run, range(PROCESSES)))
    for how in (b"leave", b"raise"):
        end = said[0].partition(b"-- " + how + b"\n")[2].partition(b"broker.stopped")[0]
        assert end.count(b"graph removed") > 20
    assert said == said[:1] * PROCESSES
