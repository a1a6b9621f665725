"""Lamps that burn for nobody: how well the app and the presence guard tell them from lamps of people who sit still.

The days are those of ``tests/days/left_on.py``, in the environment of the tests.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

from plan import Plan
from report import MissingPeerError, Report

__all__ = ["run"]

ROOT = Path(__file__).parent.parent
PYTHON = ROOT / ".venv" / "bin" / "python"
DAYS = 3


def run(plan: Plan) -> Report:
    title = "Lamps left on, by forgetful people and by people who sit still"
    if not PYTHON.exists():
        raise MissingPeerError(f"there is no {PYTHON}; `make .venv/.dev` sets it up")
    options = ["--days", "1", "--defaults"] if plan.quick else ["--days", str(DAYS)]
    command = [str(PYTHON), "-m", "tests.days.left_on", *options]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith("|") and not line.startswith("|--")]
    return Report(title, (), (), [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in lines])
