"""Entity tags of pages."""

from __future__ import annotations

import pytest

from homebot.gateways.thing_directory.read_pages import etag_of


@pytest.mark.parametrize("etag", ['"a"', 'W/"a-1"', '""'])
def test_an_entity_tag_can_be_sent_back(etag: str) -> None:
    assert etag_of({"etag": etag}) == etag


@pytest.mark.parametrize("etag", ["", "a", '"a', '"a", "b"', '"a\r\nX: y"', '"ü"', f'"{"a" * 1000}"'])
def test_what_is_no_entity_tag_is_not_sent_back(etag: str) -> None:
    assert etag_of({"etag": etag}) == ""
