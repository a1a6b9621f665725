"""A new feature is found where it is installed, passes its own test, answers, and leaves no trace when it is gone."""

import sys
from pathlib import Path

import pytest
from tests.guide import commands_in, guide
from tests.shell import homebot_in, installed_package, run

from homebot.cli.main import main

NEW, ENTER, INSTALL, TEST, RUN, *ASKED = commands_in(guide("features"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the guide, installed beside it."""
    return installed_package(tmp_path_factory.mktemp("there"), NEW, ENTER, INSTALL, TEST, RUN)


@pytest.mark.slow
@pytest.mark.rooms("thesis")
def test_it_passes_its_test_and_answers_and_without_its_package_nothing_of_it_is_left(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(folder.parent / "installed"))
    done = run(f"{sys.executable} -m {TEST} -q -p no:cacheprovider -p no:xdist", cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    with homebot_in(
        folder, *RUN.removeprefix("homebot run ").split(), "--ephemeral", until=("hall_lamp on mqtt",)
    ) as homebot:
        answers = [run(f"{sys.executable} -m {command}", door=homebot.door) for command in ASKED]
        assert [answer.returncode for answer in answers] == [0, 0, 0]
        assert (answers[0].stdout, answers[-1].stdout) == ("none\n", "hall_lamp\n")
    monkeypatch.delenv("PYTHONPATH")
    assert "no command 'lit'" in run(f"{sys.executable} -m {ASKED[0]}", cwd=folder).stderr


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["7"], "a feature cannot be named after the folder '7'; use letters, such as acme"),
        (["devices"], "there is a feature 'devices' already; give the folder another name, such as my_devices"),
        (["goals"], "there is a feature 'goals' already"),
        ([], "a feature needs a name: homebot new feature NAME"),
    ],
)
def test_a_name_that_no_feature_can_have_is_refused(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    problem: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "feature", *arguments]) == 1
    assert problem in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
