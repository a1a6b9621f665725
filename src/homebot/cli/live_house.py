"""The live view of a simulated house in a terminal: messages on the graph, and the simulated people."""

from __future__ import annotations

import io
import os
import shutil
import sys
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, TextIO, cast, final

import anyio
from anyio import to_thread

from homebot.cli.arguments import DEFAULT_SERVER
from homebot.cli.house_picture import HousePicture, Line, PlanPicture, lines_of
from homebot.cli.story import Story
from homebot.cli.terminal import is_terminal, rich_terminal
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.wording.values import plain_value
from homebot.graph import Node
from homebot.house.rooms import DAY, DOOR_WIDTH, OUTSIDE
from homebot.log import configure_logging
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from homebot.devices import Device, DeviceChange, StateChange
    from homebot.graph import Graph
    from homebot.house import World

_EVERY: Final = 0.5
"""Seconds between two frames: each takes up to 40 ms of processor time."""

_LAST_LINES: Final = 8
_ENTRIES: Final = 1000
_LOG_LINES: Final = 40


@final
class LiveHouse(HouseWatcher):
    """The picture of a house and its story."""

    def __init__(self, node: Node, world: World, title: str, hint: str) -> None:
        self._clock = node.graph.clock
        self._world = world
        self._title, self._hint = title, hint
        self._began, self._lived = self._clock.now(), world.now
        self._devices: dict[str, Device] = {}
        self._names: dict[str, str] = {}
        corners = {name: room.corners for name, room in world.rooms.rooms.items() if room.corners}
        rooms = {name: (*points[0], *points[2]) for name, points in corners.items()}
        self._plan = PlanPicture(rooms, [middle for _, _, middle in world.rooms.doorways()], DOOR_WIDTH)
        self._view = HouseView.of(node)
        self.story = Story(self._names, self._time)
        node.create_subscription(JournalEntry, JOURNAL_ENTRIES, self.story.add_entry, _ENTRIES)
        self._view.add(self)

    def picture(self) -> HousePicture:
        """Return the current picture."""
        views = [view for name in self._devices if (view := self._view.get(name)) is not None]
        devices = [view.current() for view in views]
        count = f"{len(devices)} of {len(self._world.devices)} devices found"
        if len(devices) >= len(self._world.devices):
            count = f"{len(devices)} devices"
        # people from the simulated world, robots from their reports
        beings = {room: [f"☺ {name}" for name in self._world.people_in(room)] for room in self._world.rooms.rooms}
        beings.pop(OUTSIDE)
        for device in devices:
            if device.service_type == "robots":
                for room in {str(plain_value(state.value)) for state in device.states} & beings.keys():
                    beings[room].append(f"▣ {device.name}")
        return HousePicture(
            f"{self._title} · {self._time()} · {count}",
            self._hint,
            devices,
            beings,
            self.story.lines.copy(),
            self._plan,
        )

    def on_device(self, change: DeviceChange) -> None:
        """Handle a device that appeared, changed or was removed."""
        device = change.device
        self._names[device.id] = device.name or device.id
        self._devices[device.id] = device
        if change.kind == "removed":
            del self._devices[device.id]
        self.story.add_change(change, self._clock.now())

    def on_values(self, change: StateChange) -> None:
        """Handle new values of a known device."""
        if change.live and change.device in self._devices:
            self.story.add_values(change, self._devices[change.device])

    def _time(self) -> str:
        passed = (self._clock.now() - self._began) * self._world.time.pace
        minutes = int(max(self._lived + passed, self._world.now) % DAY) // 60
        return f"{minutes // 60:02}:{minutes % 60:02}"


@asynccontextmanager
async def shown(graph: Graph, world: World, page: str) -> AsyncIterator[None]:
    """Show the house on the terminal during the block, with the address of its *page*; the last lines remain."""
    terminal = await to_thread.run_sync(rich_terminal, sys.stdout)  # loading rich takes a while
    async with Node(graph, "live_view", namespace="/homebot") as node, anyio.create_task_group() as tasks:
        house = LiveHouse(node, world, f"homebot · simulated, {world.time.pace:g}x speed · {page}", _hint(world, page))
        try:
            with terminal.screen() as draw:
                tasks.start_soon(run_as, node.full_name, partial(_redraw, house, draw))
                yield
                tasks.cancel_scope.cancel()
        finally:
            last = [f"{line.time} {line.sign} {line.text}" for line in house.story.lines][-_LAST_LINES:]
            print("\n".join(last))


async def _redraw(house: LiveHouse, draw: Callable[[Callable[[int, int], Sequence[Line]]], None]) -> None:
    while True:
        await to_thread.run_sync(draw, partial(lines_of, house.picture()))
        await anyio.sleep(_EVERY)


def _hint(world: World, page: str) -> str:
    lamp = next((name for name in world.devices if "lamp" in name and "kitchen" in name), next(iter(world.devices), ""))
    here = str(Path(sys.executable).with_name("homebot"))
    program = "homebot" if shutil.which("homebot") else min(os.path.relpath(here), here, key=len)
    address = page.rpartition("/")[2]
    host, port = DEFAULT_SERVER
    door = "" if address == f"{host}:{port}" else f" --door {address.removeprefix(f'{host}:')}"
    return f"Try in a second terminal:  {program} why {lamp}{door}    (Ctrl-C ends)"


@final
class _LastLines(io.TextIOBase):
    """The newest lines of the log, which would disrupt the view."""

    def __init__(self) -> None:
        self.lines: deque[str] = deque(maxlen=_LOG_LINES)

    def write(self, text: str) -> int:
        """Store *text*, and drop the oldest."""
        self.lines.append(text)
        return len(text)


@contextmanager
def quiet_log() -> Iterator[None]:
    """Keep the log from the terminal during the block; show its end after an error."""
    if not is_terminal(sys.stderr):
        configure_logging()
        yield
        return
    log = _LastLines()
    configure_logging(stream=cast("TextIO", log))
    try:
        yield
    except BaseException:
        sys.stderr.write("".join(log.lines))
        raise
