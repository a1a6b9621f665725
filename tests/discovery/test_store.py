"""The index file: what is in it comes back, and nothing that is wrong with it is fatal."""

import sqlite3
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.discovery.announcements import announce, part_of

from homebot.discovery import DeviceIndex
from homebot.discovery.ids import Tombstone
from homebot.discovery.record import Records, entry_record, read_entry, read_tombstone, tombstone_record
from homebot.discovery.store import VERSION, IndexFile, index_path
from homebot.errors import LinkError, UsageError, WireError
from homebot.support.sqlite_file import SqliteFile, SqliteSchema


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "home" / "index.sqlite"


def test_what_is_written_is_read(path: Path) -> None:
    """In a directory that was not there; ids that went are gone."""
    file = IndexFile(path)
    assert file.open(0.0) is None
    file.write(Records((("a", "1"), ("b", "2")), (("c", "3"),)), ())
    file.write(Records((("a", "4"),), ()), ("a", "b", "c"))
    file.close()
    file.close()

    again = IndexFile(path)
    assert again.open(0.0) is None
    assert again.read() == Records((("a", "4"),), ())
    again.close()
    assert path.parent.stat().st_mode & 0o077 == 0


def test_what_the_owner_states_is_on_the_disk_when_it_is_written(path: Path) -> None:
    """A power cut loses none of it; when devices were last seen is not worth that to an SD card."""
    file = IndexFile(path)
    file.open(0.0)
    levels = []
    for owner in ((("places", "hall"),), ()):
        file.write(Records((("a", "1"),), (), owner), ("a",))
        levels += file._opened().execute("PRAGMA synchronous").fetchone()
    file.close()
    assert levels == [2, 1]  # FULL, NORMAL


def test_a_file_that_others_may_write_is_not_used(path: Path) -> None:
    """What stands in it may be their doing. One that they may read becomes the user's alone."""
    file = IndexFile(path)
    file.open(0.0)
    file.close()
    assert path.stat().st_mode & 0o777 == 0o600
    path.chmod(0o644)
    file.open(0.0)
    file.close()
    assert path.stat().st_mode & 0o777 == 0o600
    for place in (path, path.parent):
        before = place.stat().st_mode
        place.chmod(0o777)
        with pytest.raises(UsageError, match=r"the index file is not used: .* can be written by others; .* chmod go-w"):
            file.open(0.0)
        place.chmod(before)


def test_a_file_of_version_1_is_migrated(path: Path) -> None:
    """It had no tombstones."""
    path.parent.mkdir()
    with sqlite3.connect(path) as old:
        old.execute("CREATE TABLE devices (id TEXT PRIMARY KEY, record TEXT NOT NULL) WITHOUT ROWID")
        old.execute("INSERT INTO devices VALUES ('a', 'old')")
        old.execute("PRAGMA user_version = 1")
    old.close()
    file = IndexFile(path)
    assert file.open(0.0) is None
    file.write(Records((), (("t", "stone"),), (("merging", "{}"),)), ())
    assert file.read() == Records((("a", "old"),), (("t", "stone"),), (("merging", "{}"),))
    file.close()


def test_a_file_of_version_2_is_migrated(path: Path) -> None:
    """The owner could decide nothing."""
    path.parent.mkdir()
    with sqlite3.connect(path) as old:
        for name in ("devices", "tombstones"):
            old.execute(f"CREATE TABLE {name} (id TEXT PRIMARY KEY, record TEXT NOT NULL)")
        old.execute("INSERT INTO tombstones VALUES ('t', 'stone')")
        old.execute("PRAGMA user_version = 2")
    old.close()
    file = IndexFile(path)
    assert file.open(0.0) is None
    assert file.read() == Records((), (("t", "stone"),))
    file.close()


def test_a_file_of_a_newer_version_is_left_alone(path: Path) -> None:
    path.parent.mkdir()
    with sqlite3.connect(path) as new:
        new.execute(f"PRAGMA user_version = {VERSION + 1}")
    new.close()
    before = path.read_bytes()
    with pytest.raises(UsageError, match="newer homebot"):
        IndexFile(path).open(0.0)
    assert path.read_bytes() == before


