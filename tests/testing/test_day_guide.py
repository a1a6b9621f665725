"""What docs/days.md shows is so."""

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.guide import blocks_in, guide

from homebot.testing import Day
from homebot.testing.day_event import HAPPENINGS

ROOT = Path(__file__).parents[2]
GUIDE = guide("days")
PROGRAMS = blocks_in(GUIDE, "python")
FILE = blocks_in(GUIDE, "toml")[0]


def _tests_in(names: dict[str, object]) -> list[Callable[[], object]]:
    return [value for name, value in names.items() if name.startswith("test_") and callable(value)]


@pytest.mark.parametrize("program", PROGRAMS)
def test_what_the_guide_shows_runs(program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    day = Day.parse(FILE)
    day.save("day.toml")
    day.save("failing_day.toml")
    names: dict[str, object] = {}
    exec(compile(program, str(tmp_path / "guide.py"), "exec", dont_inherit=True), names)  # noqa: S102 - our own guide
    assert _tests_in(names)
    for test in _tests_in(names):
        test()


def test_the_file_in_the_guide_is_a_day() -> None:
    day = Day.parse(FILE)
    assert (day.start, day.length) == (6.5 * 3600, 7200.0)
    assert [happening.what for happening in day.happenings] == ["restart", "press"]


def test_the_guide_lists_all_that_can_happen() -> None:
    assert all(f"| `{what}` |" in GUIDE for what in HAPPENINGS)
