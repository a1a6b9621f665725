"""A new app passes its own test; the guide to a first app checks its configuration and runs it."""

import subprocess
import sys
from pathlib import Path

import pytest

from homebot.cli.main import main


@pytest.mark.slow
@pytest.mark.parametrize("plugins", [(), ("-p", "no:asyncio")], ids=["with_asyncio", "without"])
def test_a_new_folder_passes_without_a_warning(tmp_path: Path, plugins: tuple[str, ...]) -> None:
    assert main(["new", str(tmp_path / "Hall-Light")]) == 0
    folder = tmp_path / "Hall-Light"
    code = "hall_light.py", "hall_light.service", "test_hall_light.py"
    assert {path.name for path in folder.iterdir()} == {*code, "homebot.toml", "house.toml", "pytest.ini"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *plugins]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120, cwd=folder)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert "warning" not in done.stdout


def test_a_folder_with_any_name_has_the_unit_of_service_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With a percent sign in its path the unit had another folder."""
    folder = tmp_path / "100% mine" / "attic_light"  # loaded, and so taken in later tests
    assert main(["new", str(folder)]) == 0
    monkeypatch.chdir(folder)
    capsys.readouterr()
    assert main(["service", "install", "--user", "--print"]) == 0
    assert capsys.readouterr().out == (folder / "attic_light.service").read_text()


def test_nothing_is_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "my porch"
    assert main(["new", str(folder)]) == 0
    assert f"try it: cd '{folder}' && " in capsys.readouterr().out
    before = (folder / "my_porch.py").read_text()
    assert main(["new", str(folder)]) == 1
    assert f"homebot: {folder}/my_porch.py exists; give another folder" in capsys.readouterr().err
    assert (folder / "my_porch.py").read_text() == before


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("7", "an app cannot be named after the folder '7'; use letters, such as hall_light"),
        ("class", "an app cannot be named after the folder 'class'"),
        ("json", "there is a module 'json' already; give the folder another name, such as my_json"),
    ],
)
def test_a_name_that_no_app_can_have_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, problem: str
) -> None:
    assert main(["new", str(tmp_path / name)]) == 1
    assert problem in capsys.readouterr().err
    assert not (tmp_path / name).exists()
