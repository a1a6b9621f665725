"""Packages of somebody else: installed as pip does it beside homebot's wheel, and found without an edit of homebot."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGES = Path(__file__).parent
HOMEBOT = PACKAGES.parent.parent
OFFLINE = ("--no-deps", "--no-index", "--no-build-isolation", "--disable-pip-version-check", "--quiet")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of homebot: what is not in it is not there for a package of somebody else."""
    folder = tmp_path_factory.mktemp("wheel")
    _run(sys.executable, "-m", "pip", "wheel", *OFFLINE, "--wheel-dir", str(folder), str(HOMEBOT))
    (built,) = folder.glob("homebot-*.whl")
    return built


@pytest.mark.parametrize("package", sorted(path.name for path in PACKAGES.glob("homebot-*")))
def test_the_tests_of_a_package_pass_where_it_is_installed(package: str, wheel: Path, tmp_path: Path) -> None:
    """It is built as a wheel and installed beside homebot's; its tests start a homebot that finds it by entry point."""
    installed = tmp_path / "installed"
    source = tmp_path / "source"
    shutil.copytree(PACKAGES / package, source, ignore=shutil.ignore_patterns("__pycache__"))
    _run(sys.executable, "-m", "pip", "install", *OFFLINE, "--target", str(installed), str(wheel), str(source))
    for module in source.glob("homebot_*.py"):
        module.unlink()
    found = _run(sys.executable, "-c", "import homebot; print(homebot.__file__)", cwd=source, path=installed)
    assert Path(found.strip()).is_relative_to(installed)
    _run(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:xdist", cwd=source, path=installed)


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
