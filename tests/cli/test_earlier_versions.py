"""What earlier versions wrote is read: a folder ``tests/data/VERSION`` each, made by ``homebot backup`` and ``record``.

The house: a lamp that a client commanded and the owner placed, a sensor with a weak battery, an app that
keeps values.
"""

import gzip
from pathlib import Path

import pytest

from homebot.apps.stores import StoreFile
from homebot.cli import main
from homebot.devices.journal_messages import ReadJournalRequest
from homebot.discovery.persistence import _understood
from homebot.discovery.store import IndexFile
from homebot.features.history.history_file import HistoryFile
from homebot.features.history.settings import KeepSettings
from homebot.journal.journal_file import JournalFile
from homebot.recording.recording import load_recording
from homebot.runtime.saved_files import SAVED_FILES
from homebot.support.sqlite_file import SqliteFile

VERSIONS = sorted((Path(__file__).parents[1] / "data").iterdir())


@pytest.fixture(params=VERSIONS, ids=lambda one: one.name)
def version(request: pytest.FixtureRequest) -> Path:
    folder: Path = request.param
    return folder


@pytest.fixture
def data(version: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of the restored files."""
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))
    (tmp_path / "house").mkdir()
    monkeypatch.chdir(tmp_path / "house")
    archive = tmp_path / "villa.tar"
    archive.write_bytes(gzip.decompress((version / "villa.tar.gz").read_bytes()))
    assert main(["restore", str(archive)]) == 0
    (folder,) = (tmp_path / "data" / "old_x20villa").iterdir()
    return folder


def test_all_files_are_read(data: Path) -> None:
    index, journal = IndexFile(data / "index.sqlite"), JournalFile(data / "journal.sqlite")
    history, store = HistoryFile(data / "history.sqlite", KeepSettings()), StoreFile(data / "apps.sqlite")
    files: tuple[SqliteFile, ...] = (index, journal, history, store)
    assert {one.path.name for one in files} == set(SAVED_FILES)
    assert [one.open(0.0) for one in files] == [None] * 4  # none is set aside as damaged
    known = _understood(index.read())
    assert (sorted(one.id for one in known.entries), known.rejected) == (["desk_lamp", "front_door_sensor"], 0)
    assert "Study" in known.owner["places"]
    entries = journal.read_entries(ReadJournalRequest()).entries
    kinds = [one.kind for one in entries if one.device == "desk_lamp"]
    assert kinds == ["requested", "sent", "acknowledged", "reported", "outcome"]
    assert ("front_door_sensor", "battery") in {(place[0], place[2]) for place in history.load().series}
    assert store.read()["keeper"] == {"starts": "1", "words": '{"hall":["a","\\u00fc"]}'}
    for one in files:
        one.close()


def test_the_configuration_is_valid(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert data.exists()
    assert main(["config", "check"]) == 0
    assert "is valid: home old villa" in capsys.readouterr().out


def test_a_recording_is_read(version: Path) -> None:
    recording = load_recording(version / "day.jsonl.gz")
    assert recording.is_whole
    assert set(recording.devices) == {"desk_lamp", "front_door_sensor"}
    assert len(recording.commands) == 1
