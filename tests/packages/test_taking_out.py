"""Each integration can be taken out: without its folders and its lines in pyproject.toml the rest is whole."""

import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path
from shutil import copytree, ignore_patterns

import pytest
from tests.sizes import NIGHTLY

ROOT = Path(__file__).parents[2]
INTEGRATIONS = sorted(one.parent.name for one in (ROOT / "src/homebot/integrations").glob("*/__init__.py"))
IMPORT_ALL = """
import importlib, importlib.util, pkgutil, homebot
for one in pkgutil.walk_packages(homebot.__path__, "homebot.", onerror=lambda name: None):
    if not one.name.endswith(("__main__", "plugin")):
        try:
            importlib.import_module(one.name)
        except ModuleNotFoundError as exc:
            assert not (exc.name or "").startswith("homebot"), (one.name, exc)
"""
Rest = Callable[..., str]


@pytest.fixture(params=INTEGRATIONS)
def rest(request: pytest.FixtureRequest, tmp_path: Path) -> Rest:
    """A project without one integration, in which a program of Python runs; it returns what that prints."""
    name = request.param
    for folder in ("src", "tests"):
        left_out = ignore_patterns("__pycache__", *(["web"] if folder == "src" else []))
        copytree(ROOT / folder, tmp_path / folder, copy_function=os.link, ignore=left_out)
        taken = tmp_path / folder / ("homebot/integrations" if folder == "src" else "integrations") / name
        if taken.exists():
            taken.rename(tmp_path / f"taken-{folder}")
    for one in ("docs", "examples", "benchmarks", "README.md", "CHANGELOG.md", "Makefile", "Containerfile"):
        (tmp_path / one).symlink_to(ROOT / one)
    (tmp_path / "src/homebot/web").symlink_to(ROOT / "src/homebot/web")
    lines = (ROOT / "pyproject.toml").read_text().splitlines(keepends=True)
    kept = "".join(one for one in lines if f"homebot.integrations.{name}." not in one)
    (tmp_path / "pyproject.toml").write_text(kept)
    (tmp_path / "house.toml").write_text(
        '[house]\ndialect = "homie"\n[rooms.hall]\n[devices.lamp]\nkind = "lamp"\nroom = "hall"\ndialect = "homie"\n'
    )
    info = tmp_path / "homebot-0.1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: homebot\nVersion: 0.1.0\n")
    groups: dict[str, dict[str, str]] = tomllib.loads(kept)["project"]["entry-points"]
    with (info / "entry_points.txt").open("w") as file:
        for group, points in groups.items():
            file.write(f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in points.items()))

    def run(*arguments: str) -> str:
        environment = os.environ | {
            "PYTHONPATH": f"{tmp_path}{os.pathsep}{tmp_path / 'src'}",
            "HOMEBOT_DATA": str(tmp_path / "data"),
        }
        done = subprocess.run(
            [sys.executable, *arguments],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=300,
        )
        assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
        return done.stdout + done.stderr

    return run


def test_the_rest_imports_starts_and_keeps_its_import_rules(rest: Rest, request: pytest.FixtureRequest) -> None:
    rest("-c", IMPORT_ALL)
    house = "house.toml" if "[thesis]" in request.node.name else "thesis"
    assert "is running" in rest(
        "-m", "homebot", "run", "--house", house, "--plain", "--for", "0.1", "--door", "127.0.0.1:0"
    )
    assert "0 broken" in rest("-c", "from importlinter.cli import lint_imports_command; lint_imports_command()")


@pytest.mark.skipif(not NIGHTLY, reason="a long case of make nightly")
def test_all_other_tests_are_collected(rest: Rest) -> None:
    found = rest("-m", "pytest", "--collect-only", "-q", "-p", "no:cacheprovider", "tests")
    collected = re.search(r"(\d+) tests collected|(\d+)/\d+ tests collected", found)
    assert collected is not None, found[-2000:]
    assert "error" not in found.splitlines()[-1]
