"""What docs/house.md shows is so."""

import tomllib
from pathlib import Path

import pytest
from tests.guide import blocks_in, guide

from homebot.house.description import parse_world
from homebot.house.kinds import FAULTS, KINDS

pytestmark = pytest.mark.slow

GUIDE = guide("house")


def test_the_file_in_the_guide_is_a_house() -> None:
    """A reader can begin with it."""
    shown = blocks_in(GUIDE, "toml")[0]
    assert list(parse_world(tomllib.loads(shown), "guide").devices) == ["hall_lamp"]


def test_the_program_in_the_guide_runs() -> None:
    """And prints a day."""
    shown = blocks_in(GUIDE, "python")[0]
    root = Path(__file__).parents[2]
    printed: list[str] = []
    program = shown.replace('Path("examples', f'Path({str(root)!r}, "examples')
    exec(program, {"print": printed.append})  # noqa: S102  # the guide's own program
    assert "living_lamp told on" in printed[0]


def test_the_guide_lists_every_kind_and_fault_with_its_settings() -> None:
    """As they can be told."""
    for name, model in (KINDS | FAULTS).items():
        row = next(line for line in GUIDE.splitlines() if line.startswith(f"| `{name}` |"))
        settings = row.rstrip("| ").rpartition("|")[2]
        assert "as `window`" in settings or all(f"`{field}`" in settings for field in model.model_fields)
