"""Commands against a running homebot with a large house, against a client that only asks the same and prints it.

The house is the one of ``ingest``: configs of lamps that a Mosquitto kept. Each figure is of a process of its own,
from its start to its end.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from websockets.sync.client import ClientConnection, connect

from bench_ingest import seed
from mosquitto import mosquitto
from plan import Plan
from report import Aim, MissingPeerError, Report, compare, seconds, verdict
from rounds import Measure, Samples, measure_interleaved

__all__ = ["run"]

DEVICES = 4478
PAGE = 200
TITLE = f"Commands against a running homebot that knows {DEVICES:,} devices"
TOPICS, LIST = "homebot topic list", "homebot devices --json"
ASKS, ASKS_ALL = "websockets, one call", "websockets, all pages"
WANTED = {TOPICS: 0.2, LIST: 1.0}
STALL = 0.05

BARE = """import json, sys
from websockets.sync.client import connect
def call(service, **args):
    link.send(json.dumps({"op": "call_service", "service": service, "args": args}))
    return json.loads(link.recv())["values"]
with connect(sys.argv[1], proxy=None, max_size=None, compression=None) as link:
"""
PEERS = {
    ASKS: BARE + '    print(json.dumps(call("/rosapi/endpoints")))',
    ASKS_ALL: BARE
    + f"""    for offset in range(0, {DEVICES}, {PAGE}):
        print(json.dumps(call("/discovery/query", query="", offset=offset, limit={PAGE})))""",
}


def run(plan: Plan) -> Report:
    if plan.mosquitto is None:
        raise MissingPeerError("Mosquitto is not installed")
    stalls: list[float] = []
    with tempfile.TemporaryDirectory() as compiled, mosquitto(plan.mosquitto) as port:
        environment = {**os.environ, "PYTHONPYCACHEPREFIX": compiled}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        seed(port, DEVICES)
        with _homebot(port, environment) as url:
            door = url.removeprefix("ws://").rstrip("/")
            contenders: dict[str, Measure] = {}
            for name in WANTED:
                command = [sys.executable, "-m", "homebot", "--door", door, *name.split()[1:]]
                contenders[name] = partial(_timed, command, environment)
            for name, code in PEERS.items():
                command = [sys.executable, "-c", code, url]
                contenders[name] = partial(_timed, command, environment)
            samples = measure_interleaved(contenders, plan.rounds(9))
            with _waiting(url, stalls):
                _timed([sys.executable, "-m", "homebot", "--door", door, *LIST.split()[1:]], environment)
    pairs = [(TOPICS, ASKS, Aim("at most", 1.3)), (LIST, ASKS_ALL, Aim("at most", 2))]
    return Report(TITLE, compare("until it ends", samples, pairs, seconds), [*_notes(samples), _stall(stalls)])


@contextmanager
def _homebot(broker: int, environment: dict[str, str]) -> Iterator[str]:
    """Run a homebot that follows the broker, and give the address of its rosbridge server once it knows all."""
    command = [sys.executable, "-m", "homebot", "run", "--mqtt", f"mqtt://127.0.0.1:{broker}", "--ephemeral"]
    command += ["--log-format", "json", "--door", "127.0.0.1:0"]
    folder = environment["PYTHONPYCACHEPREFIX"]  # where no homebot.toml of the user is
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment, cwd=folder) as process:
        try:
            assert process.stderr is not None
            url = next(found[0] for line in process.stderr if (found := re.search(r"ws://[\w.:]+", line)))
            threading.Thread(target=process.stderr.read, daemon=True).start()
            with connect(url, proxy=None) as link:
                while _call(link, "/discovery/query", query="", offset=0, limit=1)["total"] < DEVICES:
                    time.sleep(0.1)
            yield url
        finally:
            process.terminate()


@contextmanager
def _waiting(url: str, waits: list[float]) -> Iterator[None]:
    """Ask for the time again and again meanwhile, and note how long each answer takes."""
    is_over = threading.Event()

    def ask() -> None:
        with connect(url, proxy=None) as link:
            while not is_over.wait(0.002):
                started = time.perf_counter()
                _call(link, "/rosapi/get_time")
                waits.append(time.perf_counter() - started)

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def _call(link: ClientConnection, service: str, **args: str | int) -> dict[str, int]:
    link.send(json.dumps({"op": "call_service", "service": service, "args": args}))
    values: dict[str, int] = json.loads(link.recv())["values"]
    return values


def _timed(command: list[str], environment: dict[str, str]) -> float:
    started = time.perf_counter()
    subprocess.run(command, stdout=subprocess.DEVNULL, env=environment, check=True)
    return time.perf_counter() - started


def _notes(samples: Samples) -> Iterator[str]:
    for name, wanted in WANTED.items():
        best = min(samples[name])
        yield f"Aim: {name} within {seconds(wanted)}: {verdict(best <= wanted)} ({seconds(best)} at best)."


def _stall(waits: list[float]) -> str:
    met = verdict(max(waits) <= STALL)
    return f"Aim: meanwhile no other client waits longer than {seconds(STALL)}: {met} ({seconds(max(waits))})."
