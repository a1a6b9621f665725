"""The guide docs/testing.md: what it shows works as it stands there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

GUIDE = Path(__file__).parents[2] / "docs" / "testing.md"

PROGRAMS = [
    block
    for block in re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    if "with asyncio.Runner(" in block
]


def test_the_guide_shows_programs() -> None:
    assert PROGRAMS


@pytest.mark.parametrize("program", PROGRAMS)
def test_what_it_shows_runs(program: str) -> None:
    names: dict[str, object] = {}
    exec(program, names)  # noqa: S102 - our own guide
    tests = [value for name, value in names.items() if name.startswith("test_")]
    assert tests
    for test in tests:
        assert callable(test)
        test()
