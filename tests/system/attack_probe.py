"""A homebot in a process of its own, to be attacked, and what that costs it: loop lag, memory, what stays open.

``with attacked(folder) as homebot`` starts it with :class:`LoopProbe`, an app that watches the event loop from within.
``homebot.toll()`` reads what was seen since the last reading; ``rss`` and ``open_files`` work for any process.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import anyio
from tests.patience import PATIENCE
from websockets.sync.client import connect

from homebot.apps import App
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest

ROOT = Path(__file__).parent.parent.parent

T = TypeVar("T")

_PULSE = 0.005
_ENDS_OF_HISTORY = 9  # node, services, subscriptions and clients
_LATE = 0.05
_SERVICE = "/loop_probe/read"


def rss(pid: int) -> float:
    """Return the resident memory of a process in MiB."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="ascii")
    return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) / 1024  # type: ignore[index]


def open_files(pid: int) -> int:
    """Return how many files and sockets a process has open."""
    return len(os.listdir(f"/proc/{pid}/fd"))  # noqa: PTH208  # a count is enough


@dataclass(frozen=True)
class Toll:
    """What homebot is like now, and how late its event loop was since the last reading.

    Attributes:
        lag: Seconds by which the loop was late at worst.
        late: How often it was late by more than 50 ms.
        busy: Seconds of the processor that the loop worked at worst before it came back to the probe, which waits 5 ms
            each time: unlike the lag, it does not count what other programs took.
        rss: Resident memory in MiB.
        files: Open files and sockets.
        tasks: Tasks of the event loop.
        entities: Entities on the graph by their nodes.
    """

    lag: float
    late: int
    busy: float
    rss: float
    files: int
    tasks: int
    entities: dict[str, int]

    def __str__(self) -> str:
        held = sum(self.entities.values())
        return (
            f"worst lag {self.lag * 1000:.0f} ms ({self.late} above 50 ms), busy {self.busy * 1000:.0f} ms, "
            f"{self.rss:.0f} MiB, {self.files} files, {self.tasks} tasks, {held} entities"
        )

    def is_back_at(self, before: Toll) -> bool:
        """Return whether the flood after *before* left nothing open, and no entity is gone.

        There may be fewer files and tasks: what was at work before the flood may have ended since.
        """
        return self.files <= before.files and self.tasks <= before.tasks and self.entities == before.entities


class LoopProbe(App):
    """Measures how late the event loop is; runs inside the homebot that is attacked."""

    async def run(self) -> None:
        self._lags: list[float] = []
        self._busy = 0.0
        self.node.create_service(Trigger, _SERVICE, self._read)
        while True:
            before, worked = time.monotonic(), time.thread_time()
            await anyio.sleep(_PULSE)
            self._busy = max(self._busy, time.thread_time() - worked)
            self._lags.append(time.monotonic() - before - _PULSE)
            del self._lags[:-100_000]

    def _read(self, _request: TriggerRequest) -> SuccessResponse:
        lags, self._lags = self._lags, []
        busy, self._busy = self._busy, 0.0
        entities = Counter(info.node for info in self.node.graph.get_endpoints())
        seen = {
            "lag": max(lags, default=0.0),
            "late": sum(lag > _LATE for lag in lags),
            "busy": busy,
            "tasks": len(asyncio.all_tasks()),
            "entities": dict(sorted(entities.items())),
        }
        return SuccessResponse(success=True, message=json.dumps(seen))


class Attacked:
    """A ``homebot run`` in a process of its own.

    Attributes:
        pid: Its process.
        door: Port of its door.
        broker: Port of its embedded broker.
        log: File that its log goes to.
    """

    def __init__(self, process: subprocess.Popen[bytes], log: Path, token: str) -> None:
        self.pid = process.pid
        self.log = log
        self._process = process
        self._token = token
        text = self._said("is running; listening for rosbridge clients on")
        self.door = int(re.search(r"listening for rosbridge clients on \S+:(\d+)", text)[1])  # type: ignore[index]
        broker = re.search(r"embedded MQTT broker on \S+:(\d+)", text)
        self.broker = int(broker[1]) if broker else 0

    @property
    def url(self) -> str:
        """The door's address."""
        return f"ws://127.0.0.1:{self.door}/"

    def toll(self) -> Toll:
        """Read what was seen since the last reading; through the door, as anybody can."""
        headers = {"Authorization": f"Bearer {self._token}"} if self._token else None
        with connect(self.url, additional_headers=headers, proxy=None, compression=None, open_timeout=PATIENCE) as door:
            door.send(json.dumps({"op": "call_service", "id": "toll", "service": _SERVICE, "timeout": PATIENCE}))
            while (answer := json.loads(door.recv(timeout=PATIENCE))).get("id") != "toll":
                pass
        seen = json.loads(answer["values"]["message"])
        return Toll(rss=rss(self.pid), files=open_files(self.pid), **seen)

    def settled(self, before: Toll, within: float = PATIENCE) -> Toll:
        """Return the toll once as much is open as *before*, or the last one after *within* seconds."""
        deadline = time.monotonic() + within
        now = self.toll()
        while not now.is_back_at(before) and time.monotonic() < deadline:
            time.sleep(0.2)
            now = self.toll()
        return now

    def text(self) -> str:
        """Return the log so far."""
        return self.log.read_text(encoding="utf-8")

    def _said(self, words: str) -> str:
        def line() -> str | None:
            if self._process.poll() is not None:
                raise AssertionError(f"homebot ended:\n{self.text()}")
            text = self.text()
            return text if words in text else None

        return until(line, PATIENCE)


@contextmanager
def attacked(folder: Path, *arguments: str, token: str = "") -> Iterator[Attacked]:
    """Run ``homebot run`` with the probe and *arguments* inside *folder*, on free ports; it must end well."""
    log = folder / "homebot.log"
    environment = {name: value for name, value in os.environ.items() if not name.startswith("HOMEBOT_")}
    environment |= {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'src'}", "HOMEBOT_DATA": str(folder / "data")}
    if token:
        environment["HOMEBOT_DOOR_TOKEN"] = token
    command = [sys.executable, "-m", "homebot", "run", "--app", f"{__name__}:LoopProbe", "--door", "127.0.0.1:0"]
    with (
        log.open("wb") as out,
        subprocess.Popen([*command, *arguments], stdout=out, stderr=out, cwd=folder, env=environment) as process,
    ):
        try:
            yield Attacked(process, log, token)
            process.terminate()
            assert process.wait(PATIENCE) == 0, log.read_text(encoding="utf-8")[-4000:]
        finally:
            process.kill()
    assert "Traceback" not in log.read_text(encoding="utf-8")


def begun(homebot: Attacked) -> Attacked:
    """Return *homebot* once all has joined that begins after the start: the robot of its house, and the history."""

    def has_begun() -> bool | None:
        entities = homebot.toll().entities
        return ("/robots" in entities and entities.get("/history", 0) >= _ENDS_OF_HISTORY) or None

    until(has_begun, PATIENCE)
    return homebot


def until(look: Callable[[], T | None], within: float) -> T:
    """Return what *look* finds, asking again until it finds something."""
    deadline = time.monotonic() + within
    while (found := look()) is None:
        assert time.monotonic() < deadline, f"nothing within {within:g} s"
        time.sleep(0.02)
    return found
