"""Other people's Node packages, each installed in a folder of its own below ``.venv-peers``."""

import shutil
import subprocess
from pathlib import Path

import pytest
from tests.peers.network import missing_programs
from tests.peers.other_python import INSTALLED_WITHIN, ROOT


def node_folder(source: Path) -> Path:
    """Return a folder with the programs of *source* and the packages that its ``package.json`` names.

    The test is skipped where they cannot be installed. For fixtures of the session, which come before a test has
    entered a network of its own.
    """
    missing = missing_programs("node", "npm")
    if missing:
        pytest.skip(f"not installed: {missing} (apt-get install nodejs npm)")
    home = ROOT / f"node-{source.name}"
    home.mkdir(parents=True, exist_ok=True)
    wanted, installed = (source / "package.json").read_text(), home / "installed"
    if not installed.exists() or installed.read_text() != wanted:
        (home / "package.json").write_text(wanted)
        command = ("npm", "install", "--no-audit", "--no-fund", "--no-package-lock", "--loglevel=error")
        try:
            done = subprocess.run(
                command, cwd=home, check=False, capture_output=True, text=True, timeout=INSTALLED_WITHIN
            )
        except subprocess.TimeoutExpired:
            pytest.skip(f"the packages of {source.name} were not installed within {INSTALLED_WITHIN:g} s")
        if done.returncode:
            pytest.skip(f"npm cannot install {source.name}: {done.stderr.strip()[-300:]}")
        installed.write_text(wanted)
    for program in source.glob("*.mjs"):
        shutil.copy(program, home)
    return home
