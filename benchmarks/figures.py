"""What benchmarks found, in ``figures.json``: the figures of the documents are compared with it."""

import json
from pathlib import Path

from report import Report

__all__ = ["keep_figures"]

_FILE = Path(__file__).parent / "figures.json"


def keep_figures(name: str, report: Report) -> None:
    """Replace the figures of the benchmark *name* by the rows and notes of *report*."""
    rows = [*(one.row() for one in report.comparisons), *report.table, *((note,) for note in report.notes)]
    known = json.loads(_FILE.read_text("utf-8")) | {name: [" | ".join(row) for row in rows]}
    _FILE.write_text(json.dumps(known, indent=1, ensure_ascii=False, sort_keys=True) + "\n", "utf-8")
