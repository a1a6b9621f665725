"""Plays between commands, persons, devices and programs: each report has one cause, whoever asks; in virtual time.

After each play the journal, ``why``, the guard, the preview that goals ask, the service of causes, an app, an undo, an
identification, habits and the number of messages are compared; also a homebot after a restart, and a lease, if it held
what the play commands.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, hold_request, obey_after, report
from tests.control.kept_store import KeptStore
from tests.control.test_explanations import explain

from homebot.command_words.undo_record import UndoRecord, known_states
from homebot.devices import Device
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle, HandleChange, Light
from homebot.devices.journal_messages import GetCauses, GetCausesRequest, JournalEntry, KnownCause
from homebot.devices.names import GET_CAUSES, PERFORM_COMMAND
from homebot.devices.outcomes import Outcome, Refused
from homebot.devices.value import PlainValue, SetBy
from homebot.features.habits.recorded import is_persons
from homebot.features.identify.candidates import CandidatePart
from homebot.features.identify.saved_values import SavedValues

pytestmark = pytest.mark.virtual_time

_MAX_MESSAGE_S = 0.01
"""Entries of the journal that differ by less are about one report."""


class Commanding(Protocol):
    """Commands the device of a play: a handle, or a lease."""

    async def command(self, capability: str, value: PlainValue, /) -> object: ...


Act: TypeAlias = Callable[[Home, Commanding], Awaitable[object]]


class Play(NamedTuple):
    """A play at one device.

    Attributes:
        settable: Its capabilities.
        before: Its values long before.
        act: The play.
        of: The capability whose last change is asked about.
        cause: The true cause, as the journal may tell it.
        messages: How many messages the device may get at most.
    """

    service_type: str
    settable: tuple[str, ...]
    before: dict[str, PlainValue]
    act: Act
    of: str
    cause: frozenset[str]
    messages: int = 1


PERSON = frozenset({"person", "unknown"})
COMMAND = frozenset({"command", "transition"})
DEVICE = frozenset({"device"})
SETTERS: tuple[SetBy, ...] = ("person", "program")
LIGHT: dict[str, PlainValue] = {"on_off": False, "level": 10.0}
BLIND: dict[str, PlainValue] = {"position": 100.0}


async def _turn_on(home: Home, lamp: Commanding) -> None:
    await lamp.command("on_off", True)


async def _at_the_switch(home: Home, lamp: Commanding) -> None:
    await home.report("lamp", "on_off", True)


def _switch_after(seconds: float) -> Act:
    """Turn the lamp on by a command, and off by hand so long after."""

    async def act(home: Home, lamp: Commanding) -> None:
        home.tasks.start_soon(lamp.command, "on_off", True)
        await anyio.sleep(seconds)
        await home.report("lamp", "on_off", False)

    return act


async def _set(home: Home, **settings: PlainValue) -> Outcome:
    client = home.app.create_client(PerformCommand, PERFORM_COMMAND)
    wanted = tuple(Setting.of(name, value) for name, value in settings.items())
    return await client.call(CommandRequest(device="lamp", settings=wanted, issuer="/app"), timeout=900)


def _as_home_assistant_knows(seconds: float, set_by: SetBy) -> Act:
    """Turn the lamp on by a command, and off so long after by whoever Home Assistant names."""

    async def act(home: Home, lamp: Commanding) -> None:
        await lamp.command("on_off", True)
        await anyio.sleep(seconds)
        await home.gateway.devices.report("lamp", {"on_off": False}, set_by=set_by)

    return act


def _cut_fade(seconds: float) -> Act:
    """Command two values; the lamp fades, and a person turns it off before the level has come."""

    async def fade(home: Home, command: Command) -> None:
        if len(home.commands) == 1:
            await home.report("lamp", "on_off", True)
            for step in range(1, 5):
                if step < seconds:
                    home.later(float(step), "lamp", "level", 10.0 + 15.0 * step)

    async def act(home: Home, lamp: Commanding) -> None:
        home.behaviours["lamp"] = fade
        home.begin(lambda: _set(home, on_off=True, level=80.0))
        await anyio.sleep(seconds)
        await home.report("lamp", "on_off", False)

    return act


def _drift(wanted: float, seen: float, seconds: float) -> Act:
    """Let the blind settle a little beside its goal, so long after the command."""

    async def act(home: Home, blind: Commanding) -> None:
        await blind.command("position", wanted)
        await anyio.sleep(seconds)
        await home.report("lamp", "position", seen)

    return act


def _timer(seconds: float, times: int) -> Act:
    async def act(home: Home, lamp: Commanding) -> None:
        for _ in range(times):
            await lamp.command("on_off", True)
            await anyio.sleep(seconds)
            await home.report("lamp", "on_off", False)
            await anyio.sleep(seconds / 7.0)

    return act


async def _power_cut(home: Home, lamp: Commanding) -> None:
    """After the cut the lamp is on, as many are."""
    home.gateway.devices.report_reachable("lamp", reachable=True)
    await lamp.command("on_off", False)
    await anyio.sleep(120)
    home.gateway.devices.report_reachable("lamp", reachable=False)
    await anyio.sleep(60)
    home.gateway.devices.report_reachable("lamp", reachable=True)
    await home.report("lamp", "on_off", True)


async def _move_by_hand(home: Home, blind: Commanding) -> None:
    await blind.command("position", 20.0)
    await anyio.sleep(300)
    await home.report("lamp", "position", 60.0)


async def _slow(home: Home, lamp: Commanding) -> None:
    home.behaviours["lamp"] = obey_after(4.0)
    await lamp.command("on_off", True)


async def _echo_and_obey(home: Home, lamp: Commanding) -> None:
    home.behaviours["lamp"] = report((0.02, True), (1.0, True))
    await lamp.command("on_off", True)


async def _dim_by_hand(home: Home, lamp: Commanding) -> None:
    """Dim the lamp by hand before it answers the second command, which replaces a value of the first."""
    await _set(home, on_off=True, level=50.0)
    home.behaviours["lamp"] = report()
    home.tasks.start_soon(lamp.command, "level", 80.0)
    await anyio.sleep(0.5)
    await home.report("lamp", "level", 20.0)


async def _turn_on_by_level(home: Home, command: Command) -> None:
    await home.report("lamp", "level", 50.0)
    await home.report("lamp", "on_off", True)


async def _switch_off_what_a_level_turned_on(home: Home, lamp: Commanding) -> None:
    home.behaviours["lamp"] = _turn_on_by_level
    await lamp.command("level", 50.0)
    await anyio.sleep(5)
    await home.report("lamp", "on_off", False)


async def _switch_off_what_answered_late(home: Home, lamp: Commanding) -> None:
    home.behaviours["lamp"] = report()
    await lamp.command("on_off", True)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(5)
    await home.report("lamp", "on_off", False)


PLAYS = {
    "a command": Play("light", ("on_off", "level"), LIGHT, _turn_on, "on_off", COMMAND),
    "a slow lamp": Play("light", ("on_off", "level"), LIGHT, _slow, "on_off", COMMAND, 3),
    "an echo": Play("light", ("on_off", "level"), LIGHT, _echo_and_obey, "on_off", COMMAND),
    "a switch": Play("light", ("on_off", "level"), LIGHT, _at_the_switch, "on_off", PERSON, 0),
    **{
        f"a switch {seconds} s after a command": Play(
            "light", ("on_off", "level"), LIGHT, _switch_after(seconds), "on_off", PERSON
        )
        for seconds in (
            0.1,
            0.3,
            0.6,
            0.9,
            1.2,
            1.5,
            2.0,
            2.5,
            3.5,
            5.0,
            7.0,
            9.0,
            12.0,
            15.0,
            30.0,
            60.0,
            120.0,
            600.0,
        )
    },
    **{
        f"a fade cut after {seconds} s": Play(
            "light", ("on_off", "level"), LIGHT, _cut_fade(seconds), "on_off", PERSON, 2
        )
        for seconds in (0.4, 0.9, 1.6, 2.4, 3.3, 4.2)
    },
    **{
        f"a blind that settles by {abs(seen - wanted)} % after {seconds} s": Play(
            "window_covering", ("position",), BLIND, _drift(wanted, seen, seconds), "position", DEVICE
        )
        for wanted, seen, seconds in ((0.0, 1.0, 20.0), (50.0, 48.0, 20.0), (50.0, 49.0, 45.0), (30.0, 31.0, 120.0))
    },
    **{
        f"a timer of {seconds / 60.0:g} min": Play(
            "light", ("on_off", "level"), LIGHT, _timer(seconds, 24), "on_off", DEVICE, 24
        )
        for seconds in (60.0, 300.0, 900.0, 1200.0, 1800.0, 3600.0)
    },
    **{
        f"a {set_by} in Home Assistant {seconds} s after a command": Play(
            "light",
            ("on_off", "level"),
            LIGHT,
            _as_home_assistant_knows(seconds, set_by),
            "on_off",
            frozenset({str(set_by)}),
        )
        for set_by in SETTERS
        for seconds in (0.5, 5.0, 60.0)
    },
    "a blind moved by hand": Play("window_covering", ("position",), BLIND, _move_by_hand, "position", PERSON),
    "a hand at the dimmer between two commands": Play(
        "light", ("on_off", "level"), LIGHT, _dim_by_hand, "level", PERSON, 3
    ),
    "a lamp that a level turned on and a person off": Play(
        "light", ("on_off", "level"), LIGHT, _switch_off_what_a_level_turned_on, "on_off", PERSON
    ),
    "a lamp that answered late and a person off": Play(
        "light", ("on_off", "level"), LIGHT, _switch_off_what_answered_late, "on_off", PERSON, 4
    ),
    "a power cut": Play(
        "light", ("on_off", "level"), {"on_off": True, "level": 10.0}, _power_cut, "on_off", frozenset({"unknown"})
    ),
}


@pytest.mark.parametrize("play", PLAYS.values(), ids=PLAYS)
async def test_all_readers_are_told_the_same_cause_and_no_person_is_overridden(open_home: OpenHome, play: Play) -> None:
    async with open_home(presence_guard=True) as home:
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        await (await home.new(Light, "other", "on_off", area="hall")).turn_off()  # the guard looks from now on
        kind, settable = play.service_type, play.settable
        part = await home.new(Handle, "lamp", *settable, before=play.before, service_type=kind, area="hall")
        await anyio.sleep(1)
        await home.report("motion", "occupancy", True)
        await anyio.sleep(1)
        await home.report("motion", "occupancy", False)
        home.tasks.start_soon(_say_clear, home)
        await anyio.sleep(1500)
        changes: list[HandleChange[Handle]] = []
        home.tasks.start_soon(_follow, home, play.of, changes)
        await anyio.sleep(1)
        sent_before = len(home.commands)
        await play.act(home, part)
        await anyio.sleep(15)
        assert len(home.commands) - sent_before <= play.messages
        told = [one for one in (await home.read()).entries if one.device == "lamp" and _cause(one, play.of)]
        assert _cause(told[-1], play.of) in play.cause
        newest = await _cause_of(home, play)
        last = [one for one in told if told[-1].at.to_seconds() - one.at.to_seconds() < _MAX_MESSAGE_S]
        assert {_cause(one, play.of) for one in last} == {newest.cause}
        assert newest.may_be_person == (play.cause <= PERSON)
        assert newest.cause in play.cause
        assert await changes[-1].cause(play.of) == newest
        before, now = changes[-1].before[play.of], newest.value.plain()
        assert part.value(play.of) == now != before
        lamp = (await home.handle(Handle, "lamp")).device
        undo = UndoRecord({f"{lamp.id} {play.of}": [before, [newest.command or "another"], now]})
        is_undone = bool(undo.due(await known_states(home.app, [lamp], from_journal=True)))
        assert is_undone == (bool(newest.command) and newest.cause not in {"person", "unknown", "program"})
        assert is_persons(told[-1]) == (newest.cause == "person")
        assert await _leaves_as_it_is(home, lamp, play.of, before) == (play.cause <= PERSON)
        why = await explain(home, "lamp")
        has_obeyed = why.finding == "command" and _outcome(why.entries) in {"", "confirmed"}
        assert has_obeyed if play.cause <= COMMAND else not (has_obeyed and play.cause <= PERSON)
        annoying = CommandRequest(device="lamp", settings=(Setting.of(*_annoying(play)),), issuer="/app")
        assert isinstance(home.control.preview(annoying, lamp, lamp.parts[0]), Refused) == (play.cause <= PERSON)
        guard = await (await home.handle(Handle, "lamp")).command(*_annoying(play))
        assert isinstance(guard, Refused) == (play.cause <= PERSON)


@pytest.mark.parametrize("play", PLAYS.values(), ids=PLAYS)
async def test_a_restart_forgets_no_cause(open_home: OpenHome, play: Play) -> None:
    store = KeptStore()
    async with open_home(store=store) as home:
        part = await home.new(Handle, "lamp", *play.settable, before=play.before, service_type=play.service_type)
        await anyio.sleep(1000)
        await play.act(home, part)
        await anyio.sleep(15)
        before = await _cause_of(home, play)
    async with open_home(store=store) as home:
        home.put("lamp", play.service_type, *play.settable)
        await home.report("lamp", play.of, before.value.plain())
        assert await _cause_of(home, play) == before


HELD = (
    *[name for name in PLAYS if " after a command" in name or "settles" in name],
    *("a command", "a slow lamp", "an echo", "a blind moved by hand", "a power cut"),
    "a lamp that answered late and a person off",
)
"""The plays whose only command can be that of a lease."""


@pytest.mark.parametrize("play", [PLAYS[name] for name in HELD], ids=HELD)
async def test_a_lease_in_a_play_yields_only_to_a_person_or_program(open_home: OpenHome, play: Play) -> None:
    """Nobody may stand at a lamp that has lost its power, whatever it reports after that."""
    async with open_home() as home:
        kind = play.service_type
        await home.new(Handle, "lamp", *play.settable, before=play.before, service_type=kind)
        await anyio.sleep(1000)
        await play.act(home, _Holder(home))
        await anyio.sleep(15)
        (held,) = await home.leases()
        assert bool(held.saw) == bool(play.cause & {"person", "program"})
        assert len(home.commands) <= play.messages + (play.cause == {"unknown"})  # only the power cut is made good


class _Holder:
    """Holds for an hour what a play commands."""

    def __init__(self, home: Home) -> None:
        self._home = home

    async def command(self, capability: str, value: PlainValue) -> None:
        await self._home.hold(hold_request("lamp", capability, value, "/app", ttl=3600.0))


async def _leaves_as_it_is(home: Home, lamp: Device, capability: str, before: PlainValue) -> bool:
    """Return whether an identification, which commanded the value before, would not put back an earlier one."""

    async def flush() -> str:
        return ""

    part = lamp.parts[0]
    candidate = CandidatePart(lamp, part, capability, dark=0.0, bright=1.0, before=None)
    values = {lamp.id: [capability, None, before, 0.0]}
    store = {"run": {"by": "it", "issuer": "/app", "scope": [], "at": 0.0, "values": values}}
    kept = SavedValues(home.app, DeviceLookup(home.app), store, flush, 0.0)
    return await kept.leave_changed("run", candidate)


async def _cause_of(home: Home, play: Play) -> KnownCause:
    """Return the cause of the newest change, also of one before homebot started."""
    client = home.app.create_client(GetCauses, GET_CAUSES)
    causes = (await client.call(GetCausesRequest(devices=("lamp",), from_journal=True))).causes
    (newest,) = [cause for cause in causes if cause.capability == play.of]
    return newest


async def _follow(home: Home, capability: str, changes: list[HandleChange[Handle]]) -> None:
    """Follow the lamp as an app does."""
    async for change in home.devices.follow(Handle, name="lamp"):
        changes += [change] if capability in change.before else []


async def _say_clear(home: Home) -> None:
    """Let the motion sensor say each ten minutes that it sees nobody."""
    while True:
        await home.report("motion", "occupancy", False)
        await anyio.sleep(600)


def _outcome(entries: Sequence[JournalEntry]) -> str:
    return next((one.results[0].outcome for one in reversed(entries) if one.results), "")


def _cause(entry: JournalEntry, capability: str) -> str:
    """Return the cause that an entry tells of a change of *capability*; empty for none."""
    if entry.kind == "reverted":
        return entry.results[0].reason
    of = entry.settings[0].capability if entry.settings else ""
    return entry.cause if of == capability and entry.kind in {"changed", "reported"} else ""


def _annoying(play: Play) -> tuple[str, PlainValue]:
    """Return what an app may not do while somebody may be in the room."""
    return ("position", 0.0) if play.of == "position" else ("on_off", False)
