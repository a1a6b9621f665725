"""Tags of others: records that homebot does not read, damaged ones, and Smart Posters."""

import subprocess
import sys

import ndef
import pytest

from homebot.conventions.nfc.ndef_message import NdefRecord, read_ndef
from homebot.errors import WireError


def message(*records: object) -> bytes:
    return b"".join(ndef.message_encoder(records))


URI = ndef.UriRecord("http://lamp.local/")
READ = NdefRecord("uri", b"http://lamp.local/")
WIFI = ndef.Record("application/vnd.wfa.wsc", "", b"\x10\x0e\xff")
DAMAGED_TEXT = ndef.Record("urn:nfc:wkt:T", "", b"\x02de\xff\xfe")
POSTER = ndef.Record("urn:nfc:wkt:Sp", "", message(ndef.TextRecord("Lamp"), URI, ndef.Record("image/png", "", b"x")))


@pytest.mark.parametrize(
    "other",
    [
        ndef.Record("urn:nfc:wkt:Hs", "", b"\x12\x91\x02\x0aac"),
        ndef.Record("urn:nfc:wkt:Sp", "", b"\xd1\x01\x05U\x04a"),
        ndef.Record("unknown", "", b"x"),
        DAMAGED_TEXT,
    ],
)
def test_a_record_that_cannot_be_read_does_not_hide_the_others(other: object) -> None:
    assert read_ndef(message(other, URI)) == (READ,)
    assert read_ndef(message(URI, other)) == (READ,)


def test_the_settings_of_a_network_are_not_looked_into() -> None:
    assert read_ndef(message(URI, WIFI)) == (READ, NdefRecord("media", b"\x10\x0e\xff", "application/vnd.wfa.wsc"))


def test_a_message_of_damaged_records_alone_is_refused() -> None:
    with pytest.raises(WireError):
        read_ndef(message(DAMAGED_TEXT))


def test_a_poster_is_its_address_and_its_title() -> None:
    assert read_ndef(message(POSTER)) == (READ, NdefRecord("text", b"Lamp"))


def test_posters_in_posters_are_passed_over() -> None:
    nested = POSTER
    for _ in range(300):
        nested = ndef.Record("urn:nfc:wkt:Sp", "", message(nested))
    assert read_ndef(message(nested)) == ()


def test_nothing_is_loaded_while_messages_are_read_and_written() -> None:
    """The event loop would wait for the disk, or for another thread that imports."""
    program = """
import sys
from homebot.conventions.nfc.ndef_message import NdefRecord, load_ndef, read_ndef, write_ndef
load_ndef()
before = set(sys.modules)
for record in NdefRecord("uri", "http://h\\u00fctte.example/td".encode()), NdefRecord("text", b"Hall"):
    assert read_ndef(write_ndef(record))
print(sorted(set(sys.modules) - before))
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
