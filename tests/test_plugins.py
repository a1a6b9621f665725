"""Plug-ins: found by name or by path, and a clear word when they are not."""

import json
import os
import subprocess
import sys
from importlib.metadata import Distribution
from pathlib import Path

import pytest
from tests.source_trees import SOURCE

from homebot.apps.light_service import LightService
from homebot.errors import PluginError, UsageError
from homebot.plugins import add_app, check_extra, load_plugin, name_in_file, plugin_names, plugin_path


def test_installed_plugins_are_found_by_name() -> None:
    """The light service comes with homebot."""
    assert "light_service" in plugin_names("homebot.apps")
    assert load_plugin("homebot.apps", "light_service") is LightService


@pytest.mark.rooms("thesis")  # without it, tests bring a layout of their own
def test_an_integration_or_a_feature_names_classes_of_its_own_beside_it() -> None:
    folders = {file.parent for file in SOURCE.glob("*/*/entry_points.txt")}
    assert folders >= {file.parent for file in SOURCE.glob("integrations/*/__init__.py")}
    for folder in folders:
        for point in Distribution.at(folder).entry_points:
            assert plugin_path(point.group, point.name) == point.value
            assert point.value.startswith(f"homebot.{folder.parent.name}.{folder.name}.")


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


def test_two_files_of_one_folder_have_the_names_that_their_neighbours_import_them_by(tmp_path: Path) -> None:
    """So a recording of both names their classes as one of each alone does."""
    for name in ("first_neighbour", "second_neighbour"):
        (tmp_path / f"{name}.py").write_text("class Mine: pass\n")
    found = [load_plugin("homebot.apps", f"{tmp_path}/{name}_neighbour.py:Mine") for name in ("first", "second")]
    assert [one.__module__ for one in found] == ["first_neighbour", "second_neighbour"]


def test_a_class_in_a_file_is_found_also_where_a_module_of_that_name_is_installed(tmp_path: Path) -> None:
    """The module stays what it was; and the file is run anew once it has changed."""
    file = tmp_path / "json.py"
    file.write_text("class Mine: number = 1\n")
    found = load_plugin("homebot.apps", f"{file}:Mine")
    assert (found.__module__, found.number) == ("file_json", 1)
    assert load_plugin("homebot.apps", f"{file}:Mine") is found
    file.write_text("class Mine: number = 2\n")
    os.utime(file, ns=(1, 1))
    assert load_plugin("homebot.apps", f"{file}:Mine").number == 2
    assert sys.modules["json"] is json


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("class A(int): pass\nclass B(int): pass\n", r"must be one class, .*; the file has A, B"),
        ("class A: pass\nfrom enum import IntEnum\n", "; the file has no class of its own that is derived from int"),
        (
            "class A(int): pass\nraise SystemExit(0)\n",
            r"it calls sys\.exit\(\) \(.*\.py, line 2\); a program begins below `if",
        ),
        (
            "from homebot import run\nclass A(int): pass\nrun(A)\n",
            r"homebot loads this file itself; put run\(\) below `if",
        ),
        ("class A(int): pass\n1 / 0\n", r"cannot be loaded: ZeroDivisionError: division by zero \(.*\.py, line 2\)"),
    ],
)
def test_a_file_without_one_class_is_told_so(tmp_path: Path, text: str, problem: str) -> None:
    file = tmp_path / "apps_of_mine.py"
    file.write_text(text)
    with pytest.raises(PluginError, match=problem):
        name_in_file(str(file), int)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("{}", r"must be FILE\.py:CLASS, with the name of a class in that file"),
        ("{}:Window", "cannot be loaded: the file has no 'Window'$"),
        ("{}:Nightlight", r"cannot be loaded: the file has no 'Nightlight'; did you mean NightLight\?"),
        ("{}:b", "is 1, not a class"),
        ("nosuch.py:B", r"cannot be loaded: there is no file nosuch\.py"),
    ],
)
def test_what_is_no_class_in_a_file_is_told_so(tmp_path: Path, name: str, problem: str) -> None:
    file = tmp_path / "apps_of_mine.py"
    file.write_text("from pathlib import Path\nclass NightLight: pass\nb = 1\n")
    with pytest.raises(PluginError, match=problem):
        load_plugin("homebot.apps", name.format(file))


def test_a_file_that_others_may_change_is_not_run(tmp_path: Path) -> None:
    file = tmp_path / "apps_of_mine.py"
    file.write_text("class A: pass\n")
    file.chmod(0o666)
    with pytest.raises(PluginError, match=r"is not loaded: .* can be written by others"):
        load_plugin("homebot.apps", f"{file}:A")


def test_a_module_without_its_class_is_told_how_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "window_light.py").write_text("class WindowLight: pass\n")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PluginError, match=r"is not installed .*; did you mean window_light:CLASS, with the name of"):
        load_plugin("homebot.apps", "window_light")


def test_a_misspelt_plug_in_is_told_with_the_one_that_is_like_it() -> None:
    with pytest.raises(PluginError, match=r"'light_servce' is not installed .*; did you mean light_service\?"):
        load_plugin("homebot.apps", "light_servce")
    with pytest.raises(PluginError, match=r'write class = "NAME" for one more of these'):
        load_plugin("homebot.gateways", "shed")
    with pytest.raises(PluginError, match=r"one of the conventions of mqtt: the table \[gateways.mqtt\] is enough"):
        load_plugin("homebot.gateways", "thesis")


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


def test_the_libraries_of_an_extra_are_all_installed() -> None:
    """The standard library is."""
    check_extra('the gateway "mdns"', "mdns", "json", "socket")


def test_a_missing_library_names_the_command_that_installs_it() -> None:
    """So that nobody has to look it up."""
    with pytest.raises(UsageError) as caught:
        check_extra('the gateway "mdns"', "mdns", "json", "no_such_library")
    assert str(caught.value) == 'the gateway "mdns" needs no_such_library; install it with: pip install "homebot[mdns]"'


def test_plugins_of_homebot_load_without_the_libraries_of_extras() -> None:
    """Their check then names the extra."""
    libraries = ("aiocoap", "aioesphomeapi", "aiohomekit", "aiohttp", "bleak", "ndef", "nfc", "yarl", "zeroconf")
    code = f"""
import sys
sys.modules.update(dict.fromkeys({libraries}))
from homebot.plugins import load_plugin, plugin_names
for group in ("homebot.gateways", "homebot.drivers", "homebot.ble_parsers"):
    for name in plugin_names(group):
        load_plugin(group, name)
"""
    ended = subprocess.run([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")


@pytest.mark.parametrize("wanted", ["hall.py:Hall", "hall:Hall"])
def test_an_app_with_a_table_is_added_once_however_its_file_is_written(
    wanted: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    apps: dict[str, dict[str, object]] = {"mine": {"class": f"{tmp_path}/hall.py:Hall"}}
    add_app(apps, wanted)
    assert list(apps) == ["mine"]
