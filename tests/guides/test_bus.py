"""What docs/bus.md shows works, and README and docs/thesis.md lead a reader of the thesis to it."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.guide import commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("bus")
FILES: dict[str, str] = dict(re.findall(r"<!-- file: (.*?) -->\n```python\n(.*?)```", GUIDE, re.DOTALL))
README = (Path(__file__).parents[2] / "README.md").read_text("utf-8")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    folder = tmp_path_factory.mktemp("bus")
    with homebot_in(folder, "--ephemeral", until=("is running", "the robot is in")) as homebot:
        yield homebot


@pytest.mark.parametrize("command", commands_in(GUIDE))
def test_a_command_of_the_guide_runs(home: Homebot, command: str) -> None:
    done = home.run(command)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout


def test_the_programs_of_the_guide_run(tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    said = subprocess.run([sys.executable, "talk.py"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert said.stdout == "hello\n"
    subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"], cwd=tmp_path, check=True)


def test_the_readme_says_what_homebot_is_for_before_its_first_heading() -> None:
    first = README.partition("## Run it")[0]
    assert [word for word in ("node", "topic", "service", "gateway", "discovery") if word not in first] == []
    assert "](docs/thesis.md)" in first
    assert len(README.splitlines()) <= 130


def test_the_page_of_the_thesis_is_short() -> None:
    assert len(guide("thesis").splitlines()) <= 150
