"""Other people's Python packages, each installed in an environment of its own below ``.venv-peers``."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / ".venv-peers"
INSTALLED_WITHIN = 300.0


def python_with(package: str, *versions: str, pinned: Path | None = None) -> str:
    """Return a Python that has *package*; the test is skipped where it cannot be installed.

    For fixtures of the session, which come before a test has entered a network of its own.

    Args:
        package: The package, as pip names it.
        versions: The versions of Python that it runs on, the best first: ``3.12``.
        pinned: A file of requirements that holds the package and all that a test needs of its dependencies.
    """
    home = ROOT / package
    python = home / "bin" / "python"
    if not (home / "installed").exists():
        base = _find(versions)
        if base is None:
            pytest.skip(f"{package} needs Python {' or '.join(versions)}, which is not installed")
        wanted = ["--no-deps", "-r", str(pinned)] if pinned else [package]
        for command in (
            [base, "-m", "venv", "--clear", str(home)],
            [str(python), "-m", "pip", "install", "-q", "--no-compile", *wanted],  # most modules are never imported
        ):
            try:
                done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=INSTALLED_WITHIN)
            except subprocess.TimeoutExpired:
                pytest.skip(f"{package} was not installed within {INSTALLED_WITHIN:g} s")
            if done.returncode:
                pytest.skip(f"{package} cannot be installed: {done.stderr.strip()[-300:]}")
        (home / "installed").touch()
    return str(python)


def _find(versions: tuple[str, ...]) -> str | None:
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for version in versions:
        found = shutil.which(f"python{version}")
        if found and subprocess.run([found, "-c", ""], check=False, capture_output=True).returncode == 0:
            return found
        for place in sorted(pyenv.glob(f"{version}.*/bin/python")):
            return str(place)
    return None
