"""The documentation keeps up with the code: every public name is in the reference, and no link is broken.

``make docs`` checks headings and cross references as well.
"""

import re
from pathlib import Path

import pytest

import homebot
import homebot.testing
from homebot.devices import outcomes

ROOT = Path(__file__).parent.parent
PAGES = ROOT / "docs" / "reference"
GUIDES = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")]


def test_every_public_name_is_in_the_reference_once() -> None:
    entries = [
        entry for page in PAGES.glob("*.md") for entry in re.findall(r"^::: (\S+)", page.read_text(), re.MULTILINE)
    ]
    assert entries.count(outcomes.__name__) == 1
    entries.remove(outcomes.__name__)  # all of its classes, as the checker of links finds them
    public = [f"homebot.{name}" for name in homebot.__all__ if name not in {"__version__", *vars(outcomes)}]
    public += [f"homebot.testing.{name}" for name in homebot.testing.__all__]
    assert sorted(entries) == sorted(public)


@pytest.mark.rooms("goals", "history", "homeassistant", "scenes", "thesis", "things", "zigbee2mqtt")
def test_every_link_to_a_file_leads_to_one() -> None:
    """Files move; a guide that names one moves with it."""
    links = [
        (guide, link) for guide in GUIDES for link in re.findall(r"\]\((?![a-z]+:|#)([^)#\s]+)", guide.read_text())
    ]
    assert [(str(guide), link) for guide, link in links if not (guide.parent / link).exists()] == []
