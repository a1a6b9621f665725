"""An identifier that two devices claim, which their gateway knows apart, identifies neither of them."""

from itertools import permutations

import pytest
from tests.discovery.announcements import announce

from homebot.devices import Sighting
from homebot.devices.part import Capability, Part
from homebot.discovery import DeviceIndex

SERIAL = "id:AB-4711-77"


def seen(gateway: str, key: str, *ids: str, whole: bool = True) -> Sighting:
    lock = Part(id="1", service_type="door_lock", capabilities=(Capability(name="lock", settable=True),))
    found = announce(key, lock, convention="", ids=ids, name=key, gateway=gateway, on="")
    return found.model_copy(update={"whole_device": whole})


def devices(index: DeviceIndex) -> list[set[str]]:
    found = (entry for one in index.ids if (entry := index.entry(one)) is not None)
    return sorted(({key.removeprefix(":") for _, key in entry.sources} for entry in found), key=sorted)


@pytest.mark.parametrize("identifier", [SERIAL, "eui64:00158d0001abcdef", "mac:001788a1b2c3"])
def test_what_two_devices_of_one_gateway_claim_joins_nothing_in_whatever_order_they_come(identifier: str) -> None:
    front, back = seen("matter", "node-1", identifier, "id:place 1"), seen("matter", "node-2", identifier, "id:place 2")
    other = seen("home", "front", identifier, "id:place 1", whole=False)
    for order in permutations((front, back, other)):
        index = DeviceIndex(forget_after=1000.0)
        for sighting in order:
            index.observe(sighting)
        assert devices(index) == [{"front", "node-1"}, {"node-2"}]


def test_a_third_that_has_something_of_both_joins_neither_and_goes_with_the_one_that_stays() -> None:
    """Home Assistant makes one device of two nodes with the same serial number."""
    nodes = seen("matter", "node-1", SERIAL, "id:place 1"), seen("matter", "node-2", SERIAL, "id:place 2")
    both = seen("home", "both", SERIAL, "id:place 1", "id:place 2", whole=False)
    for order in permutations((*nodes, both)):
        index = DeviceIndex(forget_after=1000.0)
        for sighting in order:
            index.observe(sighting)
        assert devices(index) == [{"both"}, {"node-1"}, {"node-2"}]
        index.observe(nodes[1].model_copy(update={"kind": "removed"}))
        assert devices(index) == [{"both", "node-1"}]


def test_both_say_that_an_identifier_is_no_evidence_until_one_is_gone() -> None:
    index = DeviceIndex(forget_after=1000.0)
    front, back = seen("matter", "node-1", SERIAL), seen("matter", "node-2", SERIAL)
    index.observe(front)
    (first,) = index.devices()
    assert first.conflicts == ()
    index.observe(back)
    for device in index.devices():
        (conflict,) = device.conflicts
        assert conflict.endswith(f"on matter claim the same {SERIAL}, which identifies neither")
    index.observe(back.model_copy(update={"kind": "removed"}))
    (first,) = index.devices()
    assert first.conflicts == ()


def test_the_approval_of_a_lock_is_none_of_one_with_its_serial_number_whenever_that_comes() -> None:
    index = DeviceIndex(forget_after=1000.0)
    index.observe(seen("matter", "node-1", SERIAL))
    index.places.approve(index.ids[0], 1.0)
    index.observe(seen("matter", "node-2", SERIAL))
    rights = {device.endpoints[0].key: bool(device.parts[0].routes[0].approved) for device in index.devices()}
    assert rights == {":node-1": True, ":node-2": False}


def test_an_owner_may_still_merge_them() -> None:
    index = DeviceIndex(forget_after=1000.0)
    for key in ("node-1", "node-2"):
        index.observe(seen("matter", key, SERIAL))
    index.merge(index.ids, 1.0)
    assert devices(index) == [{"node-1", "node-2"}]
