"""What the configuration makes of doors and tokens."""

import tomllib
from pathlib import Path

import pytest
from tests.call_counts import calls

from homebot.cli.commands.run import with_environment
from homebot.config import load_config, parse_config
from homebot.devices.client_rights import LOCAL_RIGHTS
from homebot.errors import ConfigError
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan, plan_errors

ROOMS: dict[str, object] = {"bath": {}, "hall": {"doors": ["bath", "outside"]}}


def config(doors: dict[str, list[str]], rooms: dict[str, object] = ROOMS) -> dict[str, object]:
    return {"places": {"rooms": rooms}, "control": {"presence_guard": {"doors": doors}}}


@pytest.mark.parametrize(
    ("doors", "rooms"),
    [({"Bath": ["Bath door"], "hall": ["Bath door", "Front door"]}, ROOMS), ({"attic": ["Hatch"]}, {})],
)
def test_every_door_may_have_a_contact(doors: dict[str, list[str]], rooms: dict[str, object]) -> None:
    """Without a plan nothing is known of doors."""
    plan = make_plan(parse_config(config(doors, rooms), "homebot.toml"))
    assert plan.control is not None
    assert plan.control.presence_guard is not None
    assert {name: list(ids) for name, ids in plan.control.presence_guard.doors.items()} == doors


@pytest.mark.parametrize(
    ("doors", "key", "problem"),
    [
        ({"bth": ["Bath door"]}, "control.presence_guard.doors.bth", "there is no room 'bth'; did you mean bath?"),
        (
            {"hall": ["Front door"]},
            "control.presence_guard.doors.hall",
            "hall has 2 doors (to bath, outside), but only 1 of them with a contact; each needs one",
        ),
        ({"bath": []}, "control.presence_guard.doors.bath", "should have at least 1 item"),
    ],
)
def test_a_door_without_a_contact_is_an_error(doors: dict[str, list[str]], key: str, problem: str) -> None:
    with pytest.raises(ConfigError) as raised:
        make_plan(parse_config(config(doors), "homebot.toml"))
    assert raised.value.key == key
    assert problem in str(raised.value)


@pytest.mark.parametrize(("stated", "zone"), [({}, "Asia/Kolkata"), ({"time_zone": "Europe/Vienna"}, "Europe/Vienna")])
def test_quiet_hours_go_by_the_zone_of_the_home(stated: dict[str, object], zone: str) -> None:
    """In a container they went by UTC."""
    tables = {"home": {"zone": "Asia/Kolkata"}, "control": {"approvals": True, **stated}}
    plan = make_plan(parse_config(tables, "homebot.toml"))
    assert plan.control is not None
    assert plan.control.time_zone == zone


WRONG_APPS = """\
[apps.lights_out]
[apps.follow_me]
quiet = 3
[apps.control]
class = "homebot.apps.lights_out:LightsOut"
[apps.light_servce]
[apps.window_heating]
act = "lamp in"
[apps.rmf_doors]
quiet = 3
act = "light in hall"
"""


def test_a_wrong_app_is_left_out_and_named_with_its_line(tmp_path: Path) -> None:
    """Any mistake in a table of an app stopped the whole start."""
    file = tmp_path / "homebot.toml"
    file.write_text(WRONG_APPS)
    config = load_config(file)
    plan = make_plan(config)
    assert [app.name for app in plan.apps] == ["lights_out"]
    told = {key: str(error).removeprefix(f"{file}:").partition(": ")[0] for key, error in plan.left_out.items()}
    assert told == {
        "apps.follow_me": "3",
        "apps.control": "4",
        "apps.light_servce": "6",
        "apps.window_heating": "8",
        "apps.rmf_doors": "10",
    }
    grants = {"/window_heating": ("read",), "/rmf_doors": ("act: light in hall",)}
    assert plan.grants.now.scopes == grants, "it may run since before a reload"
    assert plan.scopes["[apps.rmf_doors] act"] == ("act: light in hall",), "control checks it, and stopped by its lack"
    assert {*map(str, plan_errors(config))} == {*map(str, plan.left_out.values())}


@pytest.mark.parametrize(
    ("head", "mistake", "end"),
    [
        pytest.param(
            "",
            '[[routines]]\nname = "r{}"\nwhen = ["hall motion on"]\ndo = ["lamp on"]\nwibble = 3\n',
            "",
            marks=pytest.mark.rooms("routines"),
        ),
        pytest.param(
            '[[routines]]\nname = "r"\nwhen = ["hall motion on"]\ndo = [\n',
            "{},\n",
            "]",
            marks=pytest.mark.rooms("routines"),
        ),
        ("", '[[groups]]\nname = "g{}"\nmembrs = ["lamp"]\n', ""),
        ("", '[apps.a{}]\nclass = "light_service"\nwibble = 3\n', ""),
    ],
)
def test_the_lines_of_twice_as_many_mistakes_cost_twice_as_much(
    tmp_path: Path, head: str, mistake: str, end: str
) -> None:
    """The file was read again for each."""

    def count(mistakes: int) -> int:
        file = tmp_path / "homebot.toml"
        file.write_text(f"{head}{''.join(mistake.format(number) for number in range(mistakes))}{end}")
        config = load_config(file)
        assert len({str(error).split(": ")[0] for error in plan_errors(config)}) >= mistakes
        return calls(lambda: plan_errors(config))

    assert count(80) < 2.3 * count(40)


