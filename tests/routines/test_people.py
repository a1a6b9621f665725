"""Routines that ask who is at home, and start when people come and go."""

import asyncio
import json
from collections.abc import Mapping
from pathlib import Path

import pytest
from tests.apps.houses import hall, is_on
from tests.replay.recorded_days import MemorySink

from homebot.cli.main import main
from homebot.errors import UsageError
from homebot.house import World
from homebot.routines.conditions import read_condition
from homebot.routines.people import read_person
from homebot.routines.triggers import PersonMoves, read_trigger
from homebot.testing import VirtualHouse, VirtualTimeLoop, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("espresense", "homeassistant", "owntracks")]

PEOPLE = {"Anna": {"trackers": ["Anna's phone"]}, "Ben": {"trackers": ["ben phone"]}}
HEARD = json.dumps({"id": "phone:anna", "name": "Anna's phone", "rssi": -70})


def config(routine: Mapping[str, object]) -> dict[str, object]:
    return {"people": PEOPLE, "routines": [{"name": "Test", **routine}], "home": {"zone": "UTC"}}


async def ben_is(house: VirtualHouse, *regions: str) -> None:
    await house.run_for(1)
    await house.says("owntracks/ben/phone", json.dumps({"_type": "location", "inregions": list(regions), "tst": 1}))
    await house.run_for(5)


async def hear_anna(house: VirtualHouse) -> None:
    await house.run_for(1)
    await house.says("espresense/devices/phone:anna/kitchen", HEARD)
    await house.run_for(5)


async def lamp_after(world: World, house: VirtualHouse) -> bool:
    await house.run_for(5)
    return is_on(world, "hall_lamp")


async def test_an_arrival_starts_it_but_not_what_was_only_unknown() -> None:
    world = hall()
    async with virtual_house_of(
        world=world, config=config({"when": ["Anna arrives"], "do": ["hall lamp on"]})
    ) as house:
        await hear_anna(house)
        assert not await lamp_after(world, house), "where she was before is not known"
        await house.run_for("10m")
        await hear_anna(house)
        assert not await lamp_after(world, house), "her phone slept"
        await house.run_for("30m")
        await hear_anna(house)
        assert await lamp_after(world, house)


async def test_the_last_who_leaves_starts_it() -> None:
    world = hall()
    routine = {"when": ["everybody has left"], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await hear_anna(house)
        await ben_is(house, "Home")
        await ben_is(house)
        assert not await lamp_after(world, house)
        await house.run_for("21m")
        assert not await lamp_after(world, house), "Anna is silent, which is not away"
        await house.run_for("2m")
        assert await lamp_after(world, house)


@pytest.mark.parametrize(("condition", "runs"), [("nobody is home", False), ("somebody is home", False)])
async def test_what_is_unknown_holds_neither_way(condition: str, *, runs: bool) -> None:
    world = hall()
    routine = {"when": ["08:00"], "if": [condition], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_until("07:58")
        await ben_is(house)
        await house.run_until("08:01")
        assert is_on(world, "hall_lamp") is runs


@pytest.mark.parametrize(("regions", "runs"), [(("Home",), True), ((), False)])
async def test_a_condition_asks_for_one_person(regions: tuple[str, ...], *, runs: bool) -> None:
    world = hall()
    routine = {"when": ["08:00"], "if": ["Ben is home"], "do": ["hall lamp on"]}
    async with virtual_house_of(world=world, config=config(routine)) as house:
        await house.run_until("07:58")
        await ben_is(house, *regions)
        await house.run_until("08:01")
        assert is_on(world, "hall_lamp") is runs


@pytest.mark.parametrize(
    "text",
    ["Anna is home for 5m", "Anna at home", "people at home", "not Anna away", "somebody leaves", "nobody arrives"],
)
def test_a_trigger_that_would_take_unknown_for_a_move_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"Anna arrives|Anna is away|has left"):
        read_trigger(text)


@pytest.mark.parametrize("text", ["not Anna at home", "no person at home", "everybody is home", "not somebody is home"])
def test_a_condition_that_would_hold_while_it_is_unknown_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"Anna is away|name one"):
        read_condition(text)


@pytest.mark.parametrize(
    "same",
    [
        ("Anna is away", "anna is not home", "Anna is not at home"),
        ("nobody is home", "no one is home", "everybody is away"),
        ("somebody is home", "anybody is at home", "someone is home"),
    ],
)
def test_people_say_it_in_several_ways(same: tuple[str, ...]) -> None:
    assert len({(one.person, one.is_home) for one in map(read_person, same) if one is not None}) == 1
    assert all(isinstance(read_trigger(one), PersonMoves) for one in same)


def test_a_trial_on_a_recorded_day_knows_who_came_and_went(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TZ", "UTC")
    sink = MemorySink()

    async def live() -> None:
        tables = {"people": PEOPLE, "home": {"zone": "UTC"}}
        async with virtual_house_of(world=hall(), config=tables, record_into=sink) as house:
            for regions in (("Home",), (), ("Home",)):
                await ben_is(house, *regions)
                await house.run_for("10m")

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    (tmp_path / "day.jsonl").write_text("".join(f"{line}\n" for line in sink.lines))
    routine = '[home]\nzone = "UTC"\n[[routines]]\nname = "Out"\nwhen = ["Ben leaves"]\ndo = ["hall lamp off"]\n'
    (tmp_path / "new.toml").write_text(
        f'{routine}[[routines]]\nname = "In"\nwhen = ["Ben arrives"]\ndo = ["hall lamp on"]\n'
    )
    capsys.readouterr()
    assert main(["routine", "try", str(tmp_path / "new.toml"), "--on", str(tmp_path / "day.jsonl")]) == 0
    out, back, *_ = capsys.readouterr().out.splitlines()
    assert "off  out, because Ben reported" in out, out
    assert "on  in" in back
