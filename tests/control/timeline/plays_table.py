"""Who did what, in plays of every kind of house; :mod:`tests.control.timeline.truth_table` prints how well it is known.

Each play goes on at one device or group in virtual time, again and again with other times, and is a function of a seed.
The truth is what the play did; what homebot tells is read from its graph, and what it sends from the gateway.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Awaitable, Callable, Iterable, Mapping
from dataclasses import dataclass, field
from random import Random
from types import MappingProxyType
from typing import Final, NamedTuple, TypeAlias

import anyio
from tests.control.conftest import Home, hold_request, obey_after, opened_home
from tests.control.kept_store import KeptStore
from tests.control.timeline.simulated_house import SimulatedHouse, Tables

from homebot.command_words.undo_record import UndoRecord, known_states
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle, Light
from homebot.devices.journal_messages import GetCauses, GetCausesRequest, KnownCause
from homebot.devices.lease_messages import LeaseResponse
from homebot.devices.names import GET_CAUSES, PERFORM_COMMAND
from homebot.devices.outcomes import Outcome, Refused
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.support.virtual_time import VirtualTimeLoop

MEMBERS: Final = ("one", "two", "three")
PERSON: Final = frozenset({"person", "unknown"})


@dataclass(slots=True)
class Score:
    """How often each thing that a play asks for was so, and how often it was asked; and some that were not."""

    so: Counter[str] = field(default_factory=Counter)
    asked: Counter[str] = field(default_factory=Counter)
    failures: list[str] = field(default_factory=list)

    def ask(self, what: str, *, is_so: bool, told: object = "") -> None:
        """Count whether something was so; *told* is shown where it was not."""
        self.asked[what] += 1
        self.so[what] += is_so
        if not is_so:
            self.failures.append(f"{what}: {told}")


class Stage:
    """A house, what is drawn in it, and the score."""

    def __init__(self, home: Home, random: Random, score: Score) -> None:
        self.home, self.random, self.score = home, random, score

    async def pause(self, least: float, most: float) -> float:
        """Let some time pass; return how long."""
        seconds = self.random.uniform(least, most)
        await anyio.sleep(seconds)
        return seconds

    async def command(self, key: str, **settings: PlainValue) -> Outcome:
        device = (await self.home.handle(Handle, key)).device
        wanted = tuple(Setting.of(name, value) for name, value in settings.items())
        request = CommandRequest(device=device.id, settings=wanted, issuer="/app")
        return await self.home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=900.0)

    def begin(self, key: str, **settings: PlainValue) -> list[Outcome]:
        return self.home.begin(lambda: self.command(key, **settings))

    async def cause(self, key: str, capability: str) -> KnownCause:
        device = (await self.home.handle(Handle, key)).device
        client = self.home.app.create_client(GetCauses, GET_CAUSES)
        found = (await client.call(GetCausesRequest(devices=(device.id,), from_journal=True))).causes
        return next(one for one in found if one.capability == capability)

    def sent(self) -> int:
        return len(self.home.commands)


Play: TypeAlias = Callable[[Stage], Awaitable[None]]


class Row(NamedTuple):
    """A play, with the share that has to be so of what it asks, where that is not all."""

    play: Play
    aims: Mapping[str, float] = MappingProxyType({})

    def missed(self, score: Score) -> list[str]:
        """Return what was so too seldom."""
        return [what for what, asked in score.asked.items() if score.so[what] < self.aims.get(what, 1.0) * asked]


# Groups


class Group:
    """A group of three lamps.

    Args:
        brand: ``zigbee2mqtt`` repeats the command as the group's state at once, ``hue`` tells "any is on" after the
            lamps, ``homeassistant`` tells the group's state once all agree, ``deconz`` tells nothing of a group.
        latest: Seconds within which a member reports.
    """

    def __init__(self, stage: Stage, brand: str, latest: float) -> None:
        self.stage, self.home, self.brand, self.latest = stage, stage.home, brand, latest
        self.states = dict.fromkeys(MEMBERS, False)
        self._begun = Counter[str]()

    async def put(self) -> None:
        """Let there be the group and its lamps, which are off."""
        devices = self.home.gateway.devices
        can = Capability(name="on_off", settable=True, readable=True)
        for name in MEMBERS:
            part = Part(id="", service_type="light", capabilities=(can,))
            devices.put(GatewayDevice(name, name.title(), (part,), identifiers=(f"id:{name}",)), "a test")
        can, listed = can.model_copy(update={"readable": self.brand != "deconz"}), tuple(f"id:{one}" for one in MEMBERS)
        part = Part(id="", service_type="light", capabilities=(can,), members=listed)
        devices.put(GatewayDevice("all", "All", (part,)), "a test")
        self.home.behaviours["all"] = self._obey
        for name in (*MEMBERS, *(() if self.brand == "deconz" else ("all",))):
            await self.home.report(name, "on_off", False)

    def change(self, name: str, value: PlainValue, after: float) -> None:
        """Let a member report a value, unless something newer happens to it first."""
        self._begun[name] += 1
        self.home.tasks.start_soon(self._report, name, value, after, self._begun[name])

    async def _report(self, name: str, value: PlainValue, after: float, number: int) -> None:
        await anyio.sleep(after)
        if self._begun[name] != number:
            return
        self.states[name] = bool(value)
        await self.home.report(name, "on_off", value)
        agreed = set(self.states.values())
        if self.brand == "hue" or (self.brand == "homeassistant" and len(agreed) == 1):
            await self.home.report("all", "on_off", any(agreed))

    async def _obey(self, _: Home, command: Command) -> None:
        if self.brand == "zigbee2mqtt":
            await self.home.report("all", "on_off", command.value.plain())
        for name in MEMBERS:
            self.change(name, command.value.plain(), self.stage.random.uniform(0.05, self.latest))


def group_of(brand: str, latest: float) -> Play:
    """In one of two rounds a person switches a member up to 10 s after the command to its :class:`Group`."""

    async def by_hand(stage: Stage, group: Group, *, wanted: bool) -> None:
        await stage.pause(0.2, 10.0)
        name, before = stage.random.choice(MEMBERS), stage.sent()
        if group.states[name] != wanted:
            return  # it has not obeyed yet: the hand and the command do the same
        group.change(name, not wanted, stage.random.uniform(0.02, 0.3))
        await anyio.sleep(2.0)
        told = await stage.cause(name, "on_off")
        stage.score.ask("a person at a member", is_so=told.cause in PERSON and told.may_be_person, told=told)
        await anyio.sleep(20.0)
        stage.score.ask("nothing sent over a person", is_so=stage.sent() == before, told=stage.sent() - before)

    async def play(stage: Stage) -> None:
        group = Group(stage, brand, latest)
        await group.put()
        await anyio.sleep(60.0)
        for number in range(8):
            wanted, before = number % 2 == 0, stage.sent()
            stage.begin("all", on_off=wanted)
            if stage.random.random() < 0.5:
                await by_hand(stage, group, wanted=wanted)
            else:
                await anyio.sleep(latest + 12.0)
                for name in MEMBERS:
                    told = await stage.cause(name, "on_off")
                    stage.score.ask("members follow the command", is_so=told.cause == "command", told=told)
                count = stage.sent() - before
                if latest < 1.0:
                    stage.score.ask("the command is sent once", is_so=count == 1, told=count)
            await stage.pause(60.0, 400.0)
            await stage.command("all", on_off=wanted)  # all agree again
            await stage.pause(60.0, 100.0)

    return play


# Fades and levels


async def fade_cut_by_hand(stage: Stage) -> None:
    """A lamp fades up, and a person turns it off before the level has come."""
    home, draw = stage.home, stage.random
    begun = Counter[str]()

    async def fade(_: Home, command: Command) -> None:
        begun["lamp"] += 1
        number, target = begun["lamp"], command.value.plain()
        if command.capability == "on_off" and not target:
            await home.report("lamp", "on_off", value=False)
            return
        level = float(target) if isinstance(target, float) else 80.0

        async def steps() -> None:
            await anyio.sleep(draw.uniform(0.05, 0.6))
            for step in range(5):
                if begun["lamp"] != number:
                    return
                if step == 0:
                    await home.report("lamp", "on_off", value=True)
                await home.report("lamp", "level", level * (step + 1) / 5)
                await anyio.sleep(draw.uniform(0.5, 1.2))

        home.tasks.start_soon(steps)

    await home.lamp("on_off", "level", before={"on_off": False, "level": 10.0}, behaviour=fade)
    await anyio.sleep(60.0)
    for _ in range(8):
        stage.begin("lamp", on_off=True, level=draw.choice((40.0, 60.0, 80.0)))
        await stage.pause(0.7, 7.0)
        begun["lamp"] += 1
        before = stage.sent()
        await home.report("lamp", "on_off", value=False)
        await anyio.sleep(30.0)
        told = await stage.cause("lamp", "on_off")
        stage.score.ask("off stays off", is_so=stage.sent() == before, told=stage.sent() - before)
        stage.score.ask("a person in a fade", is_so=told.cause in PERSON, told=told)
        await stage.pause(60.0, 300.0)


async def late_level(stage: Stage) -> None:
    """A lamp tells that it is on at once, and its level some seconds later."""
    home, draw = stage.home, stage.random

    async def obey(_: Home, command: Command) -> None:
        late = draw.uniform(1.0, 8.0) if command.capability == "level" else draw.uniform(0.02, 0.5)
        home.later(late, "lamp", command.capability, command.value.plain())

    await home.lamp("on_off", "level", before={"on_off": False, "level": 10.0}, behaviour=obey)
    await anyio.sleep(60.0)
    for _ in range(8):
        await stage.command("lamp", on_off=True, level=float(draw.randrange(20, 100)))
        await anyio.sleep(12.0)
        for capability in ("on_off", "level"):
            told = await stage.cause("lamp", capability)
            stage.score.ask("a late level is the command's", is_so=told.cause == "command", told=told)
        await home.report("lamp", "on_off", value=False)
        await stage.pause(60.0, 400.0)


async def scene_undo(stage: Stage) -> None:
    """A person switches one of three lamps of a scene while it fades; the undo leaves that one alone."""
    home, draw = stage.home, stage.random
    begun = Counter[str]()

    async def fade(_: Home, command: Command) -> None:
        begun[command.key] += 1
        number = begun[command.key]

        async def arrive() -> None:
            await anyio.sleep(draw.uniform(0.1, 4.0))
            if begun[command.key] == number:
                await home.report(command.key, command.capability, command.value.plain())

        home.tasks.start_soon(arrive)

    for name in MEMBERS:
        await home.new(Light, name, "on_off", before={"on_off": False}, behaviour=fade)
    await anyio.sleep(60.0)
    for _ in range(6):
        for name in MEMBERS:
            stage.begin(name, on_off=True)
        await stage.pause(0.2, 6.0)
        touched = draw.choice(MEMBERS)
        begun[touched] += 1
        await home.report(touched, "on_off", value=True)
        await stage.pause(0.1, 2.0)
        await home.report(touched, "on_off", value=False)
        await anyio.sleep(20.0)
        devices = [(await home.handle(Handle, name)).device for name in MEMBERS]
        commands = {one.id: (await stage.cause(one.name.lower(), "on_off")) for one in devices}
        stage.score.ask("a person in a scene", is_so=commands[devices[MEMBERS.index(touched)].id].cause in PERSON)
        kept = {f"{one.id} on_off": [False, [commands[one.id].command or "none"], True] for one in devices}
        due = {key[0] for key in UndoRecord(kept).due(await known_states(home.app, devices))}
        wanted = {one.id for one in devices if one.name.lower() != touched}
        stage.score.ask("the undo leaves a person's lamp alone", is_so=due <= wanted, told=(touched, due))
        for name in MEMBERS:
            await stage.command(name, on_off=False)
            await anyio.sleep(5.0)
        await stage.pause(60.0, 300.0)


# Devices by themselves


async def drift(stage: Stage) -> None:
    """A blind settles by up to 2 % some 20 s after it has arrived."""
    home, draw = stage.home, stage.random

    async def drive(_: Home, command: Command) -> None:
        target = command.value.plain()
        assert isinstance(target, float)

        async def arrive() -> None:
            await anyio.sleep(draw.uniform(4.0, 12.0))
            await home.report("blind", "position", target)
            await stage.pause(15.0, 25.0)
            await home.report("blind", "position", target + draw.choice((-2.0, -1.0, 1.0, 2.0)))

        home.tasks.start_soon(arrive)

    home.put("blind", "window_covering", "position")
    home.behaviours["blind"] = drive
    await home.report("blind", "position", 100.0)
    await anyio.sleep(60.0)
    for number in range(8):
        outcome = await stage.command("blind", position=float(draw.randrange(10, 45) + 45 * (number % 2)))
        await anyio.sleep(60.0)
        told = await stage.cause("blind", "position")
        stage.score.ask(
            "a blind that settles", is_so=told.cause == "device" and told.command == outcome.command_id, told=told
        )
        await stage.pause(60.0, 600.0)


async def moved_by_hand(stage: Stage) -> None:
    """A person moves a blind by 10 % or more, soon after it has arrived."""
    home, draw = stage.home, stage.random

    async def drive(_: Home, command: Command) -> None:
        home.later(draw.uniform(4.0, 12.0), "blind", "position", command.value.plain())

    home.put("blind", "window_covering", "position")
    home.behaviours["blind"] = drive
    await home.report("blind", "position", 100.0)
    await anyio.sleep(60.0)
    for number in range(8):
        target = float(draw.randrange(20, 45) + 40 * (number % 2))
        await stage.command("blind", position=target)
        await stage.pause(15.0, 60.0)
        await home.report("blind", "position", target + draw.choice((-18.0, -10.0, 10.0, 14.0)))
        await anyio.sleep(5.0)
        told = await stage.cause("blind", "position")
        stage.score.ask("a hand at a blind", is_so=told.cause in PERSON, told=told)
        await stage.pause(60.0, 600.0)


def timer(minutes: float) -> Play:
    """A staircase light turns off so long after it was turned on; it is learnt at the fourth time."""

    async def play(stage: Stage) -> None:
        home, draw = stage.home, stage.random
        await home.lamp("on_off", "level", before={"on_off": False})
        await anyio.sleep(60.0)
        for number in range(8):
            await stage.command("lamp", on_off=True)
            await anyio.sleep(60.0 * minutes + draw.uniform(0.0, 0.3))
            await home.report("lamp", "on_off", value=False)
            await anyio.sleep(5.0)
            told = await stage.cause("lamp", "on_off")
            if number >= 4:
                stage.score.ask("a timer", is_so=told.cause == "device", told=told)
            await stage.pause(100.0, 900.0)

    return play


async def hands_are_no_timer(stage: Stage) -> None:
    """A person turns a lamp off as he leaves, each time after another while."""
    home = stage.home
    await home.lamp("on_off", "level", before={"on_off": False})
    await anyio.sleep(60.0)
    for _ in range(12):
        await stage.command("lamp", on_off=True)
        await stage.pause(60.0, 3600.0)
        await home.report("lamp", "on_off", value=False)
        await anyio.sleep(5.0)
        told = await stage.cause("lamp", "on_off")
        stage.score.ask("a person who leaves", is_so=told.cause in PERSON, told=told)
        await stage.pause(100.0, 900.0)


async def adaptive_lighting(stage: Stage) -> None:
    """Another program changes level and colour temperature of a lamp each 90 s while it is lit, for three hours.

    An app may turn the lamp off: no motion sensor has seen anybody for long.
    """
    home, draw = stage.home, stage.random
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
    await home.report("motion", "occupancy", value=True)
    await anyio.sleep(5.0)
    await home.report("motion", "occupancy", value=False)
    await home.new(Light, "lamp", "on_off", "level", "color_temperature", area="hall", before={"on_off": False})
    await stage.command("lamp", on_off=True)
    level, warmth = 40.0, 2700.0
    for number in range(120):
        await anyio.sleep(90.0 + draw.uniform(-1.5, 1.5))
        level, warmth = level + draw.choice((0.5, 1.0)) * (1 if number < 60 else -1), warmth + draw.choice((10.0, 20.0))
        await home.report("lamp", "color_temperature", warmth)
        if number % 2:
            await home.report("lamp", "level", round(level))
        if number % 10 == 0:
            await home.report("motion", "occupancy", value=False)
        if number >= 20:
            told = await stage.cause("lamp", "color_temperature")
            stage.score.ask("adaptive lighting is a program", is_so=told.cause == "program", told=told)
    outcome = await stage.command("lamp", on_off=False)
    stage.score.ask("an app may turn it off", is_so=not isinstance(outcome, Refused), told=outcome)


async def power_cut(stage: Stage) -> None:
    """A lamp that a robot holds off loses its power, and comes back on; it is commanded again."""
    home = stage.home
    await home.lamp("on_off", "level", before={"on_off": True, "level": 10.0}, behaviour=obey_after(0.3))
    lamp = await home.handle(Handle, "lamp")
    home.gateway.devices.report_reachable("lamp", reachable=True)
    await anyio.sleep(5.0)
    for number in range(5):
        held = await home.hold(hold_request(lamp.device.id, "on_off", value=False, lease=str(number), ttl=3600.0))
        assert isinstance(held, LeaseResponse)
        await stage.pause(60.0, 600.0)
        home.gateway.devices.report_reachable("lamp", reachable=False)
        await stage.pause(20.0, 300.0)
        before = stage.sent()
        home.gateway.devices.report_reachable("lamp", reachable=True)
        await home.report("lamp", "on_off", value=True)
        await anyio.sleep(0.05)
        told = await stage.cause("lamp", "on_off")
        stage.score.ask("after a power cut the cause is unknown", is_so=told.cause == "unknown", told=told)
        await anyio.sleep(15.0)
        stage.score.ask("a held lamp is commanded again", is_so=stage.sent() > before, told=number)
        await anyio.sleep(3700.0)
        await home.report("lamp", "on_off", value=True)
        await stage.pause(60.0, 100.0)


# Restarts


async def restart(stage: Stage) -> None:
    """Homebot ends after commands and hands, and tells the same causes as before once it runs again."""
    store, draw = KeptStore(), stage.random
    told: dict[str, KnownCause] = {}
    for number in range(2):
        async with opened_home(store=store, rate_limit=False, always_ask=False) as home:
            again = Stage(home, draw, stage.score)
            for name in MEMBERS:
                value = told[name].value.plain() if number else False
                await home.new(Light, name, "on_off", before={"on_off": value})
            await anyio.sleep(30.0)
            for name in MEMBERS:
                if number:
                    found = await again.cause(name, "on_off")
                    is_so = (found.cause, found.command) == (told[name].cause, told[name].command)
                    stage.score.ask("a restart forgets no cause", is_so=is_so, told=(found, told[name]))
                    continue
                await again.command(name, on_off=True)
                await again.pause(20.0, 100.0)
                if draw.random() < 0.5:
                    await home.report(name, "on_off", value=False)
                    await anyio.sleep(5.0)
                told[name] = await again.cause(name, "on_off")
            await anyio.sleep(120.0)


async def living(stage: Stage) -> None:
    """Three hours of a house with groups, scenes, timers, mirrored parts, late answers, and persons all over it."""
    from tests.control.timeline.test_house_truth import furnish  # noqa: PLC0415 - its module imports this one's tests

    tables = Tables()
    house = SimulatedHouse(stage.home, stage.random, tables)
    furnish(house)
    await house.run()
    for (_, truth, told), count in tables.told.items():
        for _ in range(count):
            if told == "person":
                stage.score.ask("told person, and it was one", is_so=truth == "person", told=(truth, told))
            if truth == "person":
                stage.score.ask("persons are named", is_so=told == "person", told=(truth, told))
    for kind, count in tables.overridden.items():
        for _ in range(count):
            stage.score.ask("nothing sent over a person", is_so=False, told=kind)
    stage.score.ask("nothing sent over a person", is_so=True)


PLAYS: Final[dict[str, Row]] = {
    **{
        f"group: {brand}, members within {latest:g} s": Row(group_of(brand, latest))
        for brand in ("zigbee2mqtt", "hue", "homeassistant", "deconz")
        for latest in (0.6, 4.0)
    },
    "a fade that a hand cuts": Row(fade_cut_by_hand, {"a person in a fade": 0.98}),
    "a level that comes late": Row(late_level),
    "a scene and a hand": Row(scene_undo),
    "a blind that settles": Row(drift),
    "a blind and a hand": Row(moved_by_hand),
    **{f"a timer of {minutes:g} min": Row(timer(minutes)) for minutes in (5.0, 10.0, 16.0, 30.0, 60.0)},
    "a lamp and a person who leaves": Row(hands_are_no_timer),
    "adaptive lighting": Row(adaptive_lighting, {"adaptive lighting is a program": 0.95}),
    "a power cut": Row(power_cut),
    "a restart": Row(restart),
    "a house that is lived in": Row(living, {"told person, and it was one": 0.95, "persons are named": 0.85}),
}


def score_of(name: str, seeds: Iterable[int]) -> Score:
    """Return the score of one play with some seeds."""
    score = Score()

    async def run(seed: int) -> None:
        async with opened_home(rate_limit=False, always_ask=False, presence_guard=name == "adaptive lighting") as home:
            await PLAYS[name].play(Stage(home, Random(seed), score))  # noqa: S311 - a simulation

    for seed in seeds:
        with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
            runner.run(run(seed))
    return score