@pytest.mark.parametrize(
    "content", [b"no database at all, but long enough to be one" * 50, b"SQLite format 3\0" + b"\xff" * 5000]
)
def test_a_damaged_file_is_set_aside_and_a_new_one_begun(path: Path, content: bytes) -> None:
    path.parent.mkdir()
    path.write_bytes(content)
    file = IndexFile(path)
    aside = file.open(1234.5)
    assert aside == path.with_name("index.sqlite.damaged-1234")
    assert aside.read_bytes() == content
    assert file.read() == Records()
    file.close()

    path.write_bytes(content)
    assert IndexFile(path).open(1234.5) == path.with_name("index.sqlite.damaged-1234-2")


def test_a_file_with_other_tables_is_not_used_and_stays(path: Path) -> None:
    path.parent.mkdir()
    with sqlite3.connect(path) as other:
        other.execute("CREATE TABLE something (x)")
        other.execute(f"PRAGMA user_version = {VERSION}")
    other.close()
    before = path.read_bytes()
    with pytest.raises(LinkError, match="cannot be opened: no such table"):
        IndexFile(path).open(5.0)
    assert path.read_bytes()[100:] == before[100:]


@pytest.mark.parametrize("was_closed", [True, False])
def test_a_page_that_went_bad_is_found(path: Path, *, was_closed: bool) -> None:
    """Where it is read; after an unclean end, of which SQLite leaves a file, at the opening."""
    file = IndexFile(path)
    file.open(0.0)
    file.write(Records(tuple((f"d{one:04}", "x" * 400) for one in range(500))), ())
    file.close()
    content = bytearray(path.read_bytes())
    content[-4096:] = b"\x55" * 4096
    path.write_bytes(content)
    if was_closed:
        assert file.open(7.0) is None
        with pytest.raises(WireError, match="is damaged"):
            file.read()
    else:
        path.with_name(path.name + "-wal").touch()
        assert file.open(7.0) is not None


def test_a_disk_that_fails_for_a_moment_is_no_damage(path: Path) -> None:
    """SQLite's own interruption stands in for its error."""
    file = IndexFile(path)
    file.open(0.0)
    connection = file._opened()
    connection.set_progress_handler(lambda: 1, 1)
    with pytest.raises(LinkError, match="cannot be read: interrupted"):
        file.read()
    connection.set_progress_handler(None, 0)
    assert file.read() == Records()
    file.close()


def test_a_damaged_file_that_cannot_be_moved_is_told(tmp_path: Path) -> None:
    """As on a disk that can only be read; here its name would be too long."""
    path = tmp_path / ("i" * 245)
    path.write_bytes(b"no database at all" * 1000)

    with pytest.raises(LinkError, match="cannot be recreated"):
        IndexFile(path).open(1e9)

    assert path.read_bytes().startswith(b"no database")


def test_a_place_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(LinkError, match="cannot be opened"):
        IndexFile(blocked / "index.sqlite").open(0.0)
    with pytest.raises(LinkError, match="not open"):
        IndexFile(tmp_path / "x").read()


def test_a_place_that_homebot_may_not_write_is_told_with_what_to_do(tmp_path: Path) -> None:
    """For root, as whom tests may run, there is no such place."""

    class ForbiddenFile(SqliteFile):
        def _make_private(self) -> None:
            raise PermissionError(13, "Permission denied", "/data")

    with pytest.raises(
        LinkError, match=r"cannot be opened: Permission denied; give homebot a directory .*HOMEBOT_DATA"
    ):
        ForbiddenFile(tmp_path / "index.sqlite", SqliteSchema("index file", 1, (), ())).open(0.0)


