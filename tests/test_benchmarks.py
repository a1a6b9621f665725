"""The benchmarks still run; how fast is no test's business."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROGRAM = Path(__file__).parent.parent / "benchmarks/run.py"


def test_a_benchmark_runs_and_says_which_peer_is_missing() -> None:
    """Also without Home Assistant, which takes minutes to install."""
    command = [sys.executable, str(PROGRAM), "--quick", "--home-assistant", "/no/such/python", "service_calls"]

    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=30)

    assert done.returncode == 0, done.stderr
    assert "Services: calls per second" in done.stdout
    assert "Home Assistant is not measured: no /no/such/python" in done.stdout
