"""Every decision is written in one form, so that a reader finds what holds."""

from __future__ import annotations

import re
from pathlib import Path

FILES = sorted((Path(__file__).parent.parent / "docs" / "decisions").glob("*.md"))


def test_decisions_are_numbered_without_gaps() -> None:
    assert [int(file.name[:4]) for file in FILES] == list(range(1, len(FILES) + 1))
    assert len(FILES) >= 19


def test_a_decision_has_date_status_context_decision_and_consequences() -> None:
    for file in FILES:
        text = file.read_text(encoding="utf-8")
        assert text.startswith(f"# {int(file.name[:4])}. ")
        status = r"^Date: \d{4}-\d\d-\d\d\. Status: (accepted|proposed|replaced by \d+)"
        assert re.search(status, text, re.MULTILINE), file
        assert re.findall(r"^## (.+)$", text, re.MULTILINE) == ["Context", "Decision", "Consequences"], file
