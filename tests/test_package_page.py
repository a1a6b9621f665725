"""The page of homebot on a package index: links lead somewhere, or there are none."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, cast

import pytest

ROOT = Path(__file__).parent.parent
FILES = ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE", "src/homebot/version.py")

pytestmark = pytest.mark.slow


def built(folder: Path, repository: str) -> dict[str, Any]:
    """The metadata of a package with this repository, as the build makes them."""
    for name in FILES:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    settings = (folder / "pyproject.toml").read_text().replace('repository = ""', f'repository = "{repository}"')
    (folder / "pyproject.toml").write_text(settings)
    command = [sys.executable, "-m", "hatchling", "metadata"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return cast("dict[str, Any]", json.loads(done.stdout))


def links(metadata: dict[str, Any]) -> list[str]:
    return re.findall(r"\]\(([^)]+)\)", metadata["readme"]["text"])


def test_the_page_has_no_link_that_leads_nowhere(tmp_path: Path) -> None:
    made = built(tmp_path, "")
    assert [one for one in links(made) if not one.startswith(("https://", "#"))] == []
    assert "Each command returns its outcome." in made["readme"]["text"]
    assert "The page:" not in made["readme"]["text"], "a picture without its file"
    assert not made.get("urls")


def test_links_and_urls_lead_to_the_repository_where_it_is_known(tmp_path: Path) -> None:
    made = built(tmp_path, "https://git.example/homebot")
    assert "https://git.example/homebot/blob/HEAD/docs/devices.md#outcomes" in links(made)
    assert [one for one in links(made) if not one.startswith(("https://", "#"))] == []
    assert "https://git.example/homebot/raw/HEAD/docs/images/home-wall-light.webp" in links(made)
    assert made["urls"]["Changelog"] == "https://git.example/homebot/blob/HEAD/CHANGELOG.md"
