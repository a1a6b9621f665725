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
        ({"_type": "location", "lat": 1.0, "lon": 2.0, "tst": 1}, None),
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


def test_the_charge_of_the_phone_is_read() -> None:
    assert phone().parts[0].codec.read(TOPIC, json.dumps(LOCATION).encode(), retained=False)["battery"] == 76.0


def test_encrypted_messages_are_named() -> None:
    convention = OwnTracks(OwnTracksSettings())
    assert convention.read_message(TOPIC, b'{"_type": "encrypted", "data": "AAEC"}', retained=True) == ()
    assert convention.problems() == (f"{TOPIC} is encrypted; remove the key in the app, and use TLS",)


@given(st.binary(max_size=60))
def test_any_payload_is_read_or_refused(payload: bytes) -> None:
    convention = OwnTracks(OwnTracksSettings())
    try:
        convention.read_message(TOPIC, payload, retained=False)
    except WireError:
        assert convention.rejected == 1
