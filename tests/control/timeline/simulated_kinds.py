"""The kinds of devices, programs and accidents whose causes are judged, each a row of :data:`KINDS`.

Each row furnishes a house of its own, so that one kind is played again by its name and seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from random import Random
from typing import Literal, TypeAlias

import anyio
from tests.control.conftest import Home, OpenHome, hold_request
from tests.control.kept_store import KeptStore
from tests.control.timeline.simulated_house import SimulatedHouse, Tables, Truth

from homebot.clock import Clock
from homebot.devices.gateway_messages import Command, RefreshPart, RefreshRequest, RefreshResponse
from homebot.devices.value import PlainValue

GroupWay: TypeAlias = Literal["echo", "bridge", "computed"]
"""What a group reports: its command (Zigbee2MQTT), what the bridge did (Hue), its members' states (Home Assistant)."""

_ON_OFF = (False, True)
_BEYOND = (95.0, 100.0)
"""Levels that no command wants or passes."""


@dataclass(frozen=True, slots=True)
class Kind:
    """One row.

    Attributes:
        name: Its name.
        furnish: Puts its devices into a house.
        hours: How long it is watched.
        hand_every: The mean seconds between two changes by persons at any time.
        named: The least share of persons named. Others are unknown until it is learnt that a device keeps its values,
            and where a bridge may take back an echo, a lamp tell its old level again, or a blind be on its way.
        wrong_persons: The largest share of none among those told to be persons.
        unlearnt: How many changes of one house may be told to be a person's before their regularity is learnt.
        by_device: The least share of a device's own changes told to be its own.
        by_program: The least share of another program's changes told to be a program's.
        is_restarted: Whether homebot is restarted in the middle.
    """

    name: str
    furnish: Callable[[SimulatedHouse], None]
    hours: float = 3.0
    hand_every: float = 300.0
    named: float = 0.8
    wrong_persons: float = 0.05
    unlearnt: int = 0
    by_device: float = 0.0
    by_program: float = 0.0
    is_restarted: bool = False

    def failures(self, tables: Tables, seeds: int) -> list[str]:
        """Return which aims are missed, with the figures."""
        told = partial(tables.count, "")
        wrong = told(told="person") - told(truth="person", told="person")
        rows = (
            ("sent over a person", tables.overridden.total(), 0),
            ("wrong persons", wrong - self.unlearnt * seeds, math.floor(self.wrong_persons * told(told="person"))),
            ("persons told to be a command", told("person", "command") + told("person", "transition"), 0),
            ("persons told to be a device or program", told("person", "device") + told("person", "program"), 0),
            ("two answers", tables.seen["two answers"], 0),
            ("power cuts that end a hold", tables.seen["cuts"] - tables.seen["held again"], 0),
        )
        failures = [f"{name}: {number}, at most {most}" for name, number, most in rows if number > most]
        shares: tuple[tuple[Truth, float], ...] = (
            ("person", self.named),
            ("device", self.by_device),
            ("program", self.by_program),
        )
        failures += [
            f"{truth} told {truth}: {tables.share(truth, truth):.0%}, at least {least:.0%}"
            for truth, least in shares
            if told(truth) and tables.share(truth, truth) < least
        ]
        return failures


def groups(house: SimulatedHouse, way: GroupWay, *, low: float, high: float, is_asked: bool) -> None:
    """Two groups of three lamps that obey at once and report later; persons switch members soon after the command.

    A report within 0.1 s of the group's echo is not judged here: it looks like the bridge's echo for the member.
    """
    for key in ("ceiling", "spots"):
        _group(house, key, way, low, high)
    if is_asked:
        _answer_for_members(house)


