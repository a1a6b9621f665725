"""Phones with OwnTracks, by the messages of its documentation (owntracks.org/booklet/tech/json)."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.description import DeviceAnnounced
from homebot.errors import WireError
from homebot.integrations.owntracks.formats import OwnTracks, OwnTracksSettings

TOPIC = "owntracks/jane/phone"
LOCATION = {
    "_type": "location", "acc": 5, "alt": 362, "batt": 76, "bs": 1, "conn": "w", "created_at": 1618260910,
    "inregions": ["Home"], "lat": 47.5968792, "lon": 12.9540961, "t": "p", "tid": "dy", "tst": 1618243873, "vac": 3,
}  # fmt: skip
COFFEE = {
    "_type": "transition", "desc": "My favorite coffee shop (Delaville)", "event": "enter", "lat": 48.87069,
    "lon": 2.34916, "rid": "f7676c", "tid": "j1", "tst": 1707057574, "wtst": 1610104395,
}  # fmt: skip


def phone() -> DeviceAnnounced:
    (found,) = OwnTracks(OwnTracksSettings()).read_message(TOPIC, json.dumps(LOCATION).encode(), retained=False)
    assert isinstance(found, DeviceAnnounced)
    return found


def test_a_location_announces_the_phone() -> None:
    found = phone()
    assert (found.key, found.name) == ("jane/phone", "jane phone")
    assert found.parts[0].part.reads == (TOPIC, f"{TOPIC}/event")


@pytest.mark.parametrize(
    ("message", "place"),
    [
        (LOCATION, "home"),
        (LOCATION | {"inregions": ["Garage", "home"]}, "home"),
        (LOCATION | {"inregions": ["Work"]}, "Work"),
        (LOCATION | {"inregions": []}, "not_home"),
        (LOCATION | {"inregions": ["-home"]}, "home"),
        (LOCATION | {"inregions": ["", 'Tom\'s "Pub"', 7]}, 'Tom\'s "Pub"'),
        ({one: LOCATION[one] for one in LOCATION if one != "inregions"}, "not_home"),
        (LOCATION | {"inregions": "Home"}, None),
        ({"_type": "lwt", "tst": 1380738247}, None),
        ({"_type": "waypoint", "desc": "Home", "inregions": ["Home"]}, None),
    ],
)
def test_the_regions_tell_the_place(message: object, place: str | None) -> None:
    assert phone().parts[0].codec.read(TOPIC, json.dumps(message).encode(), retained=False).get("place") == place


@pytest.mark.parametrize(
    ("message", "place"),
    [
        (COFFEE | {"desc": "Home"}, "home"),
        (COFFEE | {"desc": "Home", "event": "leave"}, "not_home"),
        (COFFEE, None),
        (COFFEE | {"event": "leave"}, None),
        (COFFEE | {"desc": "Home", "event": "hover"}, None),
        (COFFEE | {"desc": ["Home"]}, None),
    ],
)
def test_only_the_region_of_the_home_is_entered_and_left(message: object, place: str | None) -> None:
    """A coffee shop may overlap with it."""
    read = phone().parts[0].codec.read(f"{TOPIC}/event", json.dumps(message).encode(), retained=False)
    assert read.get("place") == place


def places(*told: tuple[str, object]) -> list[object]:
    """Return the places that one phone tells by messages on its topic with these endings."""
    codec = phone().parts[0].codec
    found = [codec.read(f"{TOPIC}{end}", json.dumps(message).encode(), retained=False) for end, message in told]
    return [one.get("place") for one in found]


def at(told_at: object, *regions: str) -> tuple[str, object]:
    return "", LOCATION | {"tst": told_at, "inregions": list(regions)}


def moved(event: str, told_at: int) -> tuple[str, object]:
    return "/event", COFFEE | {"desc": "Home", "event": event, "tst": told_at}


DAY = 86_400


def test_a_message_that_comes_late_is_not_read() -> None:
    told = (
        at(1_000, "Home"),
        moved("leave", 2_000),
        at(1_900, "Home"),
        moved("enter", 1_500),
        at(2_000),
        at(2_001, "Home"),
    )
    assert places(*told) == ["home", "not_home", None, None, "not_home", "home"]


def test_a_will_is_no_news_of_a_place_whatever_its_time() -> None:
    assert places(("", {"_type": "lwt", "tst": 9_000}), at(8_000, "Home")) == [None, "home"]


@pytest.mark.parametrize("told_at", [None, "soon", [], 100 * DAY - 8 * DAY])
def test_a_time_that_cannot_be_or_a_clock_that_was_set_makes_nothing_late(told_at: object) -> None:
    assert places(at(100 * DAY, "Home"), at(told_at)) == ["home", "not_home"]


def test_the_order_of_messages_outlives_a_new_announcement() -> None:
    convention = OwnTracks(OwnTracksSettings())
    (one,), (other,) = (convention.read_message(TOPIC, json.dumps(LOCATION).encode(), retained=False) for _ in "ab")
    assert one is other


def test_the_charge_of_the_phone_is_read() -> None:
    assert phone().parts[0].codec.read(TOPIC, json.dumps(LOCATION).encode(), retained=False)["battery"] == 76.0


def test_encrypted_messages_are_named() -> None:
    convention = OwnTracks(OwnTracksSettings())
    assert convention.read_message(TOPIC, b'{"_type": "encrypted", "data": "AAEC"}', retained=True) == ()
    assert convention.problems() == (f"{TOPIC} is encrypted; remove the key in the app, and use TLS",)
    convention.read_message(TOPIC, json.dumps(LOCATION).encode(), retained=False)
    assert convention.problems() == ()


@given(st.binary(max_size=60))
def test_any_payload_is_read_or_refused(payload: bytes) -> None:
    convention = OwnTracks(OwnTracksSettings())
    try:
        convention.read_message(TOPIC, payload, retained=False)
    except WireError:
        assert convention.rejected == 1
