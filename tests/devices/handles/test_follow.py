"""What a reader hears who follows handles; in virtual time."""

from typing import Any

import anyio
import anyio.lowlevel
import pytest
from tests.devices.handles.conftest import House

from homebot.devices.handles import FollowHandles, Light, Switch

pytestmark = pytest.mark.virtual_time


async def heard(follow: FollowHandles[Any]) -> list[str]:
    """What can be read within a moment."""
    found = []
    with anyio.move_on_after(0.1):
        async for change in follow:
            found.append(f"{change.kind} {change.handle.id}")  # noqa: PERF401  # it is cut short
    return found


async def test_those_that_are_there_come_first_and_then_every_change(house: House) -> None:
    """The same handle each time, up to date."""
    house.has(house.device("a", house.part("light", "on_off")), house.device("b", house.part("plug", "on_off")))
    lamps = house.devices.follow(Light)
    assert await heard(lamps) == ["appeared a"]
    house.says("a", "on_off", True)
    house.tells("appeared", house.device("c", house.part("light", "on_off")))
    assert await heard(lamps) == ["changed a", "appeared c"]
    house.tells("removed", house.device("a", house.part("light", "on_off")))
    assert await heard(lamps) == ["removed a"]
    lamps.close()


async def test_a_query_of_a_state_is_live(house: House) -> None:
    """A lamp that goes on comes to be wanted, one that goes off stops to be."""
    house.has(
        house.device("a", house.part("light", "on_off"), on_off=True),
        house.device("b", house.part("light", "on_off"), on_off=False),
    )
    lamps = house.devices.follow(Light, on=True)
    assert await heard(lamps) == ["appeared a"]
    house.says("b", "on_off", True)
    house.says("a", "on_off", False)
    assert sorted(await heard(lamps)) == ["appeared b", "removed a"]
    house.says("a", "on_off", None, told_at=2)
    assert await heard(lamps) == []


async def test_a_query_of_no_state_hears_each_value_and_each_description(house: House) -> None:
    """A new value is a change, and what is described as something else afterwards is no lamp any more."""
    house.has(house.device("a", house.part("light", "level")))
    lamps = house.devices.follow(Light)
    assert await heard(lamps) == ["appeared a"]
    for told_at in (1, 2):
        house.says("a", "level", float(told_at), told_at=told_at)
        assert await heard(lamps) == ["changed a"]
    house.tells("changed", house.device("a", house.part("plug", "on_off")))
    assert await heard(lamps) == ["removed a"]
    house.tells("changed", house.device("a", house.part("light", "level")))
    assert await heard(lamps) == ["appeared a"]
    lamps.close()


async def test_each_part_is_followed_by_itself(house: House) -> None:
    """One of two relays that goes on is one change."""
    house.has(
        house.device("s", house.part("switch", "on_off", part_id="1"), house.part("switch", "on_off", part_id="2"))
    )
    on = house.devices.follow(Switch, on=True)
    assert await heard(on) == []
    house.says("s", "on_off", False, part_id="2")
    assert await heard(on) == []
    house.says("s", "on_off", True, part_id="2", told_at=2)
    change = await anext(on)
    assert (change.kind, change.handle.id, change.before) == ("appeared", "s#2", {"on_off": False})
    house.tells("changed", house.device("s", house.part("switch", "on_off", part_id="1")))
    assert await heard(on) == ["removed s#2"]


async def test_changes_while_the_reader_is_busy_are_told_as_one(house: House) -> None:
    """Nothing piles up, and the newest is there."""
    house.has(house.device("a", house.part("light", "level")))
    lamps = house.devices.follow(Light)
    first = await anext(lamps)
    for level in range(1, 1001):
        house.says("a", "level", float(level % 100 + 1), told_at=level)
        await anyio.lowlevel.checkpoint()
    change = await anext(lamps)
    assert (change.kind, change.before, change.handle.level) == ("changed", {"level": None}, 1.0)
    house.says("a", "level", 50.0, told_at=1001)
    assert (await anext(lamps)).before == {"level": 1.0}
    assert await heard(lamps) == []
    assert first.handle.level == 50.0


async def test_a_device_that_is_back_before_the_reader_reads_is_still_present(house: House) -> None:
    """With the handle that the reader has."""
    lamp = house.device("a", house.part("light", "on_off"))
    house.has(lamp)
    lamps = house.devices.follow(Light)
    first = await anext(lamps)
    house.tells("removed", lamp)
    await anyio.sleep(0.01)
    house.tells("appeared", lamp)
    await anyio.sleep(0.01)
    assert await heard(lamps) == ["changed a"]
    assert not first.handle.is_gone


async def test_a_closed_query_ends(house: House) -> None:
    """While somebody waits, before anybody reads, and with its node."""
    lamps, unread = house.devices.follow(Light), house.devices.follow(Light)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(heard, lamps)
        await anyio.sleep(0.01)
        lamps.close()
        lamps.close()
    unread.close()
    assert [change async for change in unread] == []
    last = house.devices.follow(Light)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(heard, last)
        await anyio.sleep(0.01)
        house.node.close()
    assert [change async for change in last] == []