def _group(house: SimulatedHouse, key: str, way: GroupWay, low: float, high: float) -> None:
    names = tuple(f"{key}-{number}" for number in range(3))
    for name in names:
        house.plain(name, key, kind="member")
    echoed = ("on_off",) if way == "echo" else ()
    listed = tuple(f"id:{name}" for name in names)
    house.put(key, "group", {"on_off": (False,)}, area=key, members=listed, echoed=echoed)
    house.values[key, "", "on_off"] = False
    obeyed: dict[str, float] = {}

    async def obey(_: Home, command: Command) -> None:
        value = command.value.plain()
        if way != "computed":
            after = (0.01, 0.1) if way == "echo" else (0.05, 1.0)
            house.later(house.random.uniform(*after), key, "", "on_off", value, "command")
        for name in names:
            house.physical[name, "", "on_off"] = value
            house.later(house.random.uniform(low, high), name, "", "on_off", value, "along")

    def compute(name: str, truth: Truth) -> None:
        value = any(house.values[one, "", "on_off"] for one in names)
        if name in names and value != house.values[key, "", "on_off"]:
            house.later(0.02, key, "", "on_off", value, "command" if truth == "along" else truth)

    async def run() -> None:
        while True:
            await anyio.sleep(house.random.uniform(90.0, 400.0))
            value = not house.values[key, "", "on_off"]
            given = house.now()
            house.home.tasks.start_soon(house.command, key, "", "on_off", value)
            await anyio.sleep(house.random.uniform(0.4, 10.0))
            done = [
                name for name in names if house.values[name, "", "on_off"] == value and obeyed.get(name, 0.0) > given
            ]
            if done and house.random.random() < 0.7:
                house.touch(house.random.choice(done), "on_off", _ON_OFF)

    house.behave(key, obey)
    house.watchers.append(lambda change: obeyed.__setitem__(change.place[0], change.at))
    if way == "computed":
        house.watchers.append(lambda change: compute(change.place[0], change.truth))
    house.loops.append(run)


def _answer_for_members(house: SimulatedHouse) -> None:
    """Let the gateway ask: the members of a group tell how they are."""

    async def tell(key: str) -> None:
        await anyio.sleep(house.random.uniform(0.05, 0.4))
        place = key, "", "on_off"
        if place in house.physical:
            house.later(0.0, key, "", "on_off", house.physical[place], "along")

    async def refresh(request: RefreshRequest) -> RefreshResponse:
        for key in house.members[request.key] or (request.key,):
            house.home.tasks.start_soon(tell, key)
        return RefreshResponse(success=True, message="")

    house.on_enter(lambda home: home.gateway.node.create_service(RefreshPart, home.gateway.names.refresh, refresh))


def fades(house: SimulatedHouse, *, transition: float, late: float, by: Literal["off", "level"] = "off") -> None:
    """Lamps that come on by a level, in steps or told late; persons turn them off, or dim them, before it has come."""
    for number in range(3):
        _fading_lamp(house, f"lamp{number}", transition, late, by)


def _fading_lamp(house: SimulatedHouse, key: str, transition: float, late: float, by: str) -> None:
    house.put(key, "fading", {"on_off": _ON_OFF, "level": (0.0,)}, area=key, fades=transition > 0)
    house.values[key, "", "on_off"], house.values[key, "", "level"] = False, 5.0

    async def obey(_: Home, command: Command) -> None:
        number = None
        for setting in command.singly():
            value = setting.value.plain()
            number = house.newest_number(key)
            number = house.later(0.1, key, "", "on_off", value is not False, "command", number=number)
            if isinstance(value, float):
                begun = float(str(house.values[key, "", "level"]))
                steps = max(round(transition), 1)
                for step in range(1, steps + 1):
                    level = round(begun + (value - begun) * step / steps, 1)
                    after = 0.1 + (step if transition else house.random.uniform(0.2, late))
                    house.later(after, key, "", "level", level, "command", number=number)

    async def run() -> None:
        while True:
            await anyio.sleep(house.random.uniform(60.0, 240.0))
            if house.values[key, "", "on_off"]:
                await house.give(key, {"on_off": False})
                continue
            given = house.now()
            wanted = house.random.choice((50.0, 70.0))
            house.home.tasks.start_soon(partial(house.give, key, {"on_off": True, "level": wanted}, "", transition))
            await anyio.sleep(house.random.uniform(0.5, max(transition, late) - 0.2))
            if house.values[key, "", "on_off"] and house.random.random() < 0.7:
                if by == "off":
                    house.touch(key, "on_off", _ON_OFF)
                else:
                    house.touch(key, "level", _BEYOND)
            await anyio.sleep(max(0.0, given + 40.0 - house.now()))

    house.behave(key, obey)
    house.loops.append(run)


def blinds(house: SimulatedHouse, *, settles_after: float, by: float) -> None:
    """Blinds that tell where they are, and settle by a little after a while."""
    for number in range(3):
        _blind(house, f"blind{number}", settles_after, by)


