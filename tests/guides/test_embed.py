"""The programs of the guide for embedding run as it says."""

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.guide import guide

pytestmark = pytest.mark.slow

GUIDE = guide("embed")
FILES = dict(re.findall(r"<!-- file: (.*?) -->\n```python\n(.*?)```", GUIDE, re.DOTALL))


@contextmanager
def running(folder: Path, name: str) -> Iterator[subprocess.Popen[str]]:
    (folder / name).write_text(FILES[name])
    with subprocess.Popen(
        [sys.executable, name], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        try:
            yield program
        finally:
            program.kill()


def test_every_program_of_the_guide_is_run_here() -> None:
    assert FILES.keys() == {"timer.py", "service.py"}
    assert GUIDE.count("```python") == 2


@pytest.mark.rooms("thesis")
def test_an_app_given_directly_and_the_program_itself_command_devices(tmp_path: Path) -> None:
    """The program turns a lamp on, the app both off, and nothing is left behind."""
    with running(tmp_path, "timer.py") as program:
        shown, mistakes = program.communicate(timeout=120)
    assert (program.returncode, mistakes) == (0, "")
    lines = shown.splitlines()
    assert "appeared philips165 off" in lines
    assert any(line.startswith("Confirmed(") for line in lines)
    assert {"changed philips165 off", "changed roomlights405 off"} <= set(lines)


def test_the_program_reloads_and_stops_by_its_own_signals_and_has_the_log(tmp_path: Path) -> None:
    """Its devices are kept in its own folder."""
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\n[door]\nport = 0\n")
    with running(tmp_path, "service.py") as program:
        assert program.stderr is not None
        assert program.stdout is not None
        assert any("INFO:" in line and "no app is running" in line for line in program.stderr)
        program.send_signal(signal.SIGHUP)
        assert any("places were reloaded" in line for line in program.stderr)
        program.send_signal(signal.SIGTERM)
        shown, rest = program.communicate(timeout=120)
    assert (program.returncode, "Traceback" in rest) == (0, False)
    assert "success=True" in shown
    assert (tmp_path / "data" / "index.sqlite").exists()
