"""The page that shows newcomers the way through the code names files that are there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs/how-a-message-travels.md"


@pytest.mark.rooms("homeassistant", "thesis")
def test_every_file_that_the_page_names_is_there_under_the_name_that_it_shows() -> None:
    """Each stands as a link whose text is its path inside the package."""
    links = re.findall(r"\[`([^`]+)`\]\(([^)]+)\)", PAGE.read_text())

    assert len(links) >= 14
    assert [path for _, path in links if not (PAGE.parent / path).is_file()] == []
    assert [name for name, path in links if (PAGE.parent / path).resolve() != ROOT / "src/homebot" / name] == []


def test_the_page_names_no_file_but_in_a_link() -> None:
    """Nothing would notice that such a one was moved."""
    plain = re.sub(r"\[`[^`]+`\]\([^)]+\)", "", PAGE.read_text())

    assert re.findall(r"\S+\.py\b", plain) == []


def test_the_readme_leads_to_the_page() -> None:
    assert "](docs/how-a-message-travels.md)" in (ROOT / "README.md").read_text()
