"""``homebot service install``: the unit of systemd."""

import re
import shlex
import sys
from importlib.util import cache_from_source
from pathlib import Path

import pytest

from homebot.cli import main
from homebot.cli.commands.service import keep_compiled

Text = pytest.CaptureFixture[str]


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "my % house"
    folder.mkdir()
    monkeypatch.chdir(folder)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))
    file = folder / "homebot.toml"
    file.write_text('[gateways.mqtt]\nurl = "embedded"\n[door]\nport = 0\n')
    return file


def _keys(text: str) -> dict[str, str]:
    return dict(line.split("=", 1) for line in text.splitlines() if "=" in line)


def test_the_unit_of_a_user_runs_homebot_and_can_be_reloaded(config: Path, tmp_path: Path, capsys: Text) -> None:
    assert main(["service", "install", "--user"]) == 0
    file = tmp_path / "settings" / "systemd" / "user" / "homebot.service"
    keys = _keys(file.read_text())
    assert shlex.split(keys["ExecStart"].replace("%%", "%")) == [
        sys.executable,
        *("-m", "homebot", "run", "--config", str(config)),
    ]
    assert (keys["Type"], keys["ExecReload"], keys["WatchdogSec"]) == ("notify", "kill -HUP $MAINPID", "30")
    assert keys["WantedBy"] == "default.target"
    assert "User" not in keys
    printed = capsys.readouterr().out
    assert f"wrote {file}" in printed
    assert "systemctl --user enable --now homebot" in printed
    assert "enable-linger" in printed


def test_the_unit_of_the_computer_is_hardened(config: Path, capsys: Text) -> None:
    assert main(["service", "install", "--print", "--config", str(config)]) == 0
    keys = _keys(capsys.readouterr().out)
    expected = {"User": "homebot", "ProtectSystem": "strict", "NoNewPrivileges": "yes", "CapabilityBoundingSet": ""}
    assert expected.items() <= keys.items()
    assert "AF_BLUETOOTH" in keys["RestrictAddressFamilies"]
    assert keys["WantedBy"] == "multi-user.target"


def test_a_wrong_configuration_is_not_installed(config: Path, tmp_path: Path, capsys: Text) -> None:
    config.write_text("[control]\ntmeout = 1\n")
    assert main(["service", "install", "--user"]) == 1
    assert "control.tmeout: unknown key" in capsys.readouterr().err
    assert not (tmp_path / "settings").exists()


def test_the_commands_of_the_guide_work(config: Path, capsys: Text) -> None:
    guide = (Path(__file__).parents[2] / "docs" / "operate.md").read_text()
    commands = re.findall(r"^\$ homebot (.*)$", guide, re.MULTILINE)
    assert len(commands) == 6
    for command in commands:
        assert main(shlex.split(command)) == 0
    assert "[door.tokens.panel]" in config.read_text()
    assert capsys.readouterr().err == ""


def test_what_the_service_runs_is_compiled_as_it_may_not_write_beside_it(tmp_path: Path) -> None:
    """An installation by uv, and a clone, have no compiled files: each start compiled 434 modules."""
    (tmp_path / "one.py").write_text("ONE = 1\n")
    keep_compiled(tmp_path)
    assert Path(cache_from_source(str(tmp_path / "one.py"))).exists()
