"""A house on a memory gateway: groups, scenes, timers, mirrored parts, late answers and persons, with the true causes.

Everything runs through the real control layer in virtual time, and is a function of a seed. What homebot told is read
from its journal.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Callable, Coroutine, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from random import Random
from typing import Literal, TypeAlias

import anyio
from tests.control.conftest import Behaviour, Home

from homebot.devices.capabilities import SETTABLE
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle
from homebot.devices.journal_messages import (
    ExplainDevice,
    ExplainDeviceRequest,
    GetCauses,
    GetCausesRequest,
    JournalEntry,
)
from homebot.devices.names import EXPLAIN_DEVICE, GET_CAUSES, JOURNAL_ENTRIES, PERFORM_COMMAND
from homebot.devices.outcomes import Outcome
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice

Truth: TypeAlias = Literal["command", "along", "device", "program", "away", "person"]
"""``along``: the effect of a command to another part: a group, a scene, a mirrored part; ``away``: what a device tells
after nobody could see it, so that nobody can know."""

_SAME = 0.4
"""Seconds by which a change and its entry in the journal may differ."""

_INDISTINCT = 1.0
"""Seconds around the end of a timer within which nobody can tell a person from it."""

_ON_OFF = (False, True)


@dataclass(frozen=True, slots=True)
class TrueChange:
    """A change that a part reported, with its true cause, and the kind of its part."""

    at: float
    place: tuple[str, str]
    capability: str
    value: PlainValue
    truth: Truth
    kind: str


@dataclass(slots=True)
class Tables:
    """Counts over many houses.

    Attributes:
        told: How often a change of a kind with a true cause was told to have another one.
        commands: The number of commands.
        overridden: Repetitions after a person had changed the part, by kind.
        seen: How often something else was seen, by its name.
        notes: What was wrong, each as a line.
    """

    told: Counter[tuple[str, Truth, str]] = field(default_factory=Counter)
    commands: int = 0
    overridden: Counter[str] = field(default_factory=Counter)
    seen: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)

    def add(self, other: Tables) -> None:
        """Add the counts of other houses."""
        self.told += other.told
        self.commands += other.commands
        self.overridden += other.overridden
        self.seen += other.seen

    @property
    def wrong_persons(self) -> float:
        """The share of none among the changes that were told to be a person's."""
        return 1.0 - self.count(truth="person", told="person") / max(self.count(told="person"), 1)

    def share(self, truth: Truth, told: str, kind: str = "") -> float:
        """Return the share of the changes with a true cause that were told to have the cause *told*."""
        return self.count(kind, truth, told) / max(self.count(kind, truth), 1)

    def count(self, kind: str = "", truth: str = "", told: str = "") -> int:
        """Return how many changes fit; an empty text fits all."""
        wanted = kind, truth, told
        return sum(
            number
            for found, number in self.told.items()
            if all(one in ("", other) for one, other in zip(wanted, found, strict=True))
        )

    def text(self) -> str:
        """Return the tables as text."""
        causes = ("command", "transition", "device", "program", "unknown", "person", "nothing")
        lines = [f"{'kind and truth':30}" + "".join(f"{one:>12}" for one in causes)]
        for kind, truth in sorted({(kind, truth) for kind, truth, _ in self.told}):
            numbers = "".join(f"{self.told[kind, truth, cause]:12,}" for cause in causes)
            lines.append(f"{f'{kind}: {truth}':30}{numbers}")
        lines += [
            f"{f'all: {truth}':30}" + "".join(f"{self.count('', truth, one):12,}" for one in causes)
            for truth in ("command", "along", "device", "program", "away", "person")
        ]
        lines.append(f"commands: {self.commands:,}; repeated over a person: {dict(self.overridden)}")
        named = self.share("person", "person")
        lines.append(f"told person and none: {self.wrong_persons:.1%}; persons named: {named:.1%}")
        return "\n".join(lines)


