"""Whatever interrupts an identification, everything is as before; in virtual time."""

from __future__ import annotations

import copy

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, obey_after
from tests.features.identify.conftest import Room, served
from tests.one_task import in_one_task
from tests.sizes import size

from homebot.devices.wording.journal_words import trigger_text
from homebot.graph.actions import GoalState

pytestmark = pytest.mark.virtual_time

RUNS = size(40, 1000)


async def interrupted(room: Room, number: int) -> None:
    """Cancel a run after a random time; the lamps answer after random times."""
    for key in room.effects:
        room.home.behaviours[key] = obey_after(room.random.uniform(0.0, 1.5))
    before = await room.is_on()
    goal = await room.begin(seconds=30)
    await anyio.sleep(room.random.uniform(0.5, 15.0))
    goal.request_cancel()
    await goal.result()
    await anyio.sleep(3.0)
    assert await room.is_on() == before, number


async def test_interrupted_runs_leave_no_lamp_changed(room: Room) -> None:
    await room.lamps(5, 10, 60, 3)
    for number in range(RUNS):
        await interrupted(room, number)
    assert room.store == {}
    assert await room.home.leases() == ()


async def test_a_kill_is_put_back_at_the_next_start(open_home: OpenHome) -> None:
    """The store of a killed homebot is as before the first change, and nothing was released."""
    async with in_one_task(open_home()) as home:
        room = Room(home)
        await room.lamps(5, 10, 60, 3)
        for number in range(size(10, 200)):
            before = await room.is_on()
            left: dict[str, object] = {}
            async with served(room):
                goal = await room.begin(seconds=30)
                await anyio.sleep(room.random.uniform(2.0, 12.0))
                left = copy.deepcopy(room.store)
                changed = await room.is_on()
                goal.request_cancel()
                await goal.result()
            for key, is_on in changed.items():  # the kill leaves them so
                await home.report(key.casefold(), "on_off", is_on)
            await anyio.sleep(1.0)
            room.store = left
            async with served(room):
                await anyio.sleep(0.1)
                for key, is_on in changed.items():  # devices report after the start
                    await home.report(key.casefold(), "on_off", is_on)
                await anyio.sleep(12.0)
                assert await room.is_on() == before, number
                assert room.store == {}


async def test_a_silent_device_is_put_back_soon_after_the_start(home: Home) -> None:
    room = Room(home)
    await room.lamps(60)
    values = {"lamp0": ["on_off", True, False, 1.0]}
    kept = {"by": "identify by rosie", "issuer": "client:rosie", "scope": [], "values": values}
    room.store["run"] = kept | {"at": room.home.graph.clock.now() - 60}
    async with served(room):
        await anyio.sleep(70.0)
        assert await room.is_on() == {"Lamp0": True}
    (asked,) = (one for one in (await home.read()).entries if one.kind == "requested")
    text = "identify by rosie was cut off by the end of homebot, and it is put back"
    assert trigger_text(asked.trigger, {}) == text


async def test_what_was_left_long_ago_is_not_put_back(home: Home) -> None:
    room = Room(home)
    await room.lamps(60)
    values = {"lamp0": ["on_off", True, False, 1.0]}
    kept = {"by": "identify by rosie", "issuer": "client:rosie", "scope": [], "values": values}
    room.store["run"] = kept | {"at": room.home.graph.clock.now() - 7200}
    async with served(room):
        await anyio.sleep(70.0)
        assert await room.is_on() == {"Lamp0": False}
        assert room.store == {}


async def test_the_end_of_homebot_puts_back(home: Home) -> None:
    room = Room(home)
    await room.lamps(5, 60)
    before = await room.is_on()
    async with served(room):
        await room.begin()
        await anyio.sleep(4.5)
        assert await room.is_on() != before
    assert await room.is_on() == before
    assert room.store == {}


async def test_nothing_is_changed_if_the_values_cannot_be_kept(room: Room) -> None:
    await room.lamps(60)
    room.problem = "the disk is full"
    found = await room.identify()
    assert found.message == "nothing was changed, as the values to put back cannot be kept: the disk is full"
    assert room.home.commands == []
    assert room.store == {}


