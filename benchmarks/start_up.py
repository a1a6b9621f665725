"""Start-up time and memory of a new process, against one that only imports homebot's core packages.

The clock runs from before the process is made until it says that it is ready; memory is the kernel's peak resident
set (``VmHWM``) at that moment. The warm-up round leaves compiled modules, as an installation does.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

from plan import Plan
from report import Aim, Comparison, Report, compare, megabytes, seconds
from rounds import Measure, measure_interleaved

__all__ = ["run"]

CORE = "import aiomqtt, pydantic, anyio, structlog"
PEER = "imports of the four core packages"
IN_USE = "the same in use: one model, one loop"
IMPORT = "import homebot.runtime"

# structlog loads both where they are installed; the command line keeps it from that, so the others go without as well.
ALONE = "import sys; sys.modules.update(rich=None, twisted=None)"

# pydantic imports most of itself when its first model is made, anyio when its first loop runs.
USE = f"""{CORE}
class Model(pydantic.BaseModel):
    field: int
anyio.run(anyio.sleep, 0)"""
RUN = "homebot run, to 'running'"

READY = "ready"
RUNNING = "runtime.running"


def run(plan: Plan) -> Report:
    memory: dict[str, list[float]] = {}
    commands = {PEER: _importing(CORE), IN_USE: _importing(USE), IMPORT: _importing(IMPORT)}
    notes = []
    if importlib.util.find_spec("homebot.__main__") is not None:
        house = ["--house", "thesis", "--door", "127.0.0.1:0"]  # the default house has 25 devices and three apps
        commands[RUN] = [sys.executable, "-m", "homebot", "run", "--log-format", "json", *house]
    else:
        notes.append("`homebot run` is not measured: this version has no command line yet.")
    with tempfile.TemporaryDirectory() as compiled:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        contenders: dict[str, Measure] = {
            name: partial(_start, command, environment, memory.setdefault(name, []))
            for name, command in commands.items()
        }
        samples = measure_interleaved(contenders, plan.rounds(9))
    pairs = [
        (IMPORT, PEER, None),
        (IMPORT, IN_USE, None),
        (RUN, PEER, None),
        (RUN, IN_USE, Aim("at most", 2.2)),
    ]
    comparisons: list[Comparison] = compare("start-up", samples, pairs, seconds)
    comparisons += compare("peak memory", memory, [(ours, peer, None) for ours, peer, _ in pairs], megabytes)
    return Report("Start-up and memory", comparisons, notes)


def _importing(statement: str) -> list[str]:
    return [sys.executable, "-c", f"{ALONE}\n{statement}\nprint({READY!r}, flush=True)\ninput()"]


def _start(command: list[str], environment: dict[str, str], memory: list[float]) -> float:
    started = time.perf_counter()
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment,
        cwd=environment["PYTHONPYCACHEPREFIX"],  # where no homebot.toml of the user is
    ) as process:
        assert process.stdout is not None
        said = []
        for line in process.stdout:
            said.append(line)
            if READY in line or RUNNING in line:
                break
        else:
            raise RuntimeError(f"{command} ended before it was ready:\n{''.join(said)}")
        elapsed = time.perf_counter() - started
        memory.append(_peak_memory(process.pid))
        process.terminate()
        process.stdout.read()
    return elapsed


def _peak_memory(pid: int) -> float:
    """Bytes; 1 where the system has no /proc to tell."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    except OSError:
        return 1.0
    return next(float(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM"))
