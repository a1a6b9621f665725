"""Every command of the guides for the first day runs, in the house of a new app."""

import re
import shlex
import sys
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path

import pytest
from tests.guide import blocks_in, commands_in
from tests.guides.write_programs import change_first_app
from tests.patience import PATIENCE
from tests.ports import reserve_door
from tests.shell import Homebot, homebot_in
from tests.system.attack_probe import until

from homebot.cli.main import main
from homebot.house import World
from homebot.house.description import load_world
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("zigbee2mqtt")]

DOCS = Path(__file__).parents[2] / "docs"
FIRST_APP, YOUR_HOUSE, TROUBLESHOOT = (
    (DOCS / f"{name}.md").read_text("utf-8") for name in ("first-app", "your-house", "troubleshoot")
)
COMMANDS = [
    *commands_in(FIRST_APP + YOUR_HOUSE),
    *re.findall(r"^\| [^|]+ \| `(.*?)` \|", TROUBLESHOOT, re.MULTILINE),
]
RUN_OTHERWISE = {
    "homebot new hall_light",
    "cd hall_light",
    "pytest",
    "homebot run --house house.toml",
    "homebot run",
    "homebot doctor --offline --reach",
}
"""By the fixture, and by tests of their own: here is no broker of a house."""
ASKED = [command for command in dict.fromkeys(COMMANDS) if command not in RUN_OTHERWISE]
HOUSE = """
[devices.hall_lamp]
kind = "lamp"
room = "hall"
dialect = "zigbee2mqtt"
[devices.front_door]
kind = "lock"
room = "hall"
dialect = "zigbee2mqtt"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    made = tmp_path_factory.mktemp("home")
    with chdir(made):
        assert main(["new", "hall_light"]) == 0
    path = made / "hall_light"
    house = path / "house.toml"
    house.write_text(house.read_text() + HOUSE)
    until = ("lights/hall on mqtt", "found hall_lamp", "found front_door", "running the app hall_light")
    with homebot_in(path, "--house", "house.toml", until=until) as homebot:
        yield homebot


@pytest.mark.parametrize("command", ASKED)
def test_a_command_of_the_guides_runs(
    folder: Homebot, command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each prints something and succeeds."""
    monkeypatch.chdir(folder.folder)
    monkeypatch.setenv("HOMEBOT_DOOR", reserve_door() if "--offline" in command else folder.door)  # before the start
    monkeypatch.setenv("XDG_CONFIG_HOME", str(folder.folder / "settings"))
    monkeypatch.setenv("HOMEBOT_DATA", str(folder.folder / "data"))
    monkeypatch.setattr(sys, "path", [*sys.path])
    program, *words = shlex.split(command)
    assert program == "homebot"
    if words[0] == "history":
        until(lambda: main(words) == 0 or None, PATIENCE)  # it begins after the start
    codes = {0, 1} if words[0] == "doctor" else {0}  # a busy machine is a problem that it reports
    assert main(words) in codes, capsys.readouterr()
    assert capsys.readouterr().out
    sys.modules.pop("hall_light", None)  # loaded by the check of its configuration


@pytest.mark.parametrize("shown", blocks_in(YOUR_HOUSE, "toml"))
def test_the_configurations_of_the_house_pass_their_check(
    shown: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "homebot.toml").write_text(shown)
    token = tmp_path / "homeassistant.token"
    token.touch(0o600)
    token.write_text("secret\n")
    assert main(["config", "check", "--config", str(tmp_path / "homebot.toml")]) == 0
    assert "is valid: home " in capsys.readouterr().out


@pytest.fixture
def changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> World:
    """Change a new app as the guide says, and return the house beside it."""
    monkeypatch.chdir(tmp_path)
    assert main(["new", "shining_hall"]) == 0
    folder = tmp_path / "shining_hall"
    change_first_app(folder / "shining_hall.py")
    monkeypatch.syspath_prepend(str(folder))
    __import__("shining_hall")
    return load_world(folder / "house.toml")


@pytest.mark.virtual_time
async def test_the_change_of_the_first_app_passes_the_test_of_its_guide(changed: World) -> None:
    """Its steps are those shown."""
    (steps,) = re.findall(r"(    await house\.press.*?)```", FIRST_APP, re.DOTALL)
    shown: dict[str, object] = {}
    exec(f"async def test(house):\n{steps}", shown)  # noqa: S102 - our own guide
    test = shown["test"]
    assert callable(test)
    async with virtual_house_of("shining_hall:HallLight", world=changed) as house:
        await test(house)
