"""Hostile recordings that `homebot replay` refuses: none runs code, and an endless one is refused at once.

Asserted is the processor time beyond that of refusing a file that is not a recording.
"""

import gzip
import json
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.cli import main

LINE = b'{"at":1,"kind":"lost","message":{"count":0}}\n'


def header(kind: str = "homebot.apps.light_service:LightService") -> bytes:
    """The first line of a recording of an app."""
    message = {
        "format": 2,
        "version": "1",
        "home": "home",
        "started_at": {"sec": 1_767_225_600, "nanosec": 0},
        "apps": [{"name": "mine", "kind": kind}],
    }
    return json.dumps({"at": 0, "kind": "recording", "message": message}).encode() + b"\n"


def replay(folder: Path, file: str) -> tuple[int, str, float]:
    """Replay *file* in *folder*; return the exit code, the errors and the seconds of the processor."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "homebot", "replay", file]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    return done.returncode, done.stderr, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def valid_lines(file: gzip.GzipFile) -> None:
    """Write lines that a recording may have."""
    file.write(header())
    for _ in range(size(40, 400)):
        file.write(LINE * (1_000_000 // len(LINE)))


def one_line(file: gzip.GzipFile) -> None:
    """Write a long line without an end."""
    file.write(b'{"at":0,"kind":"recording","message":"')
    for _ in range(size(100, 1000)):
        file.write(b"0" * 1_000_000)


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> float:
    """The processor time of a replay that is refused for its first line."""
    folder = tmp_path_factory.mktemp("usual")
    (folder / "none.jsonl").write_text("{}\n")
    code, _, seconds = replay(folder, "none.jsonl")
    assert code == 2
    return seconds


@pytest.mark.parametrize("content", [valid_lines, one_line])
def test_a_file_that_unpacks_without_end_is_refused(
    tmp_path: Path, usual: float, content: Callable[[gzip.GzipFile], None]
) -> None:
    with gzip.open(tmp_path / "day.jsonl.gz", "wb") as file:
        content(file)
    code, error, seconds = replay(tmp_path, "day.jsonl.gz")
    problem = "it unpacks to more than 200 times its size"
    assert (code, error) == (2, f"homebot: day.jsonl.gz is not a recording: {problem}\n")
    assert seconds - usual < 1


def test_an_event_in_a_hundred_years_is_refused(tmp_path: Path, usual: float) -> None:
    """An app that does something each minute would do so fifty million times."""
    (tmp_path / "day.jsonl").write_bytes(header() + LINE.replace(b'"at":1', b'"at":3e9'))
    code, error, seconds = replay(tmp_path, "day.jsonl")
    assert (code, "line 2: field 'at': must be a number of seconds within 366 days" in error) == (2, True)
    assert seconds - usual < 1


@pytest.mark.parametrize("kind", ["./evil.py:Evil", "evil.py", "evil:Evil", "subprocess:Popen"])
def test_no_code_runs_because_a_recording_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    """Also not what lies beside it, in the working directory."""
    (tmp_path / "evil.py").write_text("from pathlib import Path\n\nPath('was_run').touch()\n\n\nclass Evil: pass\n")
    (tmp_path / "day.jsonl").write_bytes(header(kind))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert main(["replay", "day.jsonl"]) == 2
    assert "runs no code that only a recording names" in capsys.readouterr().err
    assert not (tmp_path / "was_run").exists()
