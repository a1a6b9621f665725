"""Every example runs as it is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"


@pytest.mark.parametrize(
    ("program", "last_line"),
    [
        ("01_talker_and_listener.py", "heard three"),
        ("03_services.py", "ServiceUnavailableError: service /switch has no server"),
        ("04_live_devices.py", "that is all"),
    ],
)
def test_an_example_runs_and_ends_as_it_should(program: str, last_line: str) -> None:
    """Its last word shows that it came to its end."""
    done = subprocess.run([sys.executable, EXAMPLES / program], capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 0, done.stderr
    assert any(line.startswith(last_line) for line in done.stdout.splitlines())


def test_every_example_is_in_the_list() -> None:
    """A reader finds it in the table."""
    table = (EXAMPLES / "README.md").read_text()
    for entry in EXAMPLES.iterdir():
        if entry.name[0].isdigit():
            assert f"`{entry.name}" in table