class SimulatedHouse:
    """The devices of one house, its app and its persons.

    Args:
        hours: How long it is watched.
        hand_every: The mean seconds between two changes by persons.
    """

    def __init__(
        self, home: Home, random: Random, tables: Tables, hours: float = 3.0, hand_every: float = 60.0
    ) -> None:
        self.random, self.tables = random, tables
        self.until, self.hand_every = hours * 3600.0, hand_every
        self._wanted: dict[tuple[str, str], tuple[float, PlainValue]] = {}
        self.changes: list[TrueChange] = []
        self.entries = defaultdict[tuple[str, str], list[JournalEntry]](list)
        self.values: dict[tuple[str, str, str], PlainValue] = {}
        self.kinds: dict[str, str] = {}
        self._number: Counter[str] = Counter()  # of the newest event of a part: it ends what had begun
        self._touched: dict[str, float] = defaultdict(lambda: -math.inf)
        self._given: dict[str, float] = {}
        self.members: dict[str, tuple[str, ...]] = {}
        self.watchers: list[Callable[[TrueChange], object]] = []
        self.restarts = 0
        self.physical: dict[tuple[str, str, str], PlainValue] = {}
        self.is_away = False
        self.dark: set[str] = set()
        self._at_entry: list[Callable[[Home], object]] = []
        self.ids: dict[str, str] = {}
        self.timer_at: dict[str, float] = {}
        self.loops: list[Callable[[], Coroutine[None, None, None]]] = []
        self._persons: list[tuple[str, str, tuple[PlainValue, ...]]] = []
        self._devices: dict[str, GatewayDevice] = {}
        self._behaviours: dict[str, Behaviour] = {}
        self.enter(home)

    def enter(self, home: Home) -> None:
        """Live with a homebot from now on: the first, or that after a restart, which finds the devices as they are."""
        self.home = home
        home.app.create_subscription(JournalEntry, JOURNAL_ENTRIES, self._on_entry, 100_000)
        home.behaviours.update(self._behaviours)
        for device in self._devices.values():
            home.gateway.devices.put(device, "the test says so")
        for act in self._at_entry:
            act(home)

    def on_enter(self, act: Callable[[Home], object]) -> None:
        """Let *act* be done now, and after each restart."""
        self._at_entry.append(act)
        act(self.home)

    # What there is

    def put(
        self,
        key: str,
        kind: str,
        settings: Mapping[str, tuple[PlainValue, ...]],
        *,
        area: str,
        members: tuple[str, ...] = (),
        parts: tuple[str, ...] = ("",),
        is_write_only: bool = False,
        service_type: str = "light",
        echoed: tuple[str, ...] = (),
        fades: bool = False,
    ) -> None:
        """Let there be a device, at which persons set each of the settings with several values."""
        found = []
        for part_id in parts:
            capabilities = tuple(
                Capability(name=one, settable=True, readable=not is_write_only, echoed=one in echoed)
                for one in settings
            )
            part = Part(id=part_id, service_type=service_type, capabilities=capabilities, fades=fades)
            if members and "members" in Part.model_fields:
                part = part.model_copy(update={"members": members})
            found.append(part)
        device = GatewayDevice(key, key.title(), tuple(found), area=area, identifiers=(f"id:{key}",))
        self._devices[key] = device
        self.home.gateway.devices.put(device, "the test says so")
        self.members[key] = tuple(one.removeprefix("id:") for one in members)
        self.kinds[key] = kind
        for capability, values in settings.items():
            if len(values) > 1 and not is_write_only:
                for part_id in parts:
                    self.values[key, part_id, capability] = values[0]
                self._persons.append((key, capability, values))

    def plain(self, key: str, area: str, low: float = 0.02, high: float = 0.4, kind: str = "lamp") -> None:
        """A lamp that obeys by itself, in a room."""
        self.put(key, kind, {"on_off": _ON_OFF}, area=area)
        self.behave(key, partial(self.obey, low, high))

    def group(self, key: str, area: str, lamps: int, *, is_listed: bool, low: float = 0.02, high: float = 0.6) -> None:
        """A group that reports, and whose lamps report each for itself."""
        names = tuple(f"{key}-{number}" for number in range(lamps))
        for name in names:
            self.plain(name, area, kind="member" if is_listed else "unlisted member")
        listed = tuple(f"id:{name}" for name in names) if is_listed else ()
        self.put(key, "group", {"on_off": (False,)}, area="" if is_listed else area, members=listed)
        self.values[key, "", "on_off"] = False

        async def obey(_: Home, command: Command) -> None:
            value = command.value.plain()
            self.later(self.random.uniform(0.01, 0.1), key, "", "on_off", value, "command")
            for name in names:
                self.later(self.random.uniform(low, high), name, "", "on_off", value, "along")

        self.behave(key, obey)
        self.drive(key, "", "on_off", _ON_OFF, 60.0, 400.0)

    def scene(self, key: str, area: str, lamps: int, *, is_listed: bool) -> None:
        """A scene, which can only be activated, and its lamps."""
        names = tuple(f"{key}-{number}" for number in range(lamps))
        wanted = {name: self.random.choice(_ON_OFF) for name in names}
        for name in names:
            self.plain(name, area, kind="lamp of a scene" if is_listed else "lamp of an unlisted scene")
        listed = tuple(f"id:{name}" for name in names) if is_listed else ()
        self.put(key, "scene", {"press": ("push",)}, area=area, members=listed, is_write_only=True)

        async def obey(_: Home, __: Command) -> None:
            for name in names:
                self.later(self.random.uniform(0.05, 1.2), name, "", "on_off", wanted[name], "along")

        self.behave(key, obey)
        self.drive(key, "", "press", ("push",), 90.0, 500.0)

    def mirrored(self, key: str, area: str) -> None:
        """Two parts that show one relay."""
        self.put(key, "mirrored", {"on_off": _ON_OFF}, area=area, parts=("relay", "light"))

        async def obey(_: Home, command: Command) -> None:
            number = None
            truths: tuple[tuple[str, Truth], ...] = (("relay", "command"), ("light", "along"))
            for part, truth in truths:
                after = self.random.uniform(0.02, 0.5)
                number = self.later(after, key, part, "on_off", command.value.plain(), truth, number=number)

        self.behave(key, obey)
        self.drive(key, "relay", "on_off", _ON_OFF, 30.0, 300.0)

    def timer(self, key: str, area: str, seconds: float) -> None:
        """A staircase light: it turns off by itself."""
        self.put(key, "timer", {"on_off": _ON_OFF}, area=area)

        async def obey(_: Home, command: Command) -> None:
            value, after = command.value.plain(), self.random.uniform(0.02, 0.3)
            number = self.later(after, key, "", "on_off", value, "command")
            if value:
                self.timer_at[key] = self.now() + seconds
                jitter = self.random.uniform(0.0, 0.15)
                self.later(after + seconds + jitter, key, "", "on_off", value=False, truth="device", number=number)

        self.behave(key, obey)
        self.drive(key, "", "on_off", (True,), 1.2 * seconds + 20.0, 1.6 * seconds + 120.0)

    def late(self, key: str, area: str) -> None:
        """A battery valve that wakes up every few minutes."""
        values = (17.0, 19.0, 21.0, 22.5)
        by_persons = (16.0, 18.0, 20.0, 24.0)
        self.put(key, "late", {"heating_setpoint": by_persons}, area=area)

        async def obey(_: Home, command: Command) -> None:
            if not command.repeated:
                after = self.random.uniform(120.0, 880.0)
                self.later(after, key, "", "heating_setpoint", command.value.plain(), "command")

        self.behave(key, obey)
        self.drive(key, "", "heating_setpoint", values, 1000.0, 1500.0)

    def slow(self, key: str, area: str) -> None:
        """A lamp that is commanded, and now and then does not hear it."""
        self.plain(key, area, 0.1, 6.0, kind="slow")
        self.drive(key, "", "on_off", _ON_OFF, 30.0, 200.0)

    def commanded(self, key: str, area: str) -> None:
        """A lamp that is commanded by itself."""
        self.plain(key, area)
        self.drive(key, "", "on_off", _ON_OFF, 30.0, 200.0)

    # What happens

    def drive(
        self, key: str, part: str, capability: str, values: tuple[PlainValue, ...], shortest: float, longest: float
    ) -> None:
        """Let the app command a part again and again."""

        async def run() -> None:
            while True:
                await anyio.sleep(self.random.uniform(shortest, longest))
                now = self.values.get((key, part, capability))
                choice = [one for one in values if one != now] or list(values)
                self.home.tasks.start_soon(self.command, key, part, capability, self.random.choice(choice))
                if self.random.random() < 0.15:
                    self.home.tasks.start_soon(self._reject, key)

        self.loops.append(run)

    async def run(self) -> None:
        """Live for the hours, and count what was told."""
        await anyio.sleep(1.0)
        self.ids = {one.name.lower(): one.device.id for one in await self.home.devices.find(Handle)}
        for (key, part, capability), value in tuple(self.values.items()):
            await self.home.gateway.devices.report(key, {capability: value}, part, retained=self.restarts > 0)
        await anyio.sleep(5.0 if self.restarts else 2000.0)
        for loop in (*self.loops, self._live):
            self.home.tasks.start_soon(loop)
        began = self.now()
        await anyio.sleep(self.until)
        ended = self.now() - 5.0
        await anyio.sleep(5.0)
        self._count([one for one in self.changes if began <= one.at <= ended and one.capability in SETTABLE])
        self.restarts += 1

    async def _live(self) -> None:
        """Let persons change things all over the house."""
        while True:
            await anyio.sleep(self.random.expovariate(1.0 / self.hand_every))
            if self._persons:
                self.touch(*self.random.choice(self._persons))

    async def _reject(self, key: str) -> None:
        """Let a person undo or change what was commanded, soon."""
        await anyio.sleep(self.random.uniform(0.5, 40.0))
        found = [one for one in self._persons if one[0] == key]
        if found:
            self.touch(*found[0])

    def touch(self, key: str, capability: str, values: tuple[PlainValue, ...]) -> None:
        if key in self.dark or abs(self.now() - self.timer_at.get(key, -math.inf)) < _INDISTINCT:
            return
        parts = [part for name, part, one in self.values if (name, one) == (key, capability)]
        value = self.random.choice([one for one in values if one != self.values[key, parts[0], capability]])
        if self._agrees(key, parts[0], capability, value):
            return
        after = self.random.uniform(0.02, 0.3)
        number = None
        for part in parts:  # a person at a mirrored relay changes both
            number = self.later(after, key, part, capability, value, "person", number=number)

    def _agrees(self, key: str, part: str, capability: str, value: PlainValue) -> bool:
        """Return whether a person does what the newest command wants, so that nobody can tell who did it."""
        given, wanted = self._wanted.get((key, capability), (-math.inf, None))
        is_new = self.now() - given < _AGREES_FOR
        return is_new and _is_on_the_way(self.values[key, part, capability], value, wanted)

    async def command(self, key: str, part: str, capability: str, value: PlainValue) -> None:
        await self.give(key, {capability: value}, part)

    async def give(
        self, key: str, values: Mapping[str, PlainValue], part: str = "", transition: float = 0.0
    ) -> Outcome:
        """Let the app command a part, and return what became of it."""
        self.tables.commands += 1
        self._given[key] = self.now()
        for name in (key, *self.members[key]):
            self._wanted |= {(name, capability): (self.now(), value) for capability, value in values.items()}
        settings = tuple(Setting.of(capability, value) for capability, value in values.items())
        request = CommandRequest(
            device=self.ids[key], part=part, settings=settings, issuer="/app", transition=transition
        )
        return await self.home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=1000.0)

    def behave(self, key: str, behaviour: Behaviour) -> None:
        async def behave(home: Home, command: Command) -> None:
            self._count_overridden(command)
            await behaviour(home, command)

        self._behaviours[key] = self.home.behaviours[key] = behave

    async def obey(self, low: float, high: float, _: Home, command: Command) -> None:
        self.later(
            self.random.uniform(low, high),
            command.key,
            command.part,
            command.capability,
            command.value.plain(),
            "command",
        )

    def later(
        self,
        seconds: float,
        key: str,
        part: str,
        capability: str,
        value: PlainValue,
        truth: Truth,
        *,
        number: int | None = None,
    ) -> int:
        """Let a part report, unless something newer happens to its device first; return the number of the event."""
        if number is None:
            self._number[key] += 1
            number = self._number[key]
        self.home.tasks.start_soon(self._report, seconds, (key, part, capability), value, truth, number)
        return number

    def is_touched_since(self, key: str, at: float) -> bool:
        """Return whether a person changed a device later than *at*."""
        return self._touched[key] > at

    def newest_number(self, key: str) -> int:
        """Return the number for further events of a device that end none."""
        return self._number[key]

    async def tell_again(self, key: str) -> None:
        """Let a device tell how it is, after nobody could see it."""
        for place, value in self.physical.items():
            if place[0] == key and self.values[place] != value:
                self.later(0.0, *place, value=value, truth="away", number=self._number[key])
            elif place[0] == key:
                await self.home.gateway.devices.report(key, {place[2]: value}, place[1])

    async def _report(
        self, seconds: float, place: tuple[str, str, str], value: PlainValue, truth: Truth, number: int
    ) -> None:
        await anyio.sleep(seconds)
        key, part, capability = place
        if self._number[key] != number or (truth == "person" and self._agrees(*place, value)):
            return
        self.physical[place] = value
        if self.is_away:
            return
        if self.values.get(place) != value:
            change = TrueChange(self.now(), (key, part), capability, value, truth, self.kinds[key])
            self.changes.append(change)
            self.values[place] = value
            for watch in self.watchers:
                watch(change)
        self.values[place] = value
        if truth == "person":
            self._touched[key] = self.now()
        await self.home.gateway.devices.report(key, {capability: value}, part)

    def now(self) -> float:
        return self.home.graph.clock.now()

    def watch_answers(self) -> None:
        """Ask everybody who knows a cause about each change, and compare."""
        if not self.restarts:
            self.watchers.append(lambda change: self.home.tasks.start_soon(self._ask, change))

    async def _ask(self, change: TrueChange) -> None:
        newest = len(self.changes)
        await anyio.sleep(_ASKED_AFTER)
        key, part = change.place
        if any(one.place[0] == key for one in self.changes[newest:]) or key not in self.ids:
            return
        told = self.told_of(change)
        request = GetCausesRequest(devices=(self.ids[key],))
        known = await self.home.app.create_client(GetCauses, GET_CAUSES).call(request)
        causes = [one for one in known.causes if (one.part, one.capability) == (part, change.capability)]
        explained = await self.home.app.create_client(ExplainDevice, EXPLAIN_DEVICE).call(
            ExplainDeviceRequest(device=self.ids[key])
        )
        answers = {"journal": told, "why": _best(explained.entries, change)}
        for one in causes:
            is_same = one.value.plain() == change.value and one.may_be_person == (one.cause in ("person", "unknown"))
            answers["causes"] = one.cause if is_same else f"{one.value.plain()} by {one.cause}, {one.may_be_person=}"
        is_same = len({answer for answer in answers.values() if answer != "nothing"}) <= 1
        self.tables.seen["asked"] += 1
        if not is_same:
            self.tables.seen["two answers"] += 1
            self.tables.notes.append(f"two answers about {change}: {answers}")

    def _on_entry(self, entry: JournalEntry) -> None:
        self.entries[entry.device, entry.part].append(entry)

    def told_of(self, change: TrueChange) -> str:
        """Return the cause that the journal tells of a change; ``nothing`` for none."""
        key, part = change.place
        return _best(self.entries[self.ids[key], part], change)

    def _count(self, changes: list[TrueChange]) -> None:
        for one in changes:
            told = self.told_of(one)
            self.tables.told[one.kind, one.truth, told] += 1
            if told not in (*_RIGHT[one.truth], "nothing"):
                self.tables.notes.append(f"{one} is told {told}")

    def _count_overridden(self, command: Command) -> None:
        """Count what is sent after a person had changed the part, or one of its members, since the app gave it."""
        touched = max(self._touched[one] for one in (command.key, *self.members[command.key]))
        if touched > self._given.get(command.key, math.inf):
            self.tables.overridden[self.kinds[command.key]] += 1
            self.tables.notes.append(f"{self.now():.2f} sent over a person of {touched:.2f}: {command}")


