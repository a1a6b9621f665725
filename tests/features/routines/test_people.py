"""Routines that ask who is at home, and start when people come and go."""

import asyncio
import json
from collections.abc import Mapping
from pathlib import Path

import pytest
from tests.apps.houses import hall, is_on, lamp
from tests.replay.recorded_days import MemorySink

from homebot.cli.main import main
from homebot.devices import QUERY_DEVICES, QueryDevices
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import And, HasText, StateIs
from homebot.devices.services import QueryDevicesRequest
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.house import World
from homebot.testing import VirtualHouse, VirtualTimeLoop, virtual_house_of
from homebot.words.conditions import read_condition
from homebot.words.people import read_person
from homebot.words.queries import parse_query
from homebot.words.triggers import PersonMoves, read_trigger

pytestmark = [
    pytest.mark.slow,
    pytest.mark.virtual_time,
    pytest.mark.rooms("espresense", "homeassistant", "owntracks", "people", "recording"),
]

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


async def test_the_queue_of_a_phone_that_was_offline_is_no_arrival() -> None:
    world = hall()
    async with virtual_house_of(world=world, config=config({"when": ["Ben arrives"], "do": ["hall lamp on"]})) as house:
        await ben_is(house)
        for told_at, regions in ((2, ["Home"]), (3, [])):
            message = {"_type": "location", "inregions": regions, "tst": told_at}
            await house.says("owntracks/ben/phone", json.dumps(message))
            await house.run_for(0.1)
        assert not await lamp_after(world, house)


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


async def found_by(house: VirtualHouse, query: str) -> list[str]:
    async with Node(house.runtime.graph, "asker") as node:
        request = QueryDevicesRequest(query=query_terms(parse_query(query)))
        answer = await node.create_client(QueryDevices, QUERY_DEVICES).call(request)
    return [one.device.name for one in answer.results]


async def test_that_everybody_is_home_starts_it_and_is_asked_everywhere() -> None:
    """In conditions, waits, queries and policies; while it is unknown of one, it is unknown of all."""
    world = hall(study_lamp=lamp("study"))
    everybody = "everybody is home"
    tables: dict[str, object] = {
        "home": {"zone": "UTC"},
        "people": PEOPLE,
        "routines": [
            {"name": "Start", "when": [everybody], "if": [everybody], "do": ["study lamp on"]},
            {"name": "Wait", "when": ["08:00"], "do": [f"wait until {everybody}, at most 1h", "hall lamp on"]},
            {"name": "Off", "when": ["08:30", "08:40"], "do": ["hall lamp off"]},
        ],
        "control": {"interlocks": [{"commands": ["turn off"], "while": everybody, "where": "home"}]},
    }
    async with virtual_house_of(world=world, config=tables) as house:
        await house.run_until("07:58")
        await ben_is(house)
        await house.run_until("08:01")
        await hear_anna(house)
        assert await found_by(house, everybody) == []
        assert await found_by(house, "somebody home") == ["Household"]
        assert not await lamp_after(world, house)
        await ben_is(house, "Home")
        assert await lamp_after(world, house)
        assert is_on(world, "study_lamp")
        assert await found_by(house, everybody) == ["Household"]
        assert await found_by(house, "nobody is at home") == []
        await house.run_until("08:29:30")
        assert await found_by(house, everybody) == []  # her phone sleeps
        await hear_anna(house)
        await house.run_until("08:31")
        assert is_on(world, "hall_lamp")
        await ben_is(house)
        await house.run_until("08:41")
        assert not is_on(world, "hall_lamp")


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


@pytest.mark.parametrize("text", ["not Anna at home", "no person at home", "not people at home"])
def test_a_condition_that_would_hold_while_it_is_unknown_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match=r"Anna is away"):
        read_condition(text)


def test_what_may_be_meant_in_two_ways_is_refused() -> None:
    with pytest.raises(UsageError, match="write 'nobody is home' or 'not everybody is home'"):
        read_condition("everybody is not home")


@pytest.mark.parametrize(
    "same",
    [
        ("Anna is away", "anna is not home", "Anna is not at home"),
        ("nobody is home", "no one is home", "everybody is away", "not anybody is home"),
        ("somebody is home", "anybody is at home", "someone is home", "not everybody is away"),
        ("everybody is home", "all are at home", "nobody is away"),
        ("not everybody is home", "somebody is away"),
    ],
)
def test_people_say_it_in_several_ways(same: tuple[str, ...]) -> None:
    assert len({*map(read_person, same)}) == 1
    assert all(isinstance(read_trigger(one), PersonMoves) for one in same)


@pytest.mark.parametrize(
    "text",
    [
        *("somebody is home", "anyone is at home", "nobody is home", "no one is at home", "everyone is home"),
        *("somebody is away", "nobody is away", "everybody is away"),
    ],
)
def test_queries_say_of_the_household_what_routines_say(text: str) -> None:
    assert (said := read_person(text)) is not None
    assert parse_query(text) == said.query


@pytest.mark.parametrize(
    ("text", "is_home"),
    [("Ben is home", True), ("Ben is at home", True), ("Ben is not home", False), ("Ben is away", False)],
)
def test_queries_say_of_a_person_what_routines_say(text: str, *, is_home: bool) -> None:
    assert parse_query(text) == And((HasText("ben"), StateIs("at_home", "=", is_home)))


@pytest.mark.parametrize(("condition", "is_on_then"), [('name="Ben" is home', True), ('name="Ben" is away', False)])
async def test_a_policy_asks_for_one_person(condition: str, *, is_on_then: bool) -> None:
    world = hall()
    routines = [{"name": "On", "when": ["08:00"], "do": ["hall lamp on"]}]
    routines += [{"name": "Off", "when": ["08:10"], "do": ["hall lamp off"]}]
    policy = {"commands": ["turn off"], "while": condition, "where": "home"}
    tables = config({}) | {"routines": routines, "control": {"interlocks": [policy]}}
    async with virtual_house_of(world=world, config=tables) as house:
        await house.run_until("08:05")
        await ben_is(house, "Home")
        await house.run_until("08:11")
        assert is_on(world, "hall_lamp") is is_on_then


def test_a_trial_on_a_recorded_day_knows_who_came_and_went(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TZ", "UTC")
    sink = MemorySink()

    async def live() -> None:
        tables = {"people": PEOPLE, "home": {"zone": "UTC"}}
        async with virtual_house_of(world=hall(), config=tables, observers=sink.observers()) as house:
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
