"""Content formats of CoAP."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.integrations.things.formats.content_formats import (
    coap_formats,
    content_format_of,
    content_type_of,
)


@pytest.mark.parametrize(
    ("number", "content_type"),
    [(0, "text/plain"), (40, "application/link-format"), (60, "application/cbor"), (432, "application/td+json")],
)
def test_numbers_and_types_stand_for_each_other(number: int, content_type: str) -> None:
    assert content_type_of(number) == content_type
    assert content_format_of(f"{content_type}; charset=utf-8") == number


def test_an_unknown_number_is_a_type_that_nothing_understands_and_comes_back() -> None:
    assert content_type_of(None) == ""
    unknown = content_type_of(11542)
    assert coap_formats(unknown) is None
    assert content_format_of(unknown) == 11542
    assert content_format_of("image/x-none") is None


@pytest.mark.parametrize(
    ("content_type", "payload", "document"),
    [
        ("text/plain", b"21.5", 21.5),
        ("application/json", b'{"a": 1}', {"a": 1}),
        ("application/cbor", b"\xa1\x65value\xf5", {"value": True}),
    ],
)
def test_payloads_are_read_by_their_type(content_type: str, payload: bytes, document: object) -> None:
    found = coap_formats(content_type)
    assert found is not None
    assert found.parse(payload) == document


WORDS = {"true", "false", "null"}
"""Texts that plain text cannot tell from values."""


@given(
    st.sampled_from(["text/plain", "application/json", "application/cbor"]),
    st.booleans()
    | st.integers(-(2**40), 2**40)
    | st.text(st.characters(categories=["L"]), min_size=1, max_size=9).filter(lambda text: text not in WORDS),
)
def test_written_documents_of_any_type_are_read_again(content_type: str, value: object) -> None:
    found = coap_formats(content_type)
    assert found is not None
    document = found.parse(found.encode(value))
    assert document == value or str(document) == str(value)
