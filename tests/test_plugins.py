"""Plug-ins: found by name or by path, and a clear word when they are not."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from homebot.apps.light_service import LightService
from homebot.errors import PluginError
from homebot.plugins import load_plugin, plugin_names


def test_installed_plugins_are_found_by_name() -> None:
    """The light service comes with homebot."""
    assert "light_service" in plugin_names("homebot.apps")
    assert load_plugin("homebot.apps", "light_service") is LightService


def test_a_package_that_comes_onto_the_path_later_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As where a notebook or a test adds a folder of packages."""
    assert "late" not in plugin_names("homebot.apps")
    info = tmp_path / "late-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: late\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[homebot.apps]\nlate = homebot.apps.light_service:LightService\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert "late" in plugin_names("homebot.apps")
    assert load_plugin("homebot.apps", "late") is LightService


def test_a_name_of_homebot_s_own_is_no_other_package_s(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where that package is found first."""
    info = tmp_path / "other-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[homebot.apps]\nlight_service = homebot.apps.follow_me:FollowMe\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert load_plugin("homebot.apps", "light_service") is LightService


def test_an_unknown_name_is_told_with_what_is_installed() -> None:
    """So that a slip of the pen is seen at once."""
    with pytest.raises(PluginError, match=r"plug-in 'lightservice' is not installed \(installed: .*light_service"):
        load_plugin("homebot.apps", "lightservice")


def test_a_module_without_its_class_is_told_how_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "window_light.py").write_text("class WindowLight: pass\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PluginError, match=r"is not installed .*; did you mean window_light:CLASS, with the name of"):
        load_plugin("homebot.apps", "window_light")


def test_a_misspelt_plug_in_is_told_with_the_one_that_is_like_it() -> None:
    with pytest.raises(PluginError, match=r"'light_servce' is not installed .*; did you mean light_service\?"):
        load_plugin("homebot.apps", "light_servce")


def test_a_class_of_your_own_is_found_in_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``python -m`` would find its module."""
    (tmp_path / "my_first_app.py").write_text("class Mine: pass\nnothing = 3\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*__import__("sys").path])

    assert load_plugin("homebot.apps", "my_first_app:Mine").__name__ == "Mine"
    with pytest.raises(PluginError, match="has no 'Yours'"):
        load_plugin("homebot.apps", "my_first_app:Yours")
    with pytest.raises(PluginError, match="not a class"):
        load_plugin("homebot.apps", "my_first_app:nothing")


def test_a_module_of_the_working_directory_shadows_none_that_is_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It comes last, also after another was taken from there."""
    (tmp_path / "my_second_app.py").write_text("import colorsys\n\nclass Mine: path = colorsys.__file__\n")
    for name in ("colorsys", "chunk"):
        (tmp_path / f"{name}.py").write_text("class Mine: pass\n")
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])

    found = load_plugin("homebot.apps", "my_second_app:Mine")
    assert not found.path.startswith(str(tmp_path))
    assert sys.path[-1] == str(tmp_path)
    with pytest.raises(PluginError, match="has no 'Mine'"):
        load_plugin("homebot.apps", "colorsys:Mine")


def test_python_m_homebot_does_not_look_into_the_working_directory_first(tmp_path: Path) -> None:
    (tmp_path / "argparse.py").write_text("raise SystemExit('this was run')\n")
    done = subprocess.run(
        [sys.executable, "-m", "homebot", "--version"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_a_module_that_cannot_be_imported_is_told_with_its_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The author's own mistake, in its own words."""
    (tmp_path / "my_broken_app.py").write_text("import nothing_of_that_name\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*__import__("sys").path])
    with pytest.raises(PluginError, match=r"'my_broken_app' cannot be imported: ModuleNotFoundError"):
        load_plugin("homebot.apps", "my_broken_app:App")
