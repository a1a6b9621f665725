"""A helper process that is given jobs and gives back facts, one JSON line each."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = ["Worker", "worker"]

END_WITHIN = 5.0


class Worker:
    """Speaks with a process that :func:`worker` started.

    Attributes:
        greeting: What it said of itself at the start.
    """

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self.greeting = self.result()

    def start(self, job: str, **facts: Any) -> None:
        """Begin a job; its :meth:`result` must be fetched before the next."""
        assert self._process.stdin is not None
        print(json.dumps({"job": job, **facts}), file=self._process.stdin, flush=True)

    def result(self) -> dict[str, Any]:
        """Wait for the job to end."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self._process.args!r} ended; its error is above")
        answer: dict[str, Any] = json.loads(line)
        return answer


@contextmanager
def worker(script: str, python: Path | str = sys.executable, *arguments: str) -> Iterator[Worker]:
    """Run *script*, a file beside this one, with *python* inside the block; the end of its input asks it to end."""
    command = [str(python), str(Path(__file__).with_name(script)), *arguments]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield Worker(process)
        finally:
            assert process.stdin is not None
            process.stdin.close()
            try:
                process.wait(END_WITHIN)
            except subprocess.TimeoutExpired:
                process.kill()
