"""Each integration and feature can be taken out: without its folders, and its lines in pyproject.toml, all is whole."""

import importlib
import multiprocessing
import os
import pkgutil
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable, Collection
from pathlib import Path
from shutil import copytree, ignore_patterns, rmtree

import pytest
from tests.sizes import nightly

ROOT = Path(__file__).parents[2]
INTEGRATIONS, FEATURES = (
    sorted(f"{kind}/{one.parent.name}" for one in (ROOT / "src/homebot" / kind).glob("*/__init__.py"))
    for kind in ("integrations", "features")
)
STAND_INS = {
    "homebot.integrations.thesis.formats:Thesis": "tests.plain_layout:PlainLayout",
    "homebot.integrations.thesis.simulated:ThesisDialect": "tests.plain_layout:PlainDialect",
}
"""What the core's tests have in place of the thesis's layout, which simulated devices speak by default."""

Rest = Callable[..., str]


def project_without(folders: Collection[str], root: Path, points: str) -> Rest:
    """Copy the project to *root* with the entry points *points*, without *folders*, such as ``features/scenes``.

    Returns:
        What runs a program of Python there, and returns what that prints.
    """
    left_out = ignore_patterns("*.pyc.*", ".*_cache", ".git", ".venv*")
    copytree(ROOT, root, copy_function=os.link, ignore=left_out)
    for parent in ("src/homebot", "tests"):
        for one in folders:
            rmtree(root / parent / one, ignore_errors=True)
    (root / "pyproject.toml").unlink()  # a link to ours
    lines = points.splitlines(keepends=True)
    gone = [f"homebot.{name.replace('/', '.')}." for name in folders]
    kept = "".join(one for one in lines if not any(name in one for name in gone))
    (root / "pyproject.toml").write_text(kept)
    info = root / "homebot-0.1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: homebot\nVersion: 0.1.0\n")
    groups: dict[str, dict[str, str]] = tomllib.loads(kept)["project"]["entry-points"]
    with (info / "entry_points.txt").open("w") as file:
        for group, entries in groups.items():
            file.write(f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in entries.items()))

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


@pytest.fixture(params=[*INTEGRATIONS, *FEATURES])
def rest(request: pytest.FixtureRequest, tmp_path: Path) -> Rest:
    """A project without one integration or feature."""
    return project_without([request.param], tmp_path / "rest", (ROOT / "pyproject.toml").read_text())


def test_the_rest_imports_starts_and_keeps_its_import_rules(
    rest: Rest, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    fork = multiprocessing.get_context("fork").Process(target=import_all, args=[tmp_path / "rest"])
    fork.start()
    fork.join()
    assert fork.exitcode == 0
    house = "tests/packages/homie.toml" if "thesis]" in request.node.name else "thesis"
    assert "is running" in rest(
        "-m", "homebot", "run", "--house", house, "--plain", "--for", "0.1", "--door", "127.0.0.1:0"
    )
    assert "0 broken" in rest("-c", "from importlinter.cli import lint_imports_command; lint_imports_command()")


@nightly
def test_all_other_tests_are_collected(rest: Rest) -> None:
    found = rest("-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", "tests")
    collected = re.search(r"(\d+) tests collected|(\d+)/\d+ tests collected", found)
    assert collected is not None, found[-2000:]
    assert "error" not in found.splitlines()[-1]


@nightly
@pytest.mark.timeout(7200)
def test_the_tests_of_the_rest_pass_without_any_feature(tmp_path: Path) -> None:
    run = project_without(FEATURES, tmp_path / "rest", (ROOT / "pyproject.toml").read_text())
    rest = ("tests", "-m", "not slow and not peers")
    assert " passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider", *rest, timeout=7000.0)


@nightly
@pytest.mark.timeout(7200)
def test_the_tests_of_the_core_pass_without_any_integration(tmp_path: Path) -> None:
    points = (ROOT / "pyproject.toml").read_text()
    for kind, other in STAND_INS.items():
        assert points.count(kind) == 1
        points = points.replace(kind, other)
    run = project_without(INTEGRATIONS, tmp_path / "rest", points)
    core = ("tests", "--ignore", "tests/integrations", "-m", "not peers")
    assert " passed" in run("-m", "pytest", "-q", "-p", "no:cacheprovider", *core, timeout=7000.0)