def _blind(house: SimulatedHouse, key: str, settles_after: float, by: float) -> None:
    positions = (15.0, 55.0, 80.0)
    house.put(key, "blind", {"position": positions}, area=key, service_type="window_covering")

    async def obey(_: Home, command: Command) -> None:
        wanted, begun = float(str(command.value.plain())), float(str(house.values[key, "", "position"]))
        number = house.newest_number(key)
        seconds = abs(wanted - begun) / 5.0
        steps = max(int(seconds // 2), 1)
        for step in range(1, steps + 1):
            at = round(begun + (wanted - begun) * step / steps)
            house.later(seconds * step / steps, key, "", "position", float(at), "command", number=number)
        if by:
            settled = wanted + by if wanted < 50.0 else wanted - by
            after = seconds + settles_after + house.random.uniform(-2.0, 2.0)
            house.later(after, key, "", "position", settled, "device", number=number)

    house.behave(key, obey)
    house.drive(key, "", "position", (0.0, 40.0, 100.0), 200.0, 900.0)


def adaptive(house: SimulatedHouse) -> None:
    """Lamps that another program dims and tints along the day, as long as they are lit.

    Its first changes, and those after a pause of which nobody knows how many intervals it was, may be a person's.
    """
    for number in range(3):
        _adaptive_lamp(house, f"lamp{number}")


def _adaptive_lamp(house: SimulatedHouse, key: str) -> None:
    settings: dict[str, tuple[PlainValue, ...]] = {"on_off": _ON_OFF, "level": (0.0,), "color_temperature": (0.0,)}
    house.put(key, "adaptive", settings, area=key)
    house.values[key, "", "level"], house.values[key, "", "color_temperature"] = 50.0, 3000.0
    house.behave(key, partial(house.obey, 0.02, 0.4))
    house.drive(key, "", "on_off", _ON_OFF, 900.0, 2400.0)

    async def run() -> None:
        began = house.now()
        while True:
            await anyio.sleep(90.0 + house.random.uniform(-0.3, 0.3))
            phase = (house.now() - began) / 14_400.0 * math.pi
            if house.values[key, "", "on_off"]:
                number = house.newest_number(key)
                level = round(60.0 + 35.0 * math.sin(phase))
                house.later(0.1, key, "", "level", float(level), "program", number=number)
                tint = round(3500.0 + 1200.0 * math.sin(phase))
                house.later(0.12, key, "", "color_temperature", float(tint), "program", number=number)

    house.loops.append(run)


def timers(house: SimulatedHouse, *minutes: float) -> None:
    """Lights that go off by themselves after so many minutes, three of each."""
    for length in minutes:
        for number in range(3):
            house.timer(f"timer{length:g}-{number}", f"room{length:g}-{number}", 60.0 * length)


def held(house: SimulatedHouse) -> None:
    """A lamp that a robot holds off; after a power cut it is on."""
    key = "lamp"
    house.plain(key, "room", kind="held")
    house.put(key, "held", {"on_off": (False,)}, area="room")
    house.values[key, "", "on_off"] = False

    async def run() -> None:
        for lease in count():
            asked = hold_request(house.ids[key], "on_off", value=False, ttl=3600.0, lease=str(lease))
            is_held = (await house.home.hold(asked)).held
            await anyio.sleep(house.random.uniform(900.0, 1500.0))
            if not is_held or house.is_touched_since(key, house.now() - 310.0):
                continue  # a hand outranks the hold
            house.dark.add(key)
            house.home.gateway.devices.report_reachable(key, reachable=False)
            await anyio.sleep(house.random.uniform(2.0, 300.0))
            house.home.gateway.devices.report_reachable(key, reachable=True)
            house.later(house.random.uniform(0.05, 2.0), key, "", "on_off", value=True, truth="away")
            await anyio.sleep(45.0)
            house.dark.discard(key)
            house.tables.seen["cuts"] += 1
            house.tables.seen["held again"] += house.values[key, "", "on_off"] is False

    house.loops.append(run)


def drifting(house: SimulatedHouse) -> None:
    """Dimmers that tell a confirmed level again, rounded to their grid."""
    for number in range(3):
        _drifting_lamp(house, f"lamp{number}")


def _drifting_lamp(house: SimulatedHouse, key: str) -> None:
    house.put(key, "drift", {"level": (5.0, 35.0, 65.0, 95.0)}, area=key)

    async def obey(_: Home, command: Command) -> None:
        value = float(str(command.value.plain()))
        number = house.newest_number(key)
        house.later(house.random.uniform(0.05, 0.4), key, "", "level", value, "command", number=number)
        rounded = round(round(value * 2.54) / 2.54 - 0.3, 2)
        house.later(house.random.uniform(15.0, 60.0), key, "", "level", rounded, "device", number=number)

    house.behave(key, obey)
    house.drive(key, "", "level", (20.0, 50.0, 80.0), 90.0, 400.0)


def gateway_restarts(house: SimulatedHouse) -> None:
    """Lamps whose gateway is away now and then, and tells their states when it is back."""
    for number in range(3):
        house.commanded(f"lamp{number}", f"room{number}")

    async def run() -> None:
        while True:
            await anyio.sleep(house.random.uniform(600.0, 1200.0))
            gateway = house.home.gateway
            gateway.set_unavailable("it restarts")
            await gateway.devices.on_link_loss()
            house.is_away = True
            await anyio.sleep(house.random.uniform(5.0, 60.0))
            house.is_away = False
            gateway.set_available()
            for key in house.members:
                gateway.devices.report_reachable(key, reachable=True)
                await house.tell_again(key)

    house.loops.append(run)


def mixed(house: SimulatedHouse) -> None:
    """A little of everything."""
    _group(house, "ceiling", "bridge", 0.1, 1.0)
    house.timer("stairs", "stairs", 300.0)
    _blind(house, "blind", 20.0, 2.0)
    for number in range(2):
        house.commanded(f"lamp{number}", f"room{number}")


KINDS = (
    Kind("z2m group", partial(groups, way="echo", low=0.2, high=2.5, is_asked=True)),
    Kind("z2m group, not asked", partial(groups, way="echo", low=0.2, high=2.5, is_asked=False)),
    Kind("z2m group, late", partial(groups, way="echo", low=0.2, high=15.0, is_asked=True)),
    Kind("z2m group, late, not asked", partial(groups, way="echo", low=0.2, high=15.0, is_asked=False)),
    Kind("hue group", partial(groups, way="bridge", low=0.05, high=1.0, is_asked=True)),
    Kind("ha group", partial(groups, way="computed", low=0.1, high=2.5, is_asked=True)),
    Kind("fade, off", partial(fades, transition=6.0, late=0.0)),
    Kind("fade, dimmed", partial(fades, transition=6.0, late=0.0, by="level"), named=0.5),
    Kind("late level, off", partial(fades, transition=0.0, late=8.0), named=0.7),
    Kind("blind that settles", partial(blinds, settles_after=20.0, by=2.0), hours=6.0, by_device=0.95, named=0.7),
    Kind("adaptive lighting", adaptive, hours=6.0, by_program=0.75, named=0.85, unlearnt=3),
    Kind("timer of 5 min", lambda house: timers(house, 5.0), hours=6.0, hand_every=1000.0, by_device=0.8, named=0.9),
    Kind("timer of 15 min", lambda house: timers(house, 15.0), hours=12.0, hand_every=3000.0, by_device=0.8, named=0.9),
    Kind("timer of 30 min", lambda house: timers(house, 30.0), hours=24.0, hand_every=6000.0, by_device=0.8, named=0.9),
    Kind(
        "timer of 60 min", lambda house: timers(house, 60.0), hours=48.0, hand_every=12000.0, by_device=0.8, named=0.9
    ),
    Kind("power cut, held", held, hours=6.0, hand_every=4000.0),
    Kind("drift", drifting, by_device=0.95, named=0.85),
    Kind("gateway restarts", gateway_restarts, named=0.9),
    Kind("restart", mixed, hand_every=100.0, is_restarted=True),
)


@dataclass
class Play:
    """One kind with one seed."""

    kind: Kind
    seed: int
    tables: Tables = field(default_factory=Tables)

    async def run(self, open_home: OpenHome) -> Tables:
        """Live in its house."""
        store = KeptStore()
        lives = 2 if self.kind.is_restarted else 1
        house: SimulatedHouse | None = None
        clock: Clock | None = None
        for _ in range(lives):
            async with open_home(rate_limit=False, always_ask=False, store=store, clock=clock) as home:
                clock = home.graph.clock
                if house is None:
                    random = Random(self.seed)  # noqa: S311 - no secrets
                    house = SimulatedHouse(home, random, self.tables, self.kind.hours / lives, self.kind.hand_every)
                    self.kind.furnish(house)
                else:
                    house.enter(home)
                house.watch_answers()
                await house.run()
        return self.tables
