"""Routines that the owner writes by a command while homebot runs."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from shutil import copytree
from typing import Any

import anyio
import pytest
from anyio import to_thread
from structlog.testing import capture_logs

from homebot.clock import LoopClock
from homebot.config import Config, load_config, parse_config
from homebot.devices.app_messages import (
    ChangeAppResponse,
    ChangeRoutine,
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    GetHomePlace,
    HomePlaceRequest,
    ListRoutines,
    ProposeRoutine,
    ProposeRoutineRequest,
    Reload,
    ReloadRequest,
    RoutineChange,
    RoutineInfo,
    RoutinesRequest,
)
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import CHANGE_ROUTINE, HOME_PLACE, LIST_ROUTINES, RELOAD, RUNTIME_HEALTH
from homebot.devices.own_services import right_to_call
from homebot.errors import ConfigError
from homebot.features.routines import PROPOSE_ROUTINE
from homebot.features.routines.kept_routines import KeptRoutines
from homebot.graph import Node
from homebot.rights import Right
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan, plan_errors

pytestmark = pytest.mark.virtual_time

EVENING = '[[routines]]\nname = "Evening"  # when it is late\nwhen = ["22:30"]\ndo = ["all lights off"]\n'
MORNING = 'name = "Morning"\nwhen = ["7:00"]\ndo = ["all lights on"]\n'
DUSK = {"name": "Dusk", "when": ["sunset - 30m"], "do": ["all lights on"]}
CONFIGURED = {"name": "Noon", "when": ["12:00"], "do": ["all lights off"]}


class CountedTexts(dict[str, Any]):
    """A store that notes what is read of it."""

    def __init__(self, texts: dict[str, Any]) -> None:
        super().__init__(texts)
        self.read = set[str]()

    def __getitem__(self, app: str) -> Any:
        self.read.add(app)
        return super().__getitem__(app)


class Owner:
    """What a client of the running homebot asks of it."""

    def __init__(self, node: Node) -> None:
        self._change = node.create_client(ChangeRoutine, CHANGE_ROUTINE)
        self._propose = node.create_client(ProposeRoutine, PROPOSE_ROUTINE.name)
        self._list = node.create_client(ListRoutines, LIST_ROUTINES)
        self._health = node.create_client(GetHealth, RUNTIME_HEALTH)
        self._reload = node.create_client(Reload, RELOAD)

    async def change(
        self, change: RoutineChange, name: str = "", text: str = "", *act: str, unless_asks: bool = False
    ) -> ChangeRoutineResponse:
        request = ChangeRoutineRequest(name=name, change=change, text=text, act=act, unless_asks=unless_asks)
        return await self._change.call(request)

    async def reload(self) -> ChangeAppResponse:
        return await self._reload.call(ReloadRequest())

    async def propose(self, request: ProposeRoutineRequest) -> ChangeRoutineResponse:
        return await self._propose.call(request)

    async def routines(self, *, check: bool = False) -> dict[str, RoutineInfo]:
        return {one.name: one for one in (await self._list.call(RoutinesRequest(check=check))).routines}

    async def troubles(self) -> str:
        return "\n".join((await self._health.call(HealthRequest())).troubles)


@asynccontextmanager
async def homebot(folder: Path, **tables: object) -> AsyncIterator[Owner]:
    config = parse_config({"routines": [CONFIGURED], **tables}, "homebot.toml")
    async with (
        Runtime(config, with_door=False, index_file=folder / "index.sqlite") as runtime,
        Node(runtime.graph, "owner") as node,
    ):
        yield Owner(node)


async def test_a_new_one_runs_at_once_and_after_a_restart_with_its_comments(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        answer = await owner.change("new", text=EVENING)
        assert answer.message.startswith("added Evening\nEvening: 'all lights off': no device fits")
        assert (await owner.routines())["Evening"].next.sec
    async with homebot(tmp_path) as owner:
        found = (await owner.routines())["Evening"]
        assert (found.text, found.is_kept, found.next.sec > 0) == (EVENING, True, True)


async def test_a_change_is_on_the_disk_when_it_is_answered(tmp_path: Path) -> None:
    """A power cut at once neither loses a routine, nor starts one that was disabled or removed."""
    async with homebot(tmp_path / "home") as owner:
        await owner.change("new", text=f"{EVENING}[[routines]]\n{MORNING}")
        copytree(tmp_path / "home", tmp_path / "added")
        await owner.change("disable", "Evening")
        await owner.change("remove", "Morning")
        copytree(tmp_path / "home", tmp_path / "removed")
    async with homebot(tmp_path / "added") as owner:
        assert [*await owner.routines()] == ["Noon", "Evening", "Morning"]
    async with homebot(tmp_path / "removed") as owner:
        assert {name: one.enabled for name, one in (await owner.routines()).items()} == {"Noon": True, "Evening": False}
        assert not (await owner.routines())["Evening"].next.sec, "no time starts it"


async def test_several_are_added_at_once_or_none(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        wrong = await owner.change("new", text=f"{EVENING}[[routines]]\n{MORNING.replace('7:00', '27:00')}")
        assert "routines.morning.when.0: '27:00' is not a time of day" in wrong.message
        assert [*await owner.routines()] == ["Noon"]
        answer = await owner.change("new", text=f"# mine\n{EVENING}\n[[routines]]\n{MORNING}")
        assert answer.message.startswith("added Evening, Morning\nEvening: ")
        assert (await owner.routines())["Morning"].text == f"[[routines]]\n{MORNING}"


async def test_every_wrong_text_of_all_is_named_with_its_line(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        both = EVENING.replace("22:30", "22:60").replace("off", "of"), MORNING.replace("7:00", "27:00")
        answer = await owner.change("new", text="[[routines]]\n".join(both))
        lines = answer.message.splitlines()
        assert [line.partition(": '")[0] for line in lines] == [
            "the text:3: routines.evening.when.0",
            "the text:4: routines.evening.do.0",
            "the text:7: routines.morning.when.0",
        ]


async def test_a_wrong_one_is_named_where_the_configuration_file_has_no_routines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tmp_path.joinpath("homebot.toml").write_text('[home]\nname = "villa"\n')
    async with homebot(tmp_path, routines=[]) as owner:
        answer = await owner.change("new", text='name = "Dusk"\nwhen = ["sunset"]\ndo = ["all lights on"]\n')
    assert not answer.success
    assert "needs the place of the home: set latitude and longitude in the table [home]" in answer.message


async def test_a_hundred_are_added_in_the_time_of_one(tmp_path: Path) -> None:
    """The command line waits for a minute; each new app has a second to prove that it runs."""
    async with homebot(tmp_path) as owner:
        begin = anyio.current_time()
        answer = await owner.change("new", text="".join(EVENING.replace("Evening", f"E{n}") for n in range(100)))
        assert answer.success
        assert anyio.current_time() - begin < 5
        assert len(await owner.routines()) == 101
        assert not (await owner.change("new", text="".join(EVENING.replace("ing", f"{n}") for n in range(201)))).success
        assert len(await owner.routines()) == 101, "there may be 300: all or none are added"


async def test_a_start_reads_the_configuration_once_for_all_of_them(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        await owner.change("new", text="".join(EVENING.replace("Evening", f"E{n}") for n in range(20)))
    reads = []

    def read() -> Config:
        reads.append(1)
        return parse_config({}, "homebot.toml")

    async with Runtime(read(), with_door=False, index_file=tmp_path / "index.sqlite", read_config=read) as runtime:
        assert len(runtime.app_host.running) == 20
    assert len(reads) == 1 + 1


async def test_to_plan_one_the_others_are_not_read() -> None:
    """Each start of an app read all of them: 200 kept routines took 16 s of a processor."""
    texts = CountedTexts({f"e{n}": {"text": EVENING.replace("Evening", f"E{n}"), "by": ""} for n in range(20)})
    kept = KeptRoutines(texts, lambda _: None, {})
    config = kept.added_to(parse_config({}, "homebot.toml"), "e7")
    assert [*config.apps] == ["e7"]
    assert texts.read == {"e7"}


async def test_it_is_edited_renamed_and_removed(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        await owner.change("new", text=EVENING)
        await owner.change("disable", "Evening")
        changed = await owner.change("edit", "evening", EVENING.replace("22:30", "23:30"))
        assert changed.message.startswith("changed Evening\nEvening: ")
        found = (await owner.routines())["Evening"]
        assert (found.when, found.enabled) == (("23:30",), False)
        renamed = await owner.change("edit", "Evening", EVENING.replace("Evening", "Late"))
        assert renamed.message == "renamed Evening to Late"
        assert (await owner.change("remove", "Late")).message == "removed Late"
        assert [*await owner.routines()] == ["Noon"]
        await owner.change("new", text=EVENING)
        assert (await owner.routines())["Evening"].enabled


async def test_a_wrong_text_leaves_the_old_one(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        await owner.change("new", text=EVENING)
        answer = await owner.change("edit", "Evening", EVENING.replace("off", "of"))
        assert not answer.success
        assert "did you mean off" in answer.message
        assert (await owner.routines())["Evening"].text == EVENING


async def test_a_right_that_it_was_given_is_kept_with_it_until_it_is_taken_away(tmp_path: Path) -> None:
    """Only an app or a routine of the configuration could have one."""

    async def act(owner: Owner) -> tuple[str, ...]:
        return (await owner.routines())["Evening"].act

    async with homebot(tmp_path) as owner:
        await owner.change("new", "", EVENING, "lock", 'id="a"')
        assert await act(owner) == ("ordinary", "lock", 'id="a"')
        assert (await owner.reload()).success
        assert await act(owner) == ("ordinary", "lock", 'id="a"')
    async with homebot(tmp_path) as owner:
        await owner.change("edit", "Evening", "", "plug", "lock")
        found = (await owner.routines())["Evening"]
        assert found.text == f'{EVENING}act = ["ordinary", "lock", "id=\\"a\\"", "plug"]\n'
        wrong = await owner.change("edit", "Evening", found.text.replace("off", "of"), "light")
        assert (wrong.success, await act(owner)) == (False, found.act)
        await owner.change("edit", "Evening", found.text.replace("Evening", "Late"))
        assert (await owner.routines())["Late"].act == found.act
        await owner.change("edit", "Late", EVENING)
        assert await act(owner) == ()
        await owner.change("edit", "Evening", "", "lock")
        await owner.change("remove", "Evening")
        await owner.change("new", text=EVENING)
        assert await act(owner) == ()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('act = "light"\n', 'act = ["light", "lock"]\n'),
        ('act = [\n  "light",  # these\n]\n', 'act = ["light", "lock"]\n'),
        ('mode = "queued"', 'mode = "queued"\nact = ["ordinary", "lock"]\n'),
        ("[[routines.do]]\nif = ['on weekdays']\ndo = ['all lights on']", 'act = ["ordinary", "lock"]\n'),
    ],
)
async def test_a_right_is_added_however_its_text_is_written(tmp_path: Path, text: str, expected: str) -> None:
    written = (EVENING if "routines.do" not in text else EVENING.replace('do = ["all lights off"]\n', "")) + text
    async with homebot(tmp_path) as owner:
        assert (await owner.change("new", "", written, "lock")).success
        assert (await owner.routines())["Evening"].text.endswith(expected)


async def test_an_app_of_the_configuration_has_its_own_rights_and_not_those_of_a_routine_of_its_name(
    tmp_path: Path,
) -> None:
    async with homebot(tmp_path) as owner:
        await owner.change("new", "", EVENING, "lock")
    async with homebot(tmp_path, routines=[CONFIGURED | {"name": "Evening"}]) as owner:
        assert (await owner.routines())["Evening"].act == ()


async def test_a_right_is_given_on_the_page_once_the_owner_agrees_and_by_no_proposal(tmp_path: Path) -> None:
    given = f'{EVENING}act = ["ordinary", "lock"]\n'
    async with homebot(tmp_path) as owner:
        for change, name in (("new", ""), ("edit", "Evening")):
            asked = await owner.change(change, name, given, unless_asks=True)  # type: ignore[arg-type]
            assert (asked.success, asked.message) == (False, "a person must agree: lock")
            assert (await owner.change(change, name, EVENING, unless_asks=True)).success  # type: ignore[arg-type]
        assert (await owner.routines())["Evening"].act == ()
        await owner.change("edit", "Evening", given)
        assert (await owner.change("edit", "Evening", given, unless_asks=True)).success, "it has that right"
        proposed = await owner.propose(ProposeRoutineRequest(text=given.replace("Evening", "Late")))
        assert proposed.message == "the text: routines.late.act: only the owner gives a right; leave it out"
        assert [*await owner.routines()] == ["Noon", "Evening"]


@pytest.mark.parametrize(
    ("change", "name", "text", "problem"),
    [
        ("new", "", EVENING.replace("Evening", "Noon"), "a routine or app noon is there already"),
        ("new", "", EVENING.replace("Evening", "Apps"), "is the name of one of homebot's own nodes"),
        ("new", "", f"{EVENING}act = 5\n", "routines.evening.act: must be a query such as 'light in hall'"),
        ("new", "", f'{EVENING}act = "(lock"\n', "routines.evening.act: "),
        ("new", "", EVENING.replace('"Evening"', '"Evening\\nremoved Noon"'), "a name is one line"),
        ("new", "", f"{EVENING}[door]\n", "the text: door: is no part of a routine"),
        ("new", "", "", "has no table"),
        ("new", "", "name = ", "is invalid TOML"),
        (
            "new",
            "",
            "routines = [{name = 'A', when = ['7:00'], do = ['x on']}, {name = 'B', when = ['8:00'], do = ['x on']}]",
            "in a line of its own",
        ),
        ("edit", "Noon", EVENING, "Noon is in the configuration; change it there"),
        ("remove", "Noon", "", "Noon is in the configuration; change it there"),
        ("edit", "Nune", EVENING, "there is no routine 'Nune'; did you mean Noon?"),
    ],
)
async def test_what_is_not_possible_says_why(
    tmp_path: Path, change: RoutineChange, name: str, text: str, problem: str
) -> None:
    async with homebot(tmp_path) as owner:
        answer = await owner.change(change, name, text)
        assert (problem in answer.message, answer.success) == (True, False), answer.message
        assert [*await owner.routines()] == ["Noon"]


async def test_one_that_is_wrong_now_stays_out_alone_and_is_told(tmp_path: Path) -> None:
    """Its name was given to a routine in the configuration afterwards."""
    async with homebot(tmp_path) as owner:
        await owner.change("new", text=EVENING)
        await owner.change("new", text=MORNING)
    with capture_logs() as lines:
        async with homebot(tmp_path, routines=[CONFIGURED | {"name": "Evening"}]) as owner:
            found = await owner.routines()
            assert [*found] == ["Evening", "Morning"]
            assert found["Evening"].when == ("12:00",)
            problem = "homebot.toml has a routine or app evening too; rename or remove one of them"
            assert f"the routine evening does not run: {problem}" in await owner.troubles()
            assert [one["message"] for one in lines if one["event"] == "app.left_out"] == [
                f"the routine evening does not run: {problem}"
            ]


MISTAKES = """\
[[routines]]
name = "Good"
when = ["12:00"]
do = ["notify noon"]
[[routines]]
name = "Good"
when = ["12:00"]
do = ["notify noon"]
[[routines]]
when = ["12:00"]
do = ["notify noon"]