def test_a_full_disk_costs_nothing_that_was_there(path: Path) -> None:
    """SQLite's own limit stands in for the disk's."""
    file = IndexFile(path)
    file.open(0.0)
    file.write(Records((("a", "1"),)), ())
    connection = file._connection
    assert connection is not None
    (pages,) = connection.execute("PRAGMA page_count").fetchone()
    connection.execute(f"PRAGMA max_page_count = {pages}")
    with pytest.raises(LinkError, match="full"):
        file.write(Records((("a", "2"), ("b", "x" * 100_000))), ("a",))
    assert file.read() == Records((("a", "1"),), ())
    connection.execute("PRAGMA max_page_count = 100000")
    file.write(Records((("a", "2"),)), ("a",))
    assert file.read().devices == (("a", "2"),)
    file.close()


def test_a_file_that_another_homebot_uses_is_left_to_it(path: Path) -> None:
    """Until that one ends."""
    first, second = IndexFile(path), IndexFile(path, busy_timeout=0.01)
    first.open(0.0)
    with pytest.raises(UsageError, match=r"is in use by another homebot; .*--ephemeral"):
        second.open(0.0)
    first.write(Records((("lamp", "{}"),), ()), ())
    first.close()
    second.open(0.0)
    assert second.read().devices == (("lamp", "{}"),)
    second.close()


@pytest.mark.skipif(sys.platform != "linux", reason="each system has its own place")
def test_the_place_is_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path))
    assert index_path("my home/x", "10.0.0.1:1883").parent.parent.parent == tmp_path
    monkeypatch.delenv("HOMEBOT_DATA")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    assert index_path("h", "embedded") == tmp_path / "homebot" / "h" / "embedded" / "index.sqlite"
    monkeypatch.delenv("XDG_DATA_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert index_path("h", "embedded") == tmp_path / ".local/share/homebot/h/embedded/index.sqlite"


def test_a_device_of_the_file_is_as_it_was_but_unconfirmed() -> None:
    """Its id stays, its states are gone, and it has the time of a new one to be heard."""
    index = DeviceIndex(forget_after=1000.0)
    lamp = announce(
        "l", part_of("light", "on_off", id="l"), ids=("mac:aabbccddeeff",), name="Lamp", at=5, confirmed=True
    )
    own = announce("z", part_of("light", "on_off", id="s"), convention="zigbee2mqtt", ids=("mac:aabbccddeeff",), at=6)
    for one in (lamp, own, announce("l", lamp.parts[0], ids=("mac:aabbccddeeff",), name="Renamed", at=7)):
        index.observe(one)
    entry = index.entry("lamp")
    assert entry is not None
    text = entry_record(entry)

    after = DeviceIndex(forget_after=1000.0, first_sequence=100)
    after.restore(read_entry("lamp", text), now=9000.0)
    (change,) = after.pop_changes()
    device = change.device
    assert (change.kind, device.id, device.freshness, device.last_seen.sec) == ("appeared", "lamp", "unconfirmed", 6)
    assert (device.first_seen.sec, device.expires.sec) == (5, 12600)
    assert [len(one.routes) for one in device.parts] == [2]
    assert device.evidence == index.devices()[0].evidence
    after.observe(announce("l", lamp.parts[0], ids=("mac:aabbccddeeff",), name="Renamed", at=9001))
    assert after.pop_changes() == ()


def test_a_tombstone_of_the_file_is_as_it_was() -> None:
    stone = Tombstone("lamp", (("mqtt", "k"),), ("mac:1",), retained_only=True, at=5.0, first_seen=2.0)
    assert read_tombstone("lamp", tombstone_record(stone)) == stone


def test_a_device_of_what_can_be_no_gateway_is_no_record() -> None:
    """Apps would look for that gateway."""
    index = DeviceIndex(forget_after=1000.0)
    index.observe(announce("l", part_of("light", "on_off"), name="Lamp", gateway="no gateway!"))
    entry = index.entry("lamp")
    assert entry is not None
    with pytest.raises(WireError, match="a device of no gateway"):
        read_entry("lamp", entry_record(entry))


@given(st.text(max_size=200))
def test_any_other_text_is_no_record(text: str) -> None:
    with pytest.raises(WireError):
        read_entry("x", text)
    with pytest.raises(WireError):
        read_tombstone("x", text)
