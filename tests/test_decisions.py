"""Every decision is written in one form, so that a reader finds what holds."""

import re
from pathlib import Path

FILES = sorted((Path(__file__).parent.parent / "docs" / "decisions").glob("*.md"))


def test_decisions_are_numbered_without_gaps() -> None:
    assert [int(file.name[:4]) for file in FILES] == list(range(1, len(FILES) + 1))
    assert len(FILES) >= 19


def test_a_decision_has_date_status_context_decision_and_consequences() -> None:
    """One that was replaced has the number of the one that holds, and nothing else."""
    replaced = set()
    for file in FILES:
        text = file.read_text(encoding="utf-8")
        assert text.startswith(f"# {int(file.name[:4])}. ")
        status = re.search(
            r"^Date: \d{4}-\d\d-\d\d\. Status: (accepted|proposed|replaced by (\d+))", text, re.MULTILINE
        )
        assert status, file
        parts = [] if status[2] else ["Context", "Decision", "Consequences"]
        assert re.findall(r"^## (.+)$", text, re.MULTILINE) == parts, file
        replaced |= {(int(file.name[:4]), int(status[2]))} if status[2] else set()
    assert {holds for _, holds in replaced}.isdisjoint({old for old, _ in replaced})
    assert all(1 <= holds <= len(FILES) for _, holds in replaced)
