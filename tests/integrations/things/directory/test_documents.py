"""Documents of a directory of things: pages of the list, links to the next one, and events."""

from datetime import UTC, datetime

import pytest

from homebot.errors import WireError
from homebot.integrations.things.directory.documents import (
    DirectoryEvent,
    lifetime_of,
    members_of,
    next_page,
    read_event,
    text_of,
)


def test_a_page_is_an_array_or_a_collection_with_members() -> None:
    things = [{"id": "urn:1"}, {"id": "urn:2"}]
    assert members_of(things) == things
    collection = {"@type": "ThingCollection", "total": 2, "members": things}
    assert members_of(collection) == things


@pytest.mark.parametrize("page", [None, {}, {"members": 5}, 5, "x"])
def test_an_invalid_page_is_an_error(page: object) -> None:
    with pytest.raises(WireError):
        members_of(page)


@pytest.mark.parametrize(
    ("header", "address"),
    [
        ('</things?offset=50>; rel="next"', "/things?offset=50"),
        ("</things?offset=50>;rel=next", "/things?offset=50"),
        ('</a>; rel="prev", </b?x=1,2>; title="a, b"; rel="last next"', "/b?x=1,2"),
        ('</a>; REL="NEXT"; etag="x"', "/a"),
        ('</a>; rel="prev"', ""),
        ('</a>; rel="nextish"', ""),
        ("", ""),
        ("<<<>;;;,,,", ""),
    ],
)
def test_the_next_page_is_named_by_a_link(header: str, address: str) -> None:
    assert next_page([], {"link": header}) == address


def test_the_next_page_of_a_collection_stands_in_it() -> None:
    assert next_page({"members": [], "next": "/things?offset=9"}, {}) == "/things?offset=9"
    assert next_page({"members": [], "next": 9}, {}) == ""


def test_an_event_names_the_thing_that_has_changed() -> None:
    assert read_event("thing_updated", '{"id": "urn:1", "title": "Lamp"}') == DirectoryEvent("thing_updated", "urn:1")


def test_events_of_other_kinds_are_passed_over() -> None:
    assert read_event("message", "hello") is None


@pytest.mark.parametrize("data", ["", "[]", "{}", '{"id": 5}', '{"id": ""}', '{"id": "a b"}'])
def test_an_event_without_an_id_is_an_error(data: str) -> None:
    with pytest.raises(WireError):
        read_event("thing_deleted", data)


def test_the_moment_of_reading_changes_no_description() -> None:
    one = {"id": "urn:1", "title": "A", "registration": {"retrieved": "2026-01-01T00:00:00Z"}}
    other = {"title": "A", "id": "urn:1", "registration": {"retrieved": "2026-01-02T00:00:00Z"}}
    assert text_of(one) == text_of(other)
    assert text_of(one) != text_of({**one, "title": "B"})


@pytest.mark.parametrize(
    ("ttl", "lifetime"),
    [(3600, 3600.0), (1, 60.0), (1e12, 2_592_000.0), (0, 0.0), (-5, 0.0), ("soon", 0.0), (None, 0.0)],
)
def test_the_lifetime_of_a_registration_is_bounded(ttl: object, lifetime: float) -> None:
    assert lifetime_of({"registration": {"ttl": ttl}}, 0.0) == lifetime


@pytest.mark.parametrize(
    ("expires", "lifetime"),
    [
        ("2026-01-01T01:00:00Z", 3600.0),
        ("2026-01-01T02:00:00.5+01:00", 3600.5),
        ("2026-01-01T01:00:00", 3600.0),
        ("2025-12-31T00:00:00Z", 60.0),
        ("9999-12-31T23:59:59Z", 2_592_000.0),
        ("0001-01-01T00:00:00+23:59", 60.0),
        ("soon", 0.0),
        (5, 0.0),
    ],
)
def test_a_registration_may_say_when_it_ends(expires: object, lifetime: float) -> None:
    new_year = datetime(2026, 1, 1, tzinfo=UTC).timestamp()
    assert lifetime_of({"registration": {"expires": expires}}, new_year) == lifetime
    assert lifetime_of({"registration": {"expires": expires, "ttl": 100}}, new_year) == 100.0
