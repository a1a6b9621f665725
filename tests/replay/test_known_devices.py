"""Devices that the directory knows at the start of a replay; those that appear then get the ids that they had."""

import pytest

from homebot.devices import Device
from homebot.devices.device import Endpoint
from homebot.devices.services import IndexRow, IndexTable
from homebot.discovery.record import read_tombstone
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.recording.lines import RecordingHeader
from homebot.recording.recording import Recording
from homebot.replay.replay import check_index, ids_to_come

AT = Time(sec=1_767_225_600, nanosec=0)


def device(name: str, *keys: str) -> Device:
    endpoints = tuple(Endpoint(gateway="mqtt", key=key, address="", command_address="") for key in keys)
    return Device(
        id=name,
        name=name,
        service_type="light",
        endpoints=endpoints,
        metadata=(),
        first_seen=AT,
        last_seen=AT,
        expires=AT,
        freshness="fresh",
    )


def keys_by_id(*devices: Device, index: tuple[str, ...] = ()) -> dict[str, list[str]]:
    recording = Recording(RecordingHeader(format=2, version="1", home="home", started_at=AT))
    recording.devices = {one.id: one for one in devices}
    recording.index = [IndexRow(table="devices", id=one, record="{}") for one in index]
    rows = ids_to_come(recording)
    assert {row.table for row in rows} <= {"tombstones"}
    return {row.id: [key for _, key in read_tombstone(row.id, row.record).keys] for row in rows}


def test_each_device_is_found_by_its_announcements() -> None:
    assert keys_by_id(device("hall", "a", "b"), device("study", "c")) == {"hall": ["a", "b"], "study": ["c"]}


def test_what_the_index_has_already_needs_nothing() -> None:
    assert keys_by_id(device("hall", "a"), device("study", "c"), index=("hall",)) == {"study": ["c"]}


def test_what_was_split_from_a_device_does_not_get_its_announcement_before() -> None:
    assert keys_by_id(device("hall", "a", "b"), device("hall_2", "b")) == {"hall": ["a", "b"]}


@pytest.mark.parametrize("table", ["devices", "tombstones"])
def test_a_damaged_row_of_the_index_is_refused(table: IndexTable) -> None:
    recording = Recording(RecordingHeader(format=2, version="1", home="home", started_at=AT))
    recording.index = [IndexRow(table=table, id="hall", record="{nonsense")]
    with pytest.raises(UsageError, match="the recording is damaged: the row 'hall' of its index: no record: Invalid"):
        check_index(recording)
