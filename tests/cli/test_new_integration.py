"""A new integration is found where it is installed, passes its own tests, and its devices obey in a simulated house."""

import re
import sys
from pathlib import Path

import pytest
from tests.guide import commands_in, guide
from tests.shell import homebot_in, installed_package, run

from homebot.cli.main import main

NEW, ENTER, INSTALL, TEST, RUN, *ASKED = commands_in(guide("gateways").partition("\n## Write")[0])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the guide, installed beside it."""
    return installed_package(tmp_path_factory.mktemp("there"), NEW, ENTER, INSTALL, TEST, RUN)


@pytest.fixture(autouse=True)
def _installed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(folder.parent / "installed"))


@pytest.mark.slow
@pytest.mark.parametrize("plugins", ["", " -o addopts= -o asyncio_default_fixture_loop_scope=function"])
def test_its_tests_pass_as_written(folder: Path, plugins: str) -> None:
    """With homebot's own runner, and with pytest-asyncio."""
    done = run(f"{sys.executable} -m {TEST} -q -p no:cacheprovider -p no:xdist{plugins}", cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert "warning" not in done.stdout


@pytest.mark.slow
def test_its_simulated_lamp_is_found_and_obeys(folder: Path) -> None:
    until = ("found desk_lamp on mqtt", "found desk_lux on mqtt", "found study_temperature on mqtt")
    assert ASKED
    with homebot_in(folder, *RUN.removeprefix("homebot run ").split(), "--ephemeral", until=until) as homebot:
        for command in ASKED:
            done = homebot.run(command)
            assert (done.returncode, done.stderr) == (0, ""), command
        shown = homebot.run("homebot devices").stdout
    assert re.search(r"desk_lamp +light +study +on, 40 %", shown), shown
    assert re.search(r"desk_lux +light_sensor +study +60 lx", shown), shown
    assert re.search(r"study_temperature +temperature_sensor +study +\d+(\.\d)? °C", shown), shown


def test_nothing_is_written_over(folder: Path) -> None:
    again = run(NEW, cwd=folder.parent)
    assert (again.returncode, again.stdout) == (1, "")
    assert again.stderr.endswith("acme/homebot_acme/__init__.py exists; give another folder\n")


def test_a_name_of_several_words_is_one_in_each_spelling(tmp_path: Path) -> None:
    assert main(["new", "integration", str(tmp_path / "homebot-North-Star")]) == 0
    folder = tmp_path / "homebot-North-Star"
    for module in folder.glob("**/*.py"):
        compile(module.read_text(), module, "exec")
    assert 'north_star = "homebot_north_star.formats:NorthStar"' in (folder / "pyproject.toml").read_text()


@pytest.mark.rooms("wled", "zigbee2mqtt")
@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["7"], "an integration cannot be named after the folder '7'; use letters, such as acme"),
        (["none"], "an integration cannot be named after the folder 'none'"),
        (["zigbee2mqtt"], "there is an integration 'zigbee2mqtt' already; give the folder another name, such as my_"),
        (["wled"], "there is an integration 'wled' already"),
        ([], "an integration needs a name: homebot new integration NAME"),
    ],
)
def test_a_name_that_no_integration_can_have_is_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    problem: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "integration", *arguments]) == 1
    assert problem in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
