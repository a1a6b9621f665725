"""The file of a recording: for its owner alone, never overwritten unasked, bounded, and honest about what it lacks."""

import stat
from pathlib import Path

import pytest

from homebot.errors import UsageError
from homebot.features.recording.recorder import LineBuffer
from homebot.features.recording.recording_file import RecordingFile
from homebot.messages import Time
from homebot.recording.lines import LostLines, RecordingHeader, RecordingLine, line_text
from homebot.recording.recording import load_recording

HEADER = line_text(
    RecordingLine(0, RecordingHeader(format=2, version="1", home="h", started_at=Time(sec=1, nanosec=0)))
)
LINE = line_text(RecordingLine(1, LostLines(count=0)))


@pytest.mark.parametrize("name", ["day.jsonl", "day.jsonl.gz"])
def test_only_its_owner_can_read_it(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    with RecordingFile(path) as file:
        file.write([HEADER, LINE])
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert load_recording(path).header.home == "h"
    assert (path.read_bytes()[:2] == b"\x1f\x8b") is name.endswith(".gz")


def test_a_file_that_is_there_is_replaced_only_by_force(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    path.write_text("precious")
    path.chmod(0o644)
    with pytest.raises(UsageError, match="exists already; delete it, or choose another name"):
        RecordingFile(path)
    assert path.read_text() == "precious"
    with RecordingFile(path, force=True) as file:
        file.write([HEADER])
    assert path.read_text() == f"{HEADER}\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_force_replaces_a_link_and_not_what_it_points_at(tmp_path: Path) -> None:
    other, path = tmp_path / "other", tmp_path / "day.jsonl"
    other.write_text("precious")
    path.symlink_to(other)
    with RecordingFile(path, force=True) as file:
        file.write([HEADER])
    assert other.read_text() == "precious"
    assert not path.is_symlink()


def test_a_run_that_did_not_begin_leaves_no_file(tmp_path: Path) -> None:
    """After a mistake in the configuration was mended, the next run refused the empty file of the one before."""
    RecordingFile(tmp_path / "day.jsonl").close()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"day.jsonl cannot be written: No such file"):
        RecordingFile(tmp_path / "none" / "day.jsonl")


def test_what_does_not_fit_is_counted_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "day.jsonl"
    with RecordingFile(path, megabytes=0.002) as file:
        file.write([HEADER])
        file.write([LINE] * 100)
        assert file.is_full
        file.write([LINE] * 5)
        assert file.dropped + file.lines == 106
    found = load_recording(path)
    assert (found.lost, found.end) == (file.dropped, "the file is full")
    assert path.stat().st_size <= 2000


def test_lines_that_come_too_fast_are_dropped_and_counted_where_they_are_missing() -> None:
    buffer = LineBuffer()
    line = RecordingLine(1, LostLines(count=0))
    assert sum(buffer.add(line) for _ in range(50_010)) == 50_000
    assert buffer.lost == 10
    assert len(buffer.pop()) == 50_000
    buffer.add(line)
    assert [one for one in buffer.pop() if '"count":10' in one] == [line_text(RecordingLine(1, LostLines(count=10)))]
    assert buffer.is_empty


def test_lines_are_taken_in_portions() -> None:
    buffer = LineBuffer()
    for number in range(5):
        buffer.add(RecordingLine(number, LostLines(count=number)))
    assert len(buffer.pop(most=2)) == 2
    assert len(buffer.pop(most_bytes=1)) == 1
    assert len(buffer.pop()) == 2
