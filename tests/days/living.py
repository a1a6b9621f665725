"""A random day, lived in virtual time, with the truth of the house and all that the journal says."""

import asyncio
from dataclasses import dataclass, field
from datetime import timedelta
from zoneinfo import ZoneInfo

import anyio
from anyio.abc import TaskGroup
from tests.days.random_day import RandomDay, Table
from tests.days.truth import GroundTruth, TruthfulCommand

from homebot.devices import DEVICE_CHANGES, DEVICE_STATES, DeviceChange, Devices, StateChange
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.handles import Handle
from homebot.devices.journal_messages import JournalEntry, ReadJournal, ReadJournalRequest
from homebot.devices.names import JOURNAL_ENTRIES, PERFORM_COMMAND, READ_JOURNAL
from homebot.devices.value import PlainValue, Value
from homebot.graph import Node
from homebot.house import World
from homebot.testing import VirtualHouse, VirtualTimeLoop, virtual_house_of
from homebot.testing.virtual_house import START, parse_time

PERSON = "client:tablet"
_SCOPE = ("read", "act: light", "act: window covering")
_ALL = 1_000_000
_LONGEST_COMMAND = 480.0
"""Seconds after which every command has its outcome."""


@dataclass
class LivedDay:
    """All that is known of a day.

    Attributes:
        commands: The commands that reached devices, in truth.
        entries: The entries of the journal, in order.
        presence: How many people were awake, and how many were there, in each room when each command was judged or sent
            last.
        names: The names of devices by id.
        rooms: The rooms of devices by name.
        reports: The numbers of the directory's changes and reports.
        midnight: Seconds since the Unix epoch at which the day of the house began.
        end: Seconds since the Unix epoch at which the last command was given that must have an outcome.
        crashed: The nodes that crashed.
    """

    commands: list[TruthfulCommand] = field(default_factory=list)
    entries: list[JournalEntry] = field(default_factory=list)
    presence: dict[str, dict[str, tuple[int, int]]] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    rooms: dict[str, str] = field(default_factory=dict)
    reports: set[int] = field(default_factory=set)
    midnight: float = 0.0
    end: float = 0.0
    crashed: tuple[str, ...] = ()


def live(day: RandomDay, *apps: str, has_policies: bool = True, control: Table | None = None) -> LivedDay:
    """Live *day*; with *apps* alone where they are given.

    Args:
        day: The day.
        apps: Each a plug-in's name or ``module:Class``.
        has_policies: Whether its policies are on.
        control: The table ``[control]`` in place of its own: for policies that know less than the oracle.
    """
    ZoneInfo(day.control.get("time_zone", "UTC"))  # is read from its file here, and kept: the loop must not
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(_live(day, apps, (day.control if control is None else control) if has_policies else None))


async def _live(day: RandomDay, apps: tuple[str, ...], control: Table | None) -> LivedDay:
    world = day.day.world()
    truth = GroundTruth(world, day)
    world.event_log = truth
    world.run_until(day.day.start)
    truth.begin()
    # with responses, a command carries its id
    config: dict[str, object] = {"places": day.places, "gateways": {"mqtt": {"responses": True}}}
    if control is not None:
        config["control"] = control
    if not apps:
        config["apps"] = day.apps
    start = parse_time(START) + timedelta(seconds=day.day.start)
    lived = LivedDay(commands=truth.commands, midnight=parse_time(START).timestamp())
    async with (
        virtual_house_of(*apps, world=world, start=start, seed=day.seed, config=config) as house,
        Node(house.runtime.graph, "observer") as observer,
        anyio.create_task_group() as tasks,
    ):
        _observe(lived, observer, world)
        await _read_begin(lived, observer, world)
        if not apps:
            tasks.start_soon(_command, day, observer, tasks)
        await day.day.live(house)
        lived.end = house.clock.now()
        await _end(lived, house, observer)
        tasks.cancel_scope.cancel()
    return lived


async def _read_begin(lived: LivedDay, observer: Node, world: World) -> None:
    """Read what was in the journal before anybody looked."""
    read = observer.create_client(ReadJournal, READ_JOURNAL)
    await read.wait_for_service()
    found = (await read.call(ReadJournalRequest())).entries
    missed = [one for one in found if one not in lived.entries]
    lived.entries[:0] = missed
    for one in missed:
        lived.presence.setdefault(one.command, _presence(lived, world))  # no time has passed since


async def _end(lived: LivedDay, house: VirtualHouse, observer: Node) -> None:
    await house.run_for(_LONGEST_COMMAND)
    lived.names.update({one.id: one.name for one in await Devices(observer).find()})
    lived.crashed = tuple(house.crashed)


def _observe(lived: LivedDay, observer: Node, world: World) -> None:
    lived.rooms.update({name: placed.room for name, placed in world.devices.items()})

    def take_entry(entry: JournalEntry) -> None:
        lived.entries.append(entry)
        if entry.kind in {"judged", "sent", "published"}:
            lived.presence[entry.command] = _presence(lived, world)

    def take_change(change: DeviceChange) -> None:
        lived.names.setdefault(change.device.id, change.device.name)
        lived.reports.add(change.sequence)

    def take_state(change: StateChange) -> None:
        lived.reports.add(change.sequence)

    observer.create_subscription(JournalEntry, JOURNAL_ENTRIES, take_entry, _ALL)
    observer.create_subscription(DeviceChange, DEVICE_CHANGES, take_change, _ALL)
    observer.create_subscription(StateChange, DEVICE_STATES, take_state, _ALL)


def _presence(lived: LivedDay, world: World) -> dict[str, tuple[int, int]]:
    """Return how many are awake, and how many there are, in each room that has a device."""
    return {room: (world.awake_in(room), len(world.people_in(room))) for room in set(lived.rooms.values())}


async def _command(day: RandomDay, observer: Node, tasks: TaskGroup) -> None:
    """Give the commands of the person."""
    begin = anyio.current_time()
    for at, device, capability, value in sorted(day.orders, key=lambda one: one[0]):
        await anyio.sleep_until(begin + at)
        tasks.start_soon(_wish, observer, device, capability, value)


async def _wish(observer: Node, device: str, capability: str, value: PlainValue) -> None:
    control = observer.create_client(PerformCommand, PERFORM_COMMAND)
    for handle in await Devices(observer).find(Handle):
        if handle.device.name == device and handle.can(capability):
            setting = Setting(capability=capability, value=Value.of(value))
            await control.call(
                CommandRequest(
                    device=handle.device.id, part=handle.part_id, settings=(setting,), issuer=PERSON, scope=_SCOPE
                ),
                timeout=900,
            )
