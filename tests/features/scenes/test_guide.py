"""What docs/scenes.md shows works."""

import ast
import tomllib
from collections.abc import Iterator

import pytest
from tests.guide import blocks_in, commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

from homebot.config import parse_config
from homebot.features.scenes.settings import read_scenes

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("scenes")
COMMANDS = commands_in(GUIDE)


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    """The house of a reader, with its errands, and the guide's configuration."""
    until = ("found hall_lamp", "found kitchen_lamp", "found shellyswitch25", "is running")
    folder = tmp_path_factory.mktemp("house")
    (folder / "dinner.toml").write_text(f"[gateways.mqtt]\n{blocks_in(GUIDE, 'toml')[0]}")
    with homebot_in(folder, "--config", "dinner.toml", "--house", "family", "--ephemeral", until=until) as homebot:
        yield homebot


def test_the_commands_of_the_guide_run_in_its_order(home: Homebot) -> None:
    for command in COMMANDS:
        done = home.run(command)
        assert (done.returncode, done.stdout != "") == (0, True), done


def test_saving_hides_no_scene_of_the_configuration(home: Homebot) -> None:
    done = home.run("homebot scene save dinner 'Hall lamp'")
    assert (done.returncode, "change it there, and `homebot reload`, or choose another name" in done.stderr) == (
        1,
        True,
    )
    assert "configuration" in home.run("homebot scene list").stdout


def test_the_scene_of_the_configuration_is_read() -> None:
    (shown,) = blocks_in(GUIDE, "toml")
    (scene,) = read_scenes(parse_config(tomllib.loads(shown), "homebot.toml"))
    assert scene.name == "Dinner"


def test_the_program_of_the_guide_is_python() -> None:
    (shown,) = blocks_in(GUIDE, "python")
    compile(shown, "guide", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
