"""Integrations, features and rclpy's spelling can each be taken out: without its folder and its tests, all is whole.

In `make test` several are taken out at once, so that each is missed by each other one; in `make nightly` each alone.
"""

import importlib
import multiprocessing
import os
import pkgutil
import re
import subprocess
import sys
from collections.abc import Callable, Collection
from itertools import combinations, permutations
from pathlib import Path
from shutil import copytree, ignore_patterns, rmtree

import pytest
from tests.sizes import NIGHTLY, nightly

ROOT = Path(__file__).parents[2]
INTEGRATIONS, FEATURES = (
    sorted(f"{kind}/{one.parent.name}" for one in (ROOT / "src/homebot" / kind).glob("*/__init__.py"))
    for kind in ("integrations", "features")
)
STAND_INS = """
[homebot.mqtt_conventions]
thesis = tests.plain_layout:PlainLayout
[homebot.simulated]
thesis = tests.plain_layout:PlainDialect
"""
"""What the core's tests have in place of the thesis's layout, which simulated devices speak by default."""

Rest = Callable[..., str]


def project_without(folders: Collection[str], root: Path) -> Rest:
    """Copy the project to *root* without *folders*, such as ``features/scenes``.

    Returns:
        What runs a program of Python there, and returns what that prints.
    """
    left_out = ignore_patterns("*.pyc.*", ".*_cache", ".git", ".venv*")
    copytree(ROOT, root, copy_function=os.link, ignore=left_out)
    for parent in ("src/homebot", "tests"):
        for one in folders:
            rmtree(root / parent / one, ignore_errors=True)

    def run(*arguments: str, timeout: float = 300.0) -> str:
        environment = os.environ | {
            "PYTHONPATH": f"{root}{os.pathsep}{root / 'src'}",
            "HOMEBOT_DATA": str(root / "data"),
        }
        environment.pop("NIGHTLY", None)
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=root,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=timeout,
        )
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
        return done.stdout + done.stderr

    return run


def import_all(root: Path) -> None:
    """Import each module of the project at *root*.

    For a process that may change: a fork of the tests has other people's modules already, which take most of the time.
    """
    for name in [one for one in sys.modules if one.partition(".")[0] in {"homebot", "tests"}]:
        del sys.modules[name]
    sys.path[:0] = [str(root), str(root / "src")]
    homebot = importlib.import_module("homebot")
    assert [*homebot.__path__] == [str(root / "src/homebot")]
    for one in pkgutil.walk_packages(homebot.__path__, "homebot.", onerror=lambda _: None):
        if not one.name.endswith(("__main__", "plugin")):
            try:
                importlib.import_module(one.name)
            except ModuleNotFoundError as exc:
                if (exc.name or "").startswith("homebot"):
                    raise


ROUNDS = 8
"""Projects of which each folder is left out of three: at least as many sets of three as folders."""

SETS = [*combinations(range(ROUNDS), 3)]

ALONE = [(one,) for one in (*INTEGRATIONS, *FEATURES, "compat")]
ROUND_TABLE = {one: SETS[at * len(SETS) // len(ALONE)] for at, (one,) in enumerate(ALONE)}  # no project lacks most
TOGETHER = [tuple(one for one, rounds in ROUND_TABLE.items() if at in rounds) for at in range(ROUNDS)]


@pytest.fixture(params=ALONE if NIGHTLY else TOGETHER, ids=" ".join)
def folders(request: pytest.FixtureRequest) -> tuple[str, ...]:
    """Integrations and features, such as ``features/scenes``, or the spelling of rclpy."""
    assert isinstance(request.param, tuple)
    return request.param


@pytest.fixture
def rest(folders: Collection[str], tmp_path: Path) -> Rest:
    """A project without them."""
    return project_without(folders, tmp_path / "rest")


def test_each_folder_is_missed_by_each_other_one() -> None:
    folders = {one for (one,) in ALONE}
    missed = {(one, other) for left_out in TOGETHER for one in left_out for other in folders.difference(left_out)}
    assert missed == set(permutations(folders, 2))


def test_the_rest_imports_starts_and_keeps_its_import_rules(
    rest: Rest, folders: Collection[str], tmp_path: Path
) -> None:
    fork = multiprocessing.get_context("fork").Process(target=import_all, args=[tmp_path / "rest"])
    fork.start()
    fork.join()
    assert fork.exitcode == 0
    assert "is running" in rest("-m", "homebot", "run", "--plain", "--for", "0.1", "--door", "127.0.0.1:0")
    rules = rest("-c", "from importlinter.cli import lint_imports_command; lint_imports_command()")
    assert "0 broken" in rules
    unused = re.findall(r"No matches for ignored import (\S+)", rules)
    missed = tuple(f".{one.replace('/', '.')}." for one in folders)
    assert [name for name in unused if not any(one in name for one in missed)] == []


@nightly  # a project without a folder has tests that name it
def test_tests_name_what_they_need_by_its_folder() -> None:
    """Else they are always skipped."""
    named = {
        name
        for file in (ROOT / "tests").rglob("test_*.py")
        for mark in re.findall(r"mark\.rooms\(([^)]*)\)", file.read_text("utf-8"))
        for name in re.findall(r'"(\w+)"', mark)
    }
    assert named - {one.rpartition("/")[2] for (one,) in ALONE} == set()


@nightly
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("folders", TOGETHER, ids=" ".join)
def test_the_quick_tests_of_the_rest_pass(folders: Collection[str], tmp_path: Path) -> None:
    run = project_without(folders, tmp_path / "rest")
    if "integrations/thesis" in folders:
        points = tmp_path / "rest/src/homebot/integrations/plain/entry_points.txt"
        points.parent.mkdir()
        points.write_text(STAND_INS)
    quick = ("tests", "-m", "not slow and not system and not peers")
    assert " passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider", *quick, timeout=7000.0)


@nightly
def test_all_other_tests_are_collected(rest: Rest) -> None:
    found = rest("-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", "tests")
    collected = re.search(r"(\d+) tests collected|(\d+)/\d+ tests collected", found)
    assert collected is not None, found[-2000:]
    assert "error" not in found.splitlines()[-1]


@nightly
@pytest.mark.timeout(7200)
def test_the_tests_of_the_rest_pass_without_any_feature(tmp_path: Path) -> None:
    run = project_without(FEATURES, tmp_path / "rest")
    rest = ("tests", "-m", "not slow and not peers")
    assert " passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider", *rest, timeout=7000.0)


@nightly
@pytest.mark.timeout(7200)
def test_the_tests_of_the_core_pass_without_any_integration(tmp_path: Path) -> None:
    run = project_without(INTEGRATIONS, tmp_path / "rest")
    points = tmp_path / "rest/src/homebot/integrations/plain/entry_points.txt"
    points.parent.mkdir()
    points.write_text(STAND_INS)
    core = ("tests", "--ignore", "tests/integrations", "-m", "not peers")
    assert " passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider", *core, timeout=7000.0)
