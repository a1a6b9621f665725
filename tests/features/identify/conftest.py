"""Fixtures: a home with control, as in ``tests/control``, the action, and a sensor that sees its lamps."""

from __future__ import annotations

import copy
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from datetime import datetime, time
from random import Random
from typing import Any

import anyio
import pytest
from tests.control.conftest import Home, home, home_settings, open_home
from tests.one_task import in_one_task

from homebot.clock import home_time
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import PERFORM_COMMAND
from homebot.devices.outcomes import Outcome
from homebot.features.identify import IDENTIFY_DEVICE
from homebot.features.identify.identify_server import IdentifyServer
from homebot.features.identify.messages import (
    IdentifyDevice,
    IdentifyDeviceFeedback,
    IdentifyDeviceGoal,
    IdentifyDeviceResult,
)
from homebot.features.identify.saved_values import SavedValues
from homebot.graph import Node
from homebot.graph.actions import ActionClient, ClientGoal
from homebot.messages.json import message_from_json
from homebot.messages.std_msgs import Float64

__all__ = ["Room", "home", "home_settings", "open_home", "room", "served"]

Goal = ClientGoal[IdentifyDeviceResult, IdentifyDeviceFeedback]
PERIOD = 0.2


class Room:
    """A home with lamps, and a sensor of 5 Hz that sees them.

    Attributes:
        effects: By how much each lamp changes what the sensor sees.
        told: What people were told.
        store: The values that are kept across restarts.
        flushed: What of them a kill would leave.
        problem: Why they cannot be written; empty if they can.
        now: The time of day.
        seen: What the sensor makes of a value.
        fade: Seconds for which a lamp fades after its report, unless it is commanded with a transition that it takes.
        takes_transitions: Whether the lamps do.
    """

    def __init__(self, home: Home) -> None:
        self.home = home
        self.effects: dict[str, float] = {}
        self.values: dict[str, float] = {}
        self.random = Random(1)  # noqa: S311 - a simulation
        self.noise, self.least, self.fade, self.takes_transitions = 5.0, 0.0, PERIOD, False
        self.shown: dict[str, float] = {}
        self.told: list[str] = []
        self.store: dict[str, Any] = {}
        self.flushed: dict[str, Any] = {}
        self.problem = ""
        self.now = "12:00"
        home_time.set(lambda: datetime.fromisoformat(f"2026-01-01 {self.now}"))
        self.quiet: list[tuple[time, time]] = []
        self.feedback: list[IdentifyDeviceFeedback] = []
        self.sensor = home.app.create_publisher(Float64, "/rosie/light")
        self.is_seeing = True
        self.seen: Callable[[float], float] = lambda value: value
        home.tasks.start_soon(self._see)

    async def lamp(self, key: str, effect: float, *, is_on: bool = False, area: str = "hall") -> None:
        """Put a lamp that changes the sensor's value by *effect*."""
        self.home.put(key, "light", "on_off", area=area)
        await self.home.report(key, "on_off", is_on)
        self.effects[key] = effect

    async def lamps(self, *effects: float) -> None:
        """Put the lamps ``lamp0``, ``lamp1`` and so on."""
        for number, effect in enumerate(effects):
            await self.lamp(f"lamp{number}", effect, is_on=bool(number % 2))

    async def identify(self, **goal: object) -> IdentifyDeviceResult:
        goal_sent = await self.begin(**goal)
        return (await goal_sent.result())[1]

    async def begin(self, **goal: object) -> Goal:
        await anyio.sleep(0.01)  # of virtual time, in which the directory takes everything in
        fields = {"candidates": "light in hall", "topic": "/rosie/light", "issuer": "client:rosie", **goal}
        client = ActionClient(self.home.app, IdentifyDevice, IDENTIFY_DEVICE.name)
        asked = message_from_json(IdentifyDeviceGoal, fields)
        return await client.send_goal(asked, self.feedback.append)

    async def is_on(self) -> dict[str, bool]:
        """Return whether each lamp is on."""
        await anyio.sleep(0.01)
        devices = await DeviceLookup(self.home.app).devices()
        return {one.name: one.states[0].value.plain() is True for one in devices if one.name.startswith("Lamp")}

    async def by_person(self, key: str, *, is_on: bool) -> None:
        """Switch a lamp at its own switch."""
        await self.home.report(key, "on_off", is_on)

    async def command(self, key: str, *, is_on: bool, issuer: str = "client:owner") -> Outcome:
        device = next(one for one in await DeviceLookup(self.home.app).devices() if one.name == key.title())
        request = CommandRequest(device=device.id, part="", settings=(Setting.of("on_off", is_on),), issuer=issuer)
        return await self.home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=60)

    async def flush(self) -> str:
        self.flushed = copy.deepcopy(self.store)
        return self.problem

    async def tell(self, message: str, title: str) -> None:
        self.told.append(f"{title}: {message}")

    async def _see(self) -> None:
        lookup, transitions, carried_out = DeviceLookup(self.home.app), dict[str, float](), 0
        while True:
            await anyio.sleep(PERIOD)
            devices = {one.name: one for one in await lookup.devices()}
            if self.takes_transitions:
                transitions |= {one.key: one.transition for one in self.home.commands[carried_out:]}
                carried_out = len(self.home.commands)
            lit = 0.0
            for key, effect in self.effects.items():
                device = devices.get(key.title())
                value = device.states[0].value.plain() if device is not None and device.states else 0.0
                level = value / 100 if isinstance(value, float) else float(value is True)
                step = PERIOD / (transitions.get(key) or self.fade)
                before = self.shown.get(key, level)
                self.shown[key] = before + max(-step, min(step, level - before))
                lit += effect * self.shown[key]
            if self.is_seeing:
                self.sensor.publish(Float64(data=self.seen(100 + lit + self.random.gauss(0, self.noise))))


@asynccontextmanager
async def served(room: Room) -> AsyncIterator[SavedValues]:
    """Serve the action until a restart."""
    home = room.home
    async with Node(home.graph, "identify") as node:
        kept = SavedValues(node, DeviceLookup(node), room.store, room.flush, home.graph.clock.now())
        node.create_task(kept.run)
        IdentifyServer(node, kept, home.control.preview, room.tell, lambda: room.quiet, room.random)
        yield kept


@pytest.fixture
async def room(home: Home) -> AsyncIterator[Room]:
    """A room without lamps, by day."""
    found = Room(home)
    async with in_one_task(served(found)):
        yield found
