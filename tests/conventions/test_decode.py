"""Texts and JSON in what a device says."""

from homebot.conventions.payload import to_json, to_text


def test_what_is_no_text_or_json_is_none() -> None:
    assert to_text(b"\xff") is None
    assert to_text(b"x" * 300_000) is None
    assert to_json(b"NaN") is None
    assert to_json(b'{"a":1}') == {"a": 1}
