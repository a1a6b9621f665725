"""The owner says which announcements are one device: that outranks the evidence, and is remembered."""

from itertools import permutations

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.devices import Device, Sighting
from homebot.discovery import DeviceIndex
from homebot.discovery.merging.decisions import MAX_DECISIONS, MergeDecisions
from homebot.errors import RefusedError, WireError

MAC = "mac:aabbccddeeff"
SERIAL = "id:SN-4711-0815"


LAMP = part_of("light", "on_off", id="l")
THREE_WAYS = (
    announce("a", LAMP, ids=(MAC,), gateway="radio", name="Radio"),
    announce("b", LAMP, ids=(MAC, SERIAL), gateway="cable", name="Cable"),
    announce("c", LAMP, ids=(SERIAL,), gateway="web", name="Web"),
)
"""One lamp over three gateways: two name its hardware address, two its serial number."""


def after(index: DeviceIndex, *sightings: Sighting) -> dict[str, list[str]]:
    """Return the gateways of each device."""
    for one in sightings:
        index.observe(one, 0.0)
    return gateways(index.devices())


def gateways(devices: tuple[Device, ...]) -> dict[str, list[str]]:
    return {device.id: sorted(one.gateway for one in device.endpoints) for device in devices}


def test_a_device_that_is_split_is_one_for_each_that_it_was_said_to_be(index: DeviceIndex) -> None:
    assert after(index, *THREE_WAYS) == {"radio": ["cable", "radio", "web"]}
    index.pop_changes()
    assert index.split("radio", None, 1.0) == ("radio", "cable", "web")
    assert gateways(index.devices()) == {"radio": ["radio"], "cable": ["cable"], "web": ["web"]}
    unmerged = {one.other for one in index.pop_changes() if one.kind == "unmerged"}
    assert unmerged <= {"cable", "web"}


def test_one_announcement_is_split_off_and_the_others_stay_one(index: DeviceIndex) -> None:
    after(index, *THREE_WAYS)
    index.split("radio", ("cable", "homeassistant:b"), 1.0)
    assert sorted(gateways(index.devices()).values()) == [["cable"], ["radio", "web"]]


@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_a_split_holds_in_whatever_order_they_are_announced_again(order: tuple[int, ...], index: DeviceIndex) -> None:
    after(index, *THREE_WAYS)
    index.split("radio", None, 1.0)
    for one in THREE_WAYS:
        index.observe(one.model_copy(update={"kind": "removed"}), 2.0)
    assert index.devices() == ()
    found = after(index, *(THREE_WAYS[number] for number in order))
    assert sorted(found.values()) == [["cable"], ["radio"], ["web"]]


def test_what_was_split_can_be_merged_again_and_split_again(index: DeviceIndex) -> None:
    after(index, *THREE_WAYS)
    index.split("radio", None, 1.0)
    assert index.merge(("web", "radio"), 2.0) == "radio"
    assert gateways(index.devices()) == {"radio": ["radio", "web"], "cable": ["cable"]}
    index.split("radio", None, 3.0)
    assert sorted(gateways(index.devices()).values()) == [["cable"], ["radio"], ["web"]]


def test_devices_without_anything_in_common_are_merged_with_the_reason(index: DeviceIndex) -> None:
    after(
        index, announce("a", part_of("light", "on_off"), name="A"), announce("b", part_of("light", "on_off"), name="B")
    )
    index.pop_changes()
    index.merge(("homeassistant:a", "homeassistant:b") if index.get("homeassistant:a") else ("a", "b"), 1.0)
    (device,) = index.devices()
    assert device.evidence == ("the owner merged homeassistant:a and homeassistant:b",)


def test_they_outlast_a_restart(index: DeviceIndex) -> None:
    after(index, *THREE_WAYS)
    index.split("radio", None, 1.0)
    index.merge(("web", "radio"), 2.0)
    restarted = DeviceIndex(forget_after=1000.0)
    restarted.decisions.restore(index.decisions.record())
    assert sorted(after(restarted, *THREE_WAYS).values()) == [["cable"], ["radio", "web"]]


def test_a_device_of_one_announcement_cannot_be_split(index: DeviceIndex) -> None:
    after(index, THREE_WAYS[0])
    with pytest.raises(RefusedError, match="nothing was merged into it"):
        index.split("radio", None, 1.0)


def test_an_announcement_that_is_not_there_is_answered_with_those_that_are(index: DeviceIndex) -> None:
    after(index, *THREE_WAYS)
    with pytest.raises(RefusedError, match="it has no announcement cable x; it has radio homeassistant:a, cable"):
        index.split("radio", ("cable", "x"), 1.0)


def test_a_merge_takes_two_devices_that_are_there(index: DeviceIndex) -> None:
    after(index, *THREE_WAYS)
    with pytest.raises(RefusedError, match="two different devices"):
        index.merge(("radio", "radio"), 1.0)
    with pytest.raises(RefusedError, match="a change of 'attic' was refused: there is no device of that id"):
        index.merge(("radio", "attic"), 1.0)


def test_too_many_are_refused_and_nothing_is_changed() -> None:
    made = MergeDecisions()
    made.merge([("b", str(number)) for number in range(MAX_DECISIONS - 1)])
    before = made.record()
    with pytest.raises(RefusedError, match="there are 10,000 decisions already"):
        made.merge([("a", "3"), ("a", "4")])
    with pytest.raises(RefusedError):
        made.split([f"id:{number}" for number in range(MAX_DECISIONS + 1)], [])
    assert made.record() == before


def test_a_damaged_record_is_no_decision() -> None:
    made = MergeDecisions()
    with pytest.raises(WireError):
        made.restore('{"ignored": 5}')
    assert made.record() == MergeDecisions().record()