async def test_what_cannot_be_put_back_is_tried_again(room: Room) -> None:
    await room.lamps(60)
    goal = await room.begin()
    await anyio.sleep(6.0)
    assert await room.is_on() == {"Lamp0": True}
    room.home.behaviours["lamp0"] = ignore
    goal.request_cancel()
    state, found = await goal.result()
    assert (state, found.message) == (GoalState.CANCELED, "cancelled; lamp0 not yet as before, but homebot sees to it")
    assert await room.is_on() == {"Lamp0": True}
    del room.home.behaviours["lamp0"]
    await anyio.sleep(30.0)
    assert await room.is_on() == {"Lamp0": False}
    assert room.store == {}


async def test_what_is_not_yet_back_comes_back_after_the_next_identification_too(room: Room) -> None:
    """The next one found the lamp as the first had left it."""
    await room.lamps(60, 5)
    goal = await room.begin()
    await anyio.sleep(6.0)
    assert await room.is_on() == {"Lamp0": True, "Lamp1": True}
    room.home.behaviours["lamp0"] = ignore
    goal.request_cancel()
    await goal.result()
    assert (await room.is_on())["Lamp0"] is True
    del room.home.behaviours["lamp0"]
    assert (await room.identify()).name == "Lamp0"
    await anyio.sleep(5.0)
    assert await room.is_on() == {"Lamp0": False, "Lamp1": True}
    assert room.store == {}


async def test_a_person_is_obeyed_whenever_a_lamp_is_commanded_in_a_run(room: Room) -> None:
    """At random times, for lamps that answer after random times."""
    await room.lamps(5, 10, 60, 3)
    for number in range(RUNS):
        for key in room.effects:
            room.home.behaviours[key] = obey_after(room.random.uniform(0.0, 1.5))
        before, is_on = await room.is_on(), room.random.random() < 0.5
        goal = await room.begin(seconds=30)
        await anyio.sleep(room.random.uniform(3.0, 9.0))
        key = room.random.choice([*room.effects])
        assert (await room.command(key, is_on=is_on)).succeeded, number
        await goal.result()
        await anyio.sleep(10.0)
        assert await room.is_on() == before | {key.title(): is_on}, number
    assert room.store == {}


@pytest.mark.parametrize("wanted", [False, True])
async def test_what_a_person_commanded_just_before_a_kill_is_not_put_back(home: Home, *, wanted: bool) -> None:
    room = Room(home)
    await room.lamps(60, 5)
    before = await room.is_on()
    async with served(room):
        goal = await room.begin()
        await anyio.sleep(4.5)
        room.home.behaviours["lamp0"] = obey_after(1.0)
        home.begin(lambda: room.command("lamp0", is_on=wanted))
        await anyio.sleep(0.01)
        left = copy.deepcopy(room.flushed)
        goal.request_cancel()
        await goal.result()
    await home.report("lamp0", "on_off", wanted)
    await anyio.sleep(1.0)
    room.store = left
    async with served(room):
        await anyio.sleep(70.0)
        assert await room.is_on() == before | {"Lamp0": wanted}
        assert room.store == {}


async def test_a_person_is_obeyed_while_a_lamp_is_put_back(room: Room) -> None:
    """The lamp has not heard that it is put back, and is as the person wants."""
    await room.lamps(60)
    goal = await room.begin()
    await anyio.sleep(6.0)
    room.home.behaviours["lamp0"] = ignore
    goal.request_cancel()
    await anyio.sleep(1.0)
    del room.home.behaviours["lamp0"]
    assert (await room.command("lamp0", is_on=True)).succeeded
    await goal.result()
    await anyio.sleep(70.0)
    assert (await room.is_on(), room.store) == ({"Lamp0": True}, {})


@pytest.mark.parametrize("is_by_hand", [False, True])
async def test_what_a_person_changes_before_the_first_change_stays_so(room: Room, *, is_by_hand: bool) -> None:
    """While people are told, and the sensor looks for the first time."""
    await room.lamps(60, 5)
    goal = await room.begin()
    await anyio.sleep(0.5)
    await (room.by_person("lamp0", is_on=True) if is_by_hand else room.command("lamp0", is_on=True))
    found = (await goal.result())[1]
    assert (found.name, found.candidates[0].problem) == ("Lamp0", "")
    assert await room.is_on() == {"Lamp0": True, "Lamp1": True}
