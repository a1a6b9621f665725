"""``homebot token new``: the file, its mode, and a table that counts."""

import stat
from pathlib import Path

import pytest

from homebot.cli import main
from homebot.config import load_config
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