[[routines]]
name = 3
[[routines]]
name = "Bad"
when = ["12:00"]
do = ["notify noon", "hall lamp onn"]
[[routines]]
name = "Кухня"
when = ["12:00"]
do = ["notify noon"]
[[groups]]
name = "A"
members = "lights"
[[groups]]
name = "A"
members = "lights"
[[groups]]
members = "lights"
[[groups]]
name = "B"
members = "group = C"
[[groups]]
name = "C"
members = "open windows"
[[scenes]]
name = "Film"
value = {}
[[scenes]]
values = { lamp = "on" }
"""


async def test_a_wrong_routine_of_the_configuration_stays_out_alone_and_is_told() -> None:
    wrong = CONFIGURED | {"name": "Wrong", "when": ["noon o'clock"]}
    given = parse_config({"routines": [wrong, CONFIGURED]}, "homebot.toml")
    problem = 'homebot.toml: routines.wrong.when.0: "noon o\'clock" names no state'
    with capture_logs() as lines:
        async with (
            Runtime(given, with_door=False) as runtime,
            Node(runtime.graph, "owner") as node,
        ):
            owner = Owner(node)
            found = await owner.routines()
            assert [*found] == ["Noon", "wrong"]
            assert found["wrong"].problem.startswith(problem)
            assert f"the routine wrong does not run: {problem}" in await owner.troubles()
            answer = await owner.change("run", "wrong")
            assert answer.message.startswith(f"wrong does not run: {problem}")
    assert any(one["event"] == "app.left_out" and problem in one["message"] for one in lines)


@pytest.mark.rooms("scenes")
async def test_no_mistake_in_a_routine_group_or_scene_stops_anything_else(tmp_path: Path) -> None:
    """Each is one line, with the line of the file: in the log, and where clients ask."""
    file = tmp_path / "homebot.toml"
    file.write_text(MISTAKES)
    clock = LoopClock()
    house = await to_thread.run_sync(lambda: Runtime(load_config(file), with_door=False, clock=clock))
    with capture_logs() as lines:
        async with house as runtime, Node(runtime.graph, "owner") as node:
            found = await Owner(node).routines()
            assert {name: one.problem.partition(": ")[0] for name, one in found.items() if one.problem} == {
                "good_2": f"{file}:6",
                "routine_3": f"{file}:9",
                "routine_4": f"{file}:14",
                "bad": f"{file}:18",
            }
            assert [name for name, one in found.items() if not one.problem] == ["Good", "Кухня"]
            answer = await runtime.reload(lambda: load_config(file))
            assert (answer.success, answer.message.count("; left out: ")) == (True, 10)
    told = [one["message"] for one in lines if one["event"] == "app.left_out"]
    assert len(told) == 10
    assert [one.removeprefix(f"left out: {file}:").partition(": ")[0] for one in told[4:]] == [
        "27",
        "29",
        "33",
        "36",
        "37",
        "40",
    ]


@pytest.mark.parametrize(
    "limit",
    [
        {
            "control": {
                "quiet_hours": [{"start": "00:00", "end": "06:00", "commands": ["open group=valuables"]}],
            }
        },
        {"door": {"scope": ["read", "act: locks and not group=valuables"]}},
        {"apps": {"light_service": {"act": "lights and not group=valuables"}}},
        {
            "control": {"quiet_hours": [{"start": "00:00", "end": "06:00", "commands": ["open lock"] * 50}]},
            "apps": {"light_service": {"act": "lights and not group=valuables"}},
        },
    ],
)
def test_a_wrong_group_that_a_policy_or_right_asks_for_is_no_small_matter(limit: dict[str, object]) -> None:
    """Without it the limit would hold for nothing."""
    groups = [{"name": "Valuables", "members": "open safes"}, {"name": "Value", "members": "open safes"}]
    left_out = make_plan(parse_config({"groups": groups}, "homebot.toml")).left_out
    assert [*left_out] == ["groups.0", "groups.1"]
    with pytest.raises(ConfigError, match=r"groups.0.members: 'open safes' depends on"):
        make_plan(parse_config({"groups": groups, **limit}, "homebot.toml"))


def test_all_mistakes_of_a_configuration_are_listed_once() -> None:
    wrong = CONFIGURED | {"when": ["noon o'clock"], "do": ["lamp onn"]}
    errors = plan_errors(parse_config({"routines": [wrong]}, "homebot.toml"))
    assert [one.key for one in errors] == ["routines.noon.when.0", "routines.noon.do.0"]


async def test_a_proposal_waits_for_the_owner_and_says_whose_it_is(tmp_path: Path) -> None:
    proposal = ProposeRoutineRequest(text=EVENING, issuer="client:agent")
    async with homebot(tmp_path) as owner:
        answer = await owner.propose(proposal)
        first, hint = answer.message.splitlines()
        assert first == "proposed Evening; the owner enables it: homebot routine enable 'Evening'"
        assert hint.startswith("Evening: 'all lights off': no device fits")
        assert not (await owner.propose(proposal)).success
    async with homebot(tmp_path) as owner:
        found = (await owner.routines())["Evening"]
        assert (found.proposed_by, found.enabled) == ("client:agent", False)
        await owner.change("edit", "Evening", EVENING.replace("22:30", "22:45"))
        found = (await owner.routines())["Evening"]
        assert (found.proposed_by, found.enabled, found.when) == ("client:agent", False, ("22:45",))
        await owner.change("enable", "Evening")
    async with homebot(tmp_path) as owner:
        found = (await owner.routines())["Evening"]
        assert (found.proposed_by, found.enabled) == ("", True)


async def test_proposals_are_limited_and_come_one_at_a_time(tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        both = f"{EVENING}\n[[routines]]\n{MORNING}"
        assert "propose one at a time" in (await owner.propose(ProposeRoutineRequest(text=both))).message
        for number in range(20):
            text = EVENING.replace("Evening", f"Evening {number}")
            assert (await owner.propose(ProposeRoutineRequest(text=text))).success
        answer = await owner.propose(ProposeRoutineRequest(text=EVENING))
        assert answer.message == "20 proposals wait for the owner, which is the limit"


async def test_where_the_home_is_hears_no_client_that_may_only_read(tmp_path: Path) -> None:
    """A client that proposes a routine needs it for a trial with the sun."""
    assert right_to_call(HOME_PLACE) is Right.ACT
    home = {"latitude": 52.52, "longitude": 13.405}
    config = parse_config({"home": home, "routines": [DUSK]}, "x")
    async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "owner") as node:
        place = await node.create_client(GetHomePlace, HOME_PLACE).call(HomePlaceRequest())
        assert place.place == (52.5, 13.4)
        listed = await node.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest(check=True))
        assert "52.5" not in listed.model_dump_json()


def test_a_routine_that_asks_the_sun_needs_the_place_of_the_home() -> None:
    conditions: list[dict[str, object]] = [
        {"name": "A", "if": ["sun is down"]},
        {"name": "B", "do": [{"if": ["sun is up"], "do": ["undo"]}]},
    ]
    given = parse_config({"routines": [DUSK, *(CONFIGURED | one for one in conditions)]}, "homebot.toml")
    assert [str(one) for one in make_plan(given).left_out.values()] == [
        f"homebot.toml: routines.{app}: {text!r} needs the place of the home: "
        "set latitude and longitude in the table [home]"
        for app, text in (("dusk", "sunset - 30m"), ("a", "sun is down"), ("b", "sun is up"))
    ]
