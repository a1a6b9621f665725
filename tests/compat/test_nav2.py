"""Programs of Nav2: nav2_simple_commander's interfaces of Jazzy, without ROS and without a folder of texts."""

import subprocess
import sys
from pathlib import Path

from tests.patience import PATIENCE

PROGRAM = Path(__file__).parent / "programs" / "navigator.py"


def test_a_program_imports_what_nav2_simple_commander_does_and_makes_each_message() -> None:
    command = [sys.executable, "-m", "homebot.compat", str(PROGRAM)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=PATIENCE)
    assert done.stdout.splitlines() == ["54 messages", "0.0 0", "601 4 208"]
