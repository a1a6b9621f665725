"""CBOR: the examples of RFC 8949, another implementation, and bytes that mean harm."""

import math
from contextlib import suppress
from typing import Any

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.cbor import decode_cbor, encode_cbor
from homebot.errors import WireError


@pytest.mark.parametrize(
    ("payload", "document"),
    [
        ("00", 0),
        ("17", 23),
        ("1818", 24),
        ("1bffffffffffffffff", 2**64 - 1),
        ("20", -1),
        ("3903e7", -1000),
        ("3bffffffffffffffff", -(2**64)),
        ("f90000", 0.0),
        ("f93c00", 1.0),
        ("fb3ff199999999999a", 1.1),
        ("f97bff", 65504.0),
        ("fa47c35000", 100000.0),
        ("f97c00", None),
        ("f97e00", None),
        ("f4", False),
        ("f5", True),
        ("f6", None),
        ("f7", None),
        ("f8ff", None),
        ("c11a514b67b0", 1363896240),
        ("4401020304", "\x01\x02\x03\x04"),
        ("6449455446", "IETF"),
        ("62c3bc", "ü"),
        ("80", []),
        ("8301820203820405", [1, [2, 3], [4, 5]]),
        ("a201020304", {1: 2, 3: 4}),
        ("a26161016162820203", {"a": 1, "b": [2, 3]}),
        ("7f657374726561646d696e67ff", "streaming"),
        ("9fff", []),
        ("9f018202039f0405ffff", [1, [2, 3], [4, 5]]),
        ("bf6346756ef563416d7421ff", {"Fun": True, "Amt": -2}),
    ],
)
def test_documents_are_read_as_rfc_8949_spells_them(payload: str, document: object) -> None:
    """Of its appendix A; numbers without end are unknown."""
    assert decode_cbor(bytes.fromhex(payload)) == document


@pytest.mark.parametrize(
    ("payload", "problem"),
    [
        (b"", "ends too early"),
        (b"\x18", "ends too early"),
        (b"\x00\x00", "1 bytes after its end"),
        (b"\x1c", "reserved information 28"),
        (b"\xfc", "reserved information 28"),
        (b"\xff", "a break that ends nothing"),
        (b"\x82\xff\x00", "a break that ends nothing"),
        (b"\x81" * 40 + b"\x00", "nested deeper than 32"),
        (b"\x9b" + b"\xff" * 8, "ends too early"),
        (b"\x9a\x00\x00\x40\x00" + b"\x00" * 0x4000, "more than 10000 items"),
        (b"\xa1\xf5\x00", "a key that is a bool"),
        (b"\xa1\x80\x00", "a key that is a list"),
        (b"\x62\xff\xff", "not UTF-8"),
        (b"\x7f\x00\xff", "a int in a string"),
        (b"\x00" * 300_000, "longer than"),
    ],
)
def test_invalid_or_long_cbor_is_refused(payload: bytes, problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        decode_cbor(payload)


_documents: st.SearchStrategy[Any] = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**64), 2**64 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=30),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=5), inner, max_size=5),
    max_leaves=20,
)


@given(_documents)
def test_another_implementation_reads_and_is_read(document: Any) -> None:
    assert cbor2.loads(encode_cbor(document)) == document
    assert decode_cbor(cbor2.dumps(document)) == document


@given(st.binary(max_size=200))
def test_any_bytes_are_a_document_or_a_clear_error(payload: bytes) -> None:
    with suppress(WireError):
        document = decode_cbor(payload)
        assert not isinstance(document, float) or math.isfinite(document)


def test_byte_strings_stay_bytes_where_they_are_asked_for() -> None:
    assert decode_cbor(bytes.fromhex("a1616244fffe0102"), as_bytes=True) == {"b": b"\xff\xfe\x01\x02"}
    with pytest.raises(WireError, match="longer than 7"):
        decode_cbor(bytes.fromhex("a1616244fffe0102"), 7, as_bytes=True)


def test_a_value_that_is_no_document_is_refused() -> None:
    with pytest.raises(TypeError):
        encode_cbor({1, 2})
    with pytest.raises(TypeError):
        encode_cbor(b"x")
