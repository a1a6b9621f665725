"""``homebot token new``: the file, its mode, and a table that counts; ``homebot token list``."""

import re
import stat
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest
from tests.cli.conftest import NOW

from homebot.cli import main
from homebot.config import load_config
from homebot.devices.access_messages import ListedToken, ListTokens, ListTokensResponse
from homebot.devices.names import LIST_TOKENS
from homebot.graph import Graph, Node
from homebot.messages import Time
from homebot.runtime.plan import make_plan

Text = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HOMEBOT_DOOR_TOKEN", raising=False)


def new(name: str, *scope: str) -> int:
    return main(["token", "new", name, *(word for right in scope for word in ("--scope", right))])


def test_a_token_is_for_its_owner_alone_and_its_table_counts(capsys: Text) -> None:
    """The file of the owner keeps every byte that it had, without an end of its last line too."""
    Path("homebot.toml").write_bytes(b'[home]\r\nname = "villa"  # mine\r\n[gateways.mqtt]')
    assert new("rosie", "read", "act: light in 'guest room'", "robot: rosie") == 0
    assert Path("homebot.toml").read_bytes().startswith(b'[home]\r\nname = "villa"  # mine\r\n[gateways.mqtt]\n')
    assert stat.S_IMODE(Path("rosie.token").stat().st_mode) == 0o600
    secret = Path("rosie.token").read_text().strip()
    token = make_plan(load_config(Path("homebot.toml"))).door.tokens["rosie"]
    assert token.token.get_secret_value() == secret
    assert len(secret) >= 43
    assert token.scope == ("read", "act: light in 'guest room'", "robot: rosie")
    printed = capsys.readouterr().out
    assert secret not in printed
    assert "Authorization: Bearer TOKEN" in printed
    assert "ws://HOST:PORT/?token=TOKEN" in printed


def test_without_a_configuration_the_table_is_printed(capsys: Text) -> None:
    assert new("panel", "read") == 0
    table = capsys.readouterr().out.partition("add to homebot.toml:\n\n")[2].partition("\nA client")[0]
    Path("homebot.toml").write_text(table)
    assert make_plan(load_config(Path("homebot.toml"))).door.tokens["panel"].scope == ("read",)


@pytest.mark.parametrize(
    ("name", "scope", "problem"),
    [
        ("rosie", "fly", "is not a right"),
        ("../rosie", "read", "a token cannot be called '../rosie'"),
        ("owner", "read", "a token cannot be called 'owner'"),
        ("taken", "read", "choose another name"),
        ("old", "read", "old.token cannot be written: File exists; choose another name"),
    ],
)
def test_a_refused_token_leaves_nothing(name: str, scope: str, problem: str, capsys: Text) -> None:
    Path("taken.secret").touch(mode=0o600)
    Path("taken.secret").write_text("s3cret\n")
    Path("old.token").write_text("older\n")
    text = '[door.tokens.taken]\ntoken_file = "taken.secret"\nscope = ["read"]\n'
    Path("homebot.toml").write_text(text)
    assert new(name, scope) == 1
    assert problem in capsys.readouterr().err
    assert Path("homebot.toml").read_text() == text
    assert Path("old.token").read_text() == "older\n"
    assert {one.name for one in Path().iterdir()} == {"taken.secret", "old.token", "homebot.toml"}


def test_a_token_ends_with_its_last_day_in_the_zone_of_the_home() -> None:
    Path("homebot.toml").write_text('[home]\nzone = "Europe/Berlin"\n')
    assert main(["token", "new", "guest", "--scope", "read", "--until", "2099-12-31"]) == 0
    until = make_plan(load_config(Path("homebot.toml"))).door.tokens["guest"].until
    assert datetime.fromtimestamp(until, UTC) == datetime(2099, 12, 31, 23, tzinfo=UTC)
    for written in ("2099-12-31 18:30", "2099-12-31T17:30Z"):
        Path("homebot.toml").write_text(Path("homebot.toml").read_text().replace("2099-12-31", written, 1))
        until = make_plan(load_config(Path("homebot.toml"))).door.tokens["guest"].until
        assert datetime.fromtimestamp(until, UTC) == datetime(2099, 12, 31, 17, 30, tzinfo=UTC)
        Path("homebot.toml").write_text(Path("homebot.toml").read_text().replace(written, "2099-12-31", 1))


@pytest.mark.parametrize(
    ("until", "problem"),
    [("tomorrow", "'tomorrow' is no date; write it like 2026-12-31"), ("2020-01-01", "its end (--until) is over")],
)
def test_an_end_that_is_none_makes_no_token(until: str, problem: str, capsys: Text) -> None:
    assert main(["token", "new", "guest", "--scope", "read", "--until", until]) == 1
    assert problem in capsys.readouterr().err
    assert not Path("guest.token").exists()


def _with_tokens(graph: Graph) -> Node:
    node = Node(graph, "owner_of_tokens")
    tokens = (
        ListedToken(name="owner", used_at=Time.from_seconds(NOW), is_connected=True),
        ListedToken(name="guest", scope=("read",), until=NOW - 60, used_at=Time.from_seconds(NOW - 300)),
        ListedToken(name="panel", scope=("read", "act: light"), used_at=Time.from_seconds(0.0)),
    )
    answer = ListTokensResponse(since=Time.from_seconds(NOW - 900), tokens=tokens)
    node.create_service(ListTokens, LIST_TOKENS, lambda _: answer)
    return node


def test_the_list_has_each_token_with_its_rights_its_end_and_its_last_use(
    run_with: Callable[[Callable[[Graph], Node]], Callable[..., tuple[int, str]]],
) -> None:
    run = run_with(_with_tokens)
    code, text = run("token", "list")
    lines = [
        re.split(r"  +", line) for line in text.splitlines() if line.startswith(("TOKEN", "owner", "guest", "panel"))
    ]
    assert (code, lines[0]) == (0, ["TOKEN", "RIGHTS", "UNTIL", "LAST USED"])
    assert lines[1][1:] == ["every right", "now"]
    assert (lines[2][1], lines[2][2][-6:], lines[2][3]) == ("read", "(over)", "5 min ago")
    assert lines[3][1] == "read, act: light"
    assert lines[3][2].endswith("the start of homebot")
    used = re.findall(r'"used_at": "?([^",]*)', run("token", "list", "--json")[1])
    assert used == ["2027-01-15T08:00:00.000Z", "2027-01-15T07:55:00.000Z", "null"]
