"""What docs/house.md shows is so."""

import re
import tomllib
from pathlib import Path

import pytest

from homebot.house.description import parse_world
from homebot.house.kinds import FAULTS, KINDS

pytestmark = pytest.mark.slow

GUIDE = (Path(__file__).parents[2] / "docs" / "house.md").read_text(encoding="utf-8")


def test_the_file_in_the_guide_is_a_house() -> None:
    """A reader can begin with it."""
    found = re.search(r"```toml\n(.*?)```", GUIDE, re.DOTALL)
    assert found is not None
    assert list(parse_world(tomllib.loads(found[1]), "guide").devices) == ["hall_lamp"]


def test_the_program_in_the_guide_runs() -> None:
    """And prints a day."""
    found = re.search(r"```python\n(.*?)```", GUIDE, re.DOTALL)
    assert found is not None
    root = Path(__file__).parents[2]
    printed: list[str] = []
    program = found[1].replace('Path("examples', f'Path({str(root)!r}, "examples')
    exec(program, {"print": printed.append})  # noqa: S102  # the guide's own program
    assert "living_lamp told on" in printed[0]


def test_the_guide_lists_every_kind_and_fault_with_its_settings() -> None:
    """As they can be told."""
    for name, model in (KINDS | FAULTS).items():
        row = next(line for line in GUIDE.splitlines() if line.startswith(f"| `{name}` |"))
        settings = row.rstrip("| ").rpartition("|")[2]
        assert "as `window`" in settings or all(f"`{field}`" in settings for field in model.model_fields)