async def test_a_house_goes_on_without_a_wrong_app_and_says_so() -> None:
    async with Runtime(parse_config(tomllib.loads(WRONG_APPS), "test"), with_door=False) as runtime:
        assert [*runtime.app_host.running] == ["lights_out"]
        told = [one.split(": ")[:3] for one in runtime.app_host.problems()]
    assert ["left out", "test", "apps.control"] in told
    assert len(told) == 5


def test_a_wrong_plan_is_told_once() -> None:
    wrong = config({"bath": ["Bath door"]}, {"bath": {"doors": ["attic"]}})
    (error,) = plan_errors(parse_config(wrong, "homebot.toml"))
    assert error.key == "places.rooms.bath.doors"


def secret_file(folder: Path, name: str = "robot.token", text: str = "hunter2\r\nsecond line\n") -> str:
    file = folder / name
    file.touch(mode=0o600)
    file.write_text(text)
    return name


def test_a_named_token_comes_from_its_file(tmp_path: Path) -> None:
    tables = {"robot": {"token_file": secret_file(tmp_path), "scope": ["read", "act: light in hall"]}}
    settings = make_plan(parse_config({"door": {"tokens": tables}}, "homebot.toml", tmp_path)).door
    assert settings.tokens["robot"].token.get_secret_value() == "hunter2"
    rights = settings.rights(LOCAL_RIGHTS)
    assert (rights["local"], rights["robot"].text) == (LOCAL_RIGHTS, "read, act")


def test_a_named_token_is_enough_to_listen_for_others(tmp_path: Path) -> None:
    tables = {"robot": {"token_file": secret_file(tmp_path), "scope": ["read"]}}
    config = parse_config({"door": {"host": "0.0.0.0", "tokens": tables}}, "homebot.toml", tmp_path)  # noqa: S104
    assert set(make_plan(config).door.rights(LOCAL_RIGHTS)) == {"robot"}


def test_the_token_of_the_environment_is_not_one_more_beside_named_ones(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """There it is that of the command line: it must not get every right by that."""
    monkeypatch.setenv("HOMEBOT_DOOR_TOKEN", "hunter2")
    tables = {"robot": {"token_file": secret_file(tmp_path), "scope": ["read"]}}
    config = with_environment(parse_config({"door": {"tokens": tables}}, "homebot.toml", tmp_path))
    assert set(make_plan(config).door.rights(LOCAL_RIGHTS)) == {"local", "robot"}


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"tokens": 1}, "homebot.toml: door.tokens: must be tables, [door.tokens.NAME]"),
        ({"tokens": {"robot": 1}}, "homebot.toml: door.tokens.robot: must be a table, [door.tokens.robot]"),
        ({"tokens": {"robot": {"scope": ["read"]}}}, "homebot.toml: door.tokens.robot.token_file: is missing"),
        ({"tokens": {"robot": {"token_file": "robot.token"}}}, "homebot.toml: door.tokens.robot.scope: is missing"),
        (
            {"tokens": {"robot": {"token_file": "robot.token", "scope": ["raed"]}}},
            "homebot.toml: door.tokens.robot.scope: 'raed' is not a right; did you mean read or raw?",
        ),
        (
            {"tokens": {"robot": {"token_file": "robot.token", "scope": ["act: ligth"]}}},
            "homebot.toml: door.tokens.robot.scope: 'act: ligth': 'ligth' is neither a type nor a capability",
        ),
        (
            {"tokens": {"robot": {"token_file": "robot.token", "scop": ["read"], "scope": []}}},
            "homebot.toml: door.tokens.robot.scop: unknown key; did you mean scope?",
        ),
        (
            {"tokens": {"robot": {"token_file": "gone", "scope": []}}},
            "homebot.toml: door.tokens.robot.token_file: ",
        ),
        (
            {"tokens": {"local": {"token_file": "robot.token", "scope": []}}},
            "homebot.toml: door.tokens: a token cannot be called 'local'",
        ),
        (
            {"token": "hunter2", "tokens": {"robot": {"token_file": "robot.token", "scope": []}}},
            "homebot.toml: door.tokens: the tokens owner and robot are the same; each needs a secret of its own",
        ),
        (
            {"scope": ["read", "manage", "raw"]},
            "homebot.toml: door.scope: a program without a token may not have manage and raw; give it one: ",
        ),
        ({"scope": ["act"]}, "homebot.toml: door.scope: 'act': act needs a query, or all: 'act: light in hall'"),
    ],
)
def test_a_mistake_is_found_at_the_start_and_names_its_key(
    tmp_path: Path, table: dict[str, object], problem: str
) -> None:
    secret_file(tmp_path)
    with pytest.raises(ConfigError) as caught:
        make_plan(parse_config({"door": table}, "homebot.toml", tmp_path))
    assert str(caught.value).startswith(problem)
    assert "hunter2" not in str(caught.value)
