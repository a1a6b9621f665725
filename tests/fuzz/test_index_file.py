"""A damaged index file costs what was damaged: its records are refused one by one, the file is set aside as a whole."""

from contextlib import suppress
from pathlib import Path

from tests.announcements import LAMP, sighting_of
from tests.fuzz.conftest import Fuzz

from homebot.discovery import DeviceIndex
from homebot.discovery.record import Records, entry_record, read_entry, read_tombstone
from homebot.discovery.store import IndexFile
from homebot.errors import LinkError, UsageError, WireError

STONE = '{"keys": [["mqtt", "lamp"]], "hardware": ["mac:00158d0001abcdef"], "is_ghost": false, "at": 5.0}'


def a_record() -> str:
    """The record of a lamp."""
    index = DeviceIndex(forget_after=1000.0)
    sighting = sighting_of(
        "lamp", LAMP, address="a", command_address="b", identifiers=("mac:00158d0001abcdef",), at=1.0, lasts=98.0
    )
    index.observe(sighting)
    entry = index.entry("lamp")
    assert entry is not None
    return entry_record(entry)


def test_a_damaged_index_is_refused_or_read(fuzz: Fuzz, tmp_path: Path) -> None:
    record = a_record()
    whole = tmp_path / "whole.sqlite"
    file = IndexFile(whole)
    file.open(0.0)
    file.write(Records((("lamp", record),), (("gone", STONE),)), ())
    file.close()
    image = whole.read_bytes()

    for mutate, rng in fuzz("index file", ("mqtt", "lamp", "sighting", "claims", "part_ids")):
        for read, text in ((read_entry, record), (read_tombstone, STONE)):
            with suppress(WireError):
                read("lamp", mutate.damaged_json(text).decode(errors="replace"))
        if rng.random() < 0.02:
            open_damaged(mutate.damaged_bytes(image), tmp_path / f"{rng.random()}.sqlite")


def open_damaged(image: bytes, path: Path) -> None:
    """Open, read and write it: whatever is wrong is told as a LinkError, or the file is set aside."""
    path.write_bytes(image)
    file = IndexFile(path)
    with suppress(LinkError, UsageError, WireError):
        file.open(1.0)
        for device_id, text in file.read().devices:
            with suppress(WireError):
                read_entry(device_id, text)
        file.write(Records((("new", "{}"),), ()), ())
    file.close()
    for left in path.parent.glob(f"{path.name}*"):
        left.unlink()
