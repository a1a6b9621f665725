"""A nightly run fails for a skip whose reason is not listed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.skips import hidden

ROOT = Path(__file__).parent.parent

TESTS = """
import pytest

@pytest.mark.skipif(True, reason="this machine has no IPv6")
def test_without_ipv6(): ...

def test_of_a_peer():
    {}
"""


def test_a_reason_is_allowed_by_what_it_says() -> None:
    reasons = ["Skipped: only root can give files away", "Skipped: could not import 'zenoh'", "Skipped: reads /proc"]
    assert hidden(reasons * 2) == ["Skipped: could not import 'zenoh'"]


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["0", "2"])
@pytest.mark.parametrize(("body", "code"), [("pytest.importorskip('no_peer')", 1), ("...", 0)])
def test_a_nightly_run_with_a_skip_that_hides_fails(body: str, code: int, workers: str, tmp_path: Path) -> None:
    (tmp_path / "test_peer.py").write_text(TESTS.format(body))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "tests.skips", "-p", "no:cacheprovider", "-n", workers]
    done = subprocess.run(
        [*command, "--rootdir", str(tmp_path), str(tmp_path / "test_peer.py")],
        cwd=ROOT,
        env={**os.environ, "NIGHTLY": "1", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == code, done.stdout
    assert ("a skip that hides" in done.stdout) is bool(code)
    assert "could not import 'no_peer'" in done.stdout or not code
