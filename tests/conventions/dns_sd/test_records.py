"""TXT records are read as RFC 6763, section 6, says."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.dns_sd.records import MAX_KEYS, read_txt


def strings(*texts: bytes) -> bytes:
    return b"".join(bytes([len(one)]) + one for one in texts)


@pytest.mark.parametrize(
    ("data", "properties"),
    [
        (b"", {}),
        (b"\0", {}),
        (strings(b"papersize=A4"), {"papersize": "A4"}),
        (strings(b"PaperSize=A4", b"papersize=A3"), {"papersize": "A4"}),
        (strings(b"flag", b"empty="), {"flag": "", "empty": ""}),
        (strings(b"a=b=c"), {"a": "b=c"}),
        (strings(b"=nothing", b"x=1"), {"x": "1"}),
        (strings("name=Küche".encode()), {"name": "Küche"}),
        (strings(b"raw=\xff\x00"), {"raw": "\\xff\x00"}),
        (strings(b"k\x80=1", b"x\n=1", b"ok=1"), {"ok": "1"}),
    ],
)
def test_a_record_is_read(data: bytes, properties: dict[str, str]) -> None:
    record = read_txt(data)
    assert (dict(record.properties), record.problem) == (properties, "")


def test_a_record_that_ends_within_a_string_is_read_up_to_its_end_with_the_problem() -> None:
    record = read_txt(strings(b"a=1") + b"\x09b=2")
    assert dict(record.properties) == {"a": "1", "b": "2"}
    assert record.problem == "its TXT record ends within a string of 9 bytes"


def test_a_record_with_too_many_keys_is_cut() -> None:
    record = read_txt(strings(*(f"k{number}=1".encode() for number in range(500))))
    assert len(record.properties) == MAX_KEYS
    assert record.problem


@given(st.binary(max_size=9000))
def test_any_bytes_are_read(data: bytes) -> None:
    record = read_txt(data)
    assert len(record.properties) <= MAX_KEYS
    assert all(
        key.isascii() and key == key.lower() and value.encode() is not None for key, value in record.properties.items()
    )


@given(st.dictionaries(st.text("abcdefgh-_ 0123", min_size=1, max_size=20), st.text(max_size=40), max_size=20))
def test_written_values_are_read(properties: dict[str, str]) -> None:
    record = read_txt(strings(*(f"{key}={value}".encode() for key, value in properties.items())))
    assert (dict(record.properties), record.problem) == (properties, "")
