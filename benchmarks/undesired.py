"""Lamps that are turned off over people: one day of the family home and random days of random houses, in virtual time.

The days are those of ``tests/days``, which need the environment of the tests: Hypothesis makes them.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

from plan import Plan
from report import Report

__all__ = ["run"]

ROOT = Path(__file__).parent.parent
PYTHON = ROOT / ".venv" / "bin" / "python"
DAYS = 1000
QUICK_DAYS = 50


def run(plan: Plan) -> Report:
    title = "Lamps turned off over people"
    if not PYTHON.exists():
        return Report(title, (), (f"Not measured: no {PYTHON}; `make days` sets it up.",))
    days = QUICK_DAYS if plan.quick else DAYS
    command = [PYTHON, "-m", "tests.days.table", "--days", str(days)]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    lines = done.stdout.splitlines()
    last = max(number for number, line in enumerate(lines) if line.startswith("|--"))  # the tables before are parts
    table = [line for line in lines[last - 1 :] if line.startswith("|") and not line.startswith("|--")]
    rows = [tuple(cell.strip() for cell in line.strip("|").split("|")) for line in table]
    notes = [line for line in lines[last + len(table) :] if line]
    return Report(title, (), notes, rows)
