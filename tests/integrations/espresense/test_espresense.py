"""Phones that the nodes of ESPresense hear, by messages with the fields of its source."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.convention import ConventionSettings
from homebot.conventions.description import DeviceAnnounced
from homebot.errors import WireError
from homebot.integrations.espresense.formats import Espresense

HEARD = {
    "mac": "dd8800003777", "id": "phone:anna", "name": "Anna's phone", "rssi@1m": -59, "rssi": -81.10, "rxAdj": 0,
    "rssiVar": 7.42, "distance": 6.58, "var": 4.00, "int": 2028,
}  # fmt: skip


def told(convention: Espresense, room: str, message: object, device: str = "phone:anna") -> list[DeviceAnnounced]:
    topic = f"espresense/devices/{device}/{room}"
    found = convention.read_message(topic, json.dumps(message).encode(), retained=False)
    return [one for one in found if isinstance(one, DeviceAnnounced)]


@pytest.fixture
def convention() -> Espresense:
    return Espresense(ConventionSettings())


def test_a_named_device_is_a_tracker_that_is_at_home_while_it_is_heard(convention: Espresense) -> None:
    (found,) = told(convention, "kitchen", HEARD)
    part = found.parts[0]
    assert (found.name, part.part.service_type, part.part.tag) == ("Anna's phone", "x_tracker", "beacon")
    read = part.codec.read("espresense/devices/phone:anna/kitchen", json.dumps(HEARD).encode(), retained=False)
    assert read == {"place": "home"}
    assert [(one.capability, one.value) for one in part.expiries] == [("place", None)]


def test_each_room_that_hears_it_is_added_once(convention: Espresense) -> None:
    told(convention, "kitchen", HEARD)
    (found,) = told(convention, "hall", HEARD)
    assert found.parts[0].part.reads == ("espresense/devices/phone:anna/kitchen", "espresense/devices/phone:anna/hall")
    assert found.availability is not None
    assert found.availability.mode == "any"
    assert [one.topic for one in found.availability.sources] == [
        "espresense/rooms/kitchen/status",
        "espresense/rooms/hall/status",
    ]
    assert told(convention, "hall", HEARD) == []


@pytest.mark.parametrize(("device", "name"), [("apple:1005:9-24", {}), ("name:anna-s-phone", {"name": "Anna's phone"})])
def test_a_device_without_a_name_of_the_owners_is_a_neighbours(
    convention: Espresense, device: str, name: dict[str, str]
) -> None:
    assert told(convention, "kitchen", {"id": device, "rssi": -90, **name}, device) == []


def test_ten_thousand_devices_do_not_push_out_the_first(convention: Espresense) -> None:
    found = [told(convention, "kitchen", HEARD, f"tag:{number}") for number in range(10_000)]
    assert [bool(one) for one in found] == [True] * 200 + [False] * 9_800
    assert told(convention, "hall", HEARD, "tag:0") != []


@given(st.binary(max_size=60))
def test_any_payload_is_read_or_refused(payload: bytes) -> None:
    convention = Espresense(ConventionSettings())
    try:
        convention.read_message("espresense/devices/a/b", payload, retained=False)
    except WireError:
        assert convention.rejected == 1
