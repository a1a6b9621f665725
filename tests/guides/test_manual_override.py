"""The guide to manual override shows the app of its example, whose test is run with those of the others."""

from pathlib import Path

from tests.guide import blocks_in, guide

EXAMPLE = Path(__file__).parents[2] / "examples" / "14_manual_override" / "manual_override.py"


def test_the_guide_shows_the_example_in_fifteen_lines() -> None:
    assert blocks_in(guide("manual-override"), "python") == [EXAMPLE.read_text("utf-8")]
    lines = [line for line in EXAMPLE.read_text("utf-8").splitlines() if line.strip() and "import" not in line]
    assert len(lines) <= 15
