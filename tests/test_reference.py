"""The API reference in ``docs/reference`` is whole: each public name is there, once."""

from __future__ import annotations

import re
from pathlib import Path

import homebot
import homebot.testing

PAGES = Path(__file__).parent.parent / "docs" / "reference"


def test_every_public_name_is_in_the_reference_once() -> None:
    entries = [
        entry for page in PAGES.glob("*.md") for entry in re.findall(r"^::: (\S+)", page.read_text(), re.MULTILINE)
    ]
    public = [f"homebot.{name}" for name in homebot.__all__ if name != "__version__"]
    public += [f"homebot.testing.{name}" for name in homebot.testing.__all__]
    assert sorted(entries) == sorted(public)
