"""Where client commands connect to: the homebot of the configuration beside them, and no other."""

from pathlib import Path
from typing import Any

import pytest

from homebot.cli import main

Text = pytest.CaptureFixture[str]
TOKEN = "hunter2"  # of the locked homebot
NOWHERE = "127.0.0.1:1"
OTHERS = "has the address of homebot; others must not be able to change it"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory; the environment names a homebot that does not exist."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOMEBOT_DOOR", NOWHERE)
    monkeypatch.delenv("HOMEBOT_DOOR_TOKEN", raising=False)
    return tmp_path


def nodes(*arguments: str) -> int:
    return main([*arguments, "node", "list"])


@pytest.mark.parametrize("host", ["", 'host = "127.0.0.1"\n', 'host = "0.0.0.0"\n'])
def test_the_configuration_beside_says_which_homebot_is_meant(homebot: Any, folder: Path, host: str) -> None:
    assert nodes() == 1
    (folder / "homebot.toml").write_text(f"[door]\n{host}port = {homebot.port}\n[gateways.unheard]\nof = 1\n")
    assert nodes() == 0
    assert nodes("--door", NOWHERE) == 1


def test_a_port_alone_is_one_of_this_computer(homebot: Any) -> None:
    assert nodes("--door", str(homebot.port)) == 0


def test_a_homebot_of_another_home_than_that_of_the_configuration_is_refused(
    homebot: Any, folder: Path, capsys: Text
) -> None:
    """It was commanded: another homebot may have taken the usual port."""
    (folder / "homebot.toml").write_text(f'[home]\nname = "villa"\n[door]\nport = {homebot.port}\n')
    assert nodes() == 1
    error = capsys.readouterr().err
    assert f"for the home 'villa', but the homebot on 127.0.0.1:{homebot.port} serves 'Café'; give the address" in error
    (folder / "homebot.toml").write_text(f'[home]\nname = "Café"\n[door]\nport = {homebot.port}\n')
    assert nodes() == 0


@pytest.fixture
def homes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    file = tmp_path / "settings" / "homebot" / "homes.toml"
    file.parent.mkdir(parents=True)
    return file


def test_a_home_is_named(locked_homebot: Any, homes: Path, monkeypatch: pytest.MonkeyPatch, capsys: Text) -> None:
    homes.write_text(
        f'[villa]\ndoor = "{locked_homebot.port}"\ntoken_file = "villa.token"\n[flat]\ndoor = "{NOWHERE}"\n'
    )
    (homes.parent / "villa.token").write_text(f"{TOKEN}\n")
    assert nodes("--home", "villa") == 0
    monkeypatch.setenv("HOMEBOT_DOOR_TOKEN", TOKEN)
    assert nodes("--home", "flat") == 1
    assert f"no homebot is running on {NOWHERE}, the address in {homes}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "arguments", "said"),
    [
        (None, (), "homes.toml does not exist; write a table [villa] with door ="),
        ("[vila]\ndoor = '1.2.3.4:5'\n", (), "homes.toml: villa: there is no such home; did you mean vila?"),
        ("[villa]\nport = 1\n", (), "homes.toml: villa: has no address; write a table [villa]"),
        ("[villa]\ndoor = 'x'\n", (), "homes.toml: villa.door: an address is HOST:PORT"),
        ("[villa]\ndoor = '1'\ntoken = 'x'\n", (), "homes.toml: villa.token: unknown key; did you mean token_file"),
        ("[villa]\ndoor = '1'\n", ("--door", "1"), "--home and --door both give the address of homebot"),
    ],
)
def test_a_home_that_is_not_known_is_told(
    homes: Path, capsys: Text, text: str | None, arguments: tuple[str, ...], said: str
) -> None:
    if text is not None:
        homes.write_text(text)
    assert nodes("--home", "villa", *arguments) == 1
    assert said in capsys.readouterr().err


def test_a_command_that_changes_something_names_the_home_on_a_terminal(
    homebot: Any, monkeypatch: pytest.MonkeyPatch, capsys: Text
) -> None:
    monkeypatch.setenv("HOMEBOT_DOOR", homebot.door)
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    assert main(["service", "call", "/switch", "{data: true}"]) == 0
    assert f"in Café on {homebot.door}" in capsys.readouterr().err
    assert nodes() == 0
    assert "Café" not in capsys.readouterr().err


def test_one_that_names_no_address_leaves_it_to_the_environment(
    homebot: Any, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "homebot.toml").write_text('[home]\nname = "Café"\n[door]\nmax_calls = 5\n')
    assert nodes() == 1
    monkeypatch.setenv("HOMEBOT_DOOR", homebot.door)
    assert nodes() == 0


@pytest.mark.parametrize(("misspelt", "meant"), [("prot", "port"), ("token_fiel", "token_file")])
def test_a_misspelt_key_is_refused_as_another_homebot_may_be_at_the_usual_port(
    folder: Path, capsys: Text, misspelt: str, meant: str
) -> None:
    (folder / "homebot.toml").write_text(f"[door]\n{misspelt} = 9191\n")
    assert nodes() == 1
    assert f"homebot.toml: door.{misspelt}: unknown key; did you mean {meant}" in capsys.readouterr().err


def test_its_token_is_sent_to_its_homebot_alone(locked_homebot: Any, folder: Path, capsys: Text) -> None:
    port = locked_homebot.port
    (folder / "secret").write_text(f"{TOKEN}\nmore\n")
    for token in ('token_file = "secret"', f'token = "{TOKEN}"'):
        (folder / "homebot.toml").write_text(f"[door]\nport = {port}\n{token}\n")
        assert nodes() == 0
        assert nodes("--door", locked_homebot.door) == 1
        assert "--token-file" in capsys.readouterr().err
    (folder / "wrong").write_text("wrong")
    assert nodes("--token-file", "wrong") == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[door]\nport = 1\n", "no homebot is running on 127.0.0.1:1, the address in homebot.toml; start one"),
        ("[door]\nport = 0\n", "homebot.toml: door.port: must be a port for clients, got 0; give --door"),
        ('[door]\nport = "x"\n', "homebot.toml: door.port: must be a port for clients, got 'x'"),
        ("[door]\nhost = 1\n", "homebot.toml: door.host: must be a host, got 1"),
        ("[door\n", "homebot.toml is invalid TOML"),
        ("door = 1\n", "homebot.toml: door: must be a table, [door]"),
        ('[door]\ntoken_file = "none"\n', "homebot.toml: door.token_file: none: cannot be read"),
    ],
)
def test_what_cannot_be_used_is_told(folder: Path, capsys: Text, text: str, said: str) -> None:
    (folder / "homebot.toml").write_text(text)
    assert nodes() == 1
    assert said in capsys.readouterr().err


def test_one_that_others_may_change_is_not_followed(homebot: Any, folder: Path, capsys: Text) -> None:
    """It would have the token of the environment sent to them."""
    (folder / "homebot.toml").write_text(f"[door]\nport = {homebot.port}\n")
    (folder / "homebot.toml").chmod(0o666)
    assert nodes() == 1
    assert OTHERS in capsys.readouterr().err
