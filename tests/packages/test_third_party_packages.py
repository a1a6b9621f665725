"""Packages of somebody else: installed as pip does it beside homebot's wheel, and found without an edit of homebot."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.rooms("thesis")

PACKAGES = Path(__file__).parent
HOMEBOT = PACKAGES.parent.parent
OFFLINE = ("--no-deps", "--no-index", "--no-build-isolation", "--disable-pip-version-check", "--quiet", "--no-compile")


def test_the_tests_of_packages_pass_where_they_are_installed(tmp_path: Path) -> None:
    """Each is installed beside homebot, from wheels; its tests start a homebot that finds it by its entry point."""
    installed, source = tmp_path / "installed", tmp_path / "source"
    shutil.copytree(PACKAGES, source, ignore=shutil.ignore_patterns("__pycache__", "conftest.py"))
    packages = sorted(str(path) for path in source.glob("homebot-*"))
    _run(sys.executable, "-m", "pip", "install", *OFFLINE, "--target", str(installed), str(HOMEBOT), *packages)
    for module in source.glob("*/homebot_*"):
        module.rename(tmp_path / module.name)  # else its source would be found, and not the installed one
    found = _run(sys.executable, "-c", "import homebot; print(homebot.__file__)", cwd=source, path=installed)
    assert Path(found.strip()).is_relative_to(installed)
    flags = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "-p", "no:asyncio")
    assert " passed" in _run(sys.executable, "-m", "pytest", *flags, *packages, cwd=source, path=installed)


def _run(*command: str, cwd: Path = PACKAGES, path: Path = PACKAGES) -> str:
    own = {name: value for name, value in os.environ.items() if not name.startswith(("COV_", "PYTEST_"))}
    done = subprocess.run(
        command,
        cwd=cwd,
        env=own | {"PYTHONPATH": str(path)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