_ASKED_AFTER = 13.0
_AGREES_FOR = 90.0
"""Seconds after a command, which may have failed, for which nobody can tell a person who does the same."""


_BY_COMMAND = ("command", "transition", "echo")

_RIGHT: Mapping[Truth, tuple[str, ...]] = {
    "command": ("command", "transition"),
    "along": ("command", "transition"),
    "device": ("device", "unknown"),
    "program": ("program", "unknown"),
    "away": ("unknown",),
    "person": ("person", "unknown"),
}
"""The causes that may be told of a change."""

_WEIGHT = {
    "nothing": 0,
    "": 1,
    "echo": 2,
    "unknown": 3,
    "transition": 4,
    "program": 5,
    "device": 6,
    "person": 7,
    "command": 8,
}


def _is_on_the_way(begun: PlainValue, value: PlainValue, wanted: PlainValue) -> bool:
    if isinstance(begun, float) and isinstance(value, float) and isinstance(wanted, float):
        return min(begun, wanted) - 3.0 <= value <= max(begun, wanted) + 3.0
    return value == wanted


def _best(entries: Iterable[JournalEntry], change: TrueChange) -> str:
    """Return the cause that *entries* tell of a change; ``nothing`` for none."""
    found = [_told(one, change) for one in entries if one.kind in {"reported", "changed", "reverted"}]
    return max(found, key=_WEIGHT.__getitem__, default="nothing")


def _told(entry: JournalEntry, change: TrueChange) -> str:
    """Return the cause that *entry* tells of *change*; ``nothing`` if it is about another one."""
    if abs(entry.at.to_seconds() - change.at) > _SAME:
        return "nothing"
    settings = [(one.capability, one.value.plain()) for one in entry.settings]
    return entry.cause if (change.capability, change.value) in settings else "nothing"
