"""An approval belongs to an announced part as it was approved: what changes, and what joins, waits."""

from typing import Any

import pytest
from tests.discovery.announcements import announce, only_device, part_of, tell

from homebot.devices import Sighting
from homebot.devices.always_ask import always_asks, is_approved, waits_for_approval
from homebot.devices.part import Capability, CommandDescription
from homebot.discovery import DeviceIndex, OwnerFacts
from homebot.discovery.approvals import MAX_APPROVALS
from homebot.errors import RefusedError
from homebot.places import NO_PLACES

MAC = "mac:aabbccddeeff"


@pytest.fixture
def index() -> DeviceIndex:
    return DeviceIndex(forget_after=1000.0, owner=OwnerFacts("Home", NO_PLACES, 5.0))


@pytest.fixture
def lock() -> Sighting:
    bolt = part_of("door_lock", "lock", id="l", writes=("door/set",)).model_copy(update={"payloads": "as announced"})
    return announce("lock/door", bolt, ids=(MAC,), name="Door")


def changed(sighting: Sighting, **fields: Any) -> Sighting:
    """The announcement with other fields of its only part."""
    (part,) = sighting.parts
    return sighting.model_copy(update={"parts": (part.model_copy(update=fields),)})


def approved(index: DeviceIndex) -> list[str]:
    return [device.id for device in index.devices() if is_approved(device)]


def restored(index: DeviceIndex) -> DeviceIndex:
    """An index that read what another one wrote."""
    again = DeviceIndex(forget_after=1000.0, owner=OwnerFacts("Home", NO_PLACES, 5.0))
    again.owner.restore(index.owner.record())
    for device in index.devices():
        entry = index.entry(device.id)
        assert entry is not None
        again.restore(entry, 0.0)
    return again


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"payloads": "unlock sends LOCK"}, "the payloads of its commands changed"),
        ({"writes": ("garage/cmd/set",)}, "its commands go to garage/cmd/set instead of door/set"),
        ({"service_type": "closure"}, "its type is closure, it was door_lock"),
        (
            {"capabilities": tuple(Capability(name=name, settable=True) for name in ("lock", "movement"))},
            "it takes lock, movement instead of lock",
        ),
    ],
)
def test_an_approved_lock_that_is_announced_differently_waits_again_and_says_what_changed(
    index: DeviceIndex, lock: Sighting, fields: dict[str, Any], problem: str
) -> None:
    index.observe(lock)
    assert waits_for_approval(only_device(index))
    index.places.approve("door", 1.0)
    assert not waits_for_approval(only_device(index))
    index.observe(changed(lock, **fields), 2.0)
    device = only_device(index)
    assert waits_for_approval(device)
    assert not is_approved(device)
    assert [(one.value, one.convention, one.key) for one in device.facts if one.name == "changed_since_approval"] == [
        (problem, "owner", lock.key)
    ]
    assert index.places.approve("door", 3.0) == (f"{lock.key}: {problem}",)
    assert not waits_for_approval(only_device(index))


def test_an_approval_of_what_was_shown_is_refused_once_it_is_announced_otherwise(
    index: DeviceIndex, lock: Sighting
) -> None:
    index.observe(lock)
    shown = index.places.approval_digest("door")
    index.observe(changed(lock, payloads="unlock sends LOCK"), 1.0)
    with pytest.raises(RefusedError, match="it changed since it was shown; look at it again"):
        index.places.approve("door", 2.0, shown)
    assert waits_for_approval(only_device(index))
    index.observe(lock, 3.0)
    index.places.approve("door", 4.0, shown)
    assert not waits_for_approval(only_device(index))


def test_an_approved_lock_with_another_identifier_waits_again(index: DeviceIndex, lock: Sighting) -> None:
    index.observe(lock)
    index.places.approve("door", 1.0)
    index.observe(lock.model_copy(update={"identifiers": (MAC, "id:other")}), 2.0)
    assert waits_for_approval(only_device(index))
    index.observe(lock.model_copy(update={"name": "Front door", "area": "Hall", "why": "renamed"}), 3.0)
    assert not waits_for_approval(only_device(index))  # as it was approved, but for what people call it


def test_what_joins_an_approved_device_with_the_same_identifiers_is_not_approved(
    index: DeviceIndex, lock: Sighting
) -> None:
    index.observe(lock)
    index.places.approve("door", 1.0)
    joins = announce("lock/other", part_of("door_lock", "lock", id="o", writes=("garage/cmd/set",)), ids=(MAC,))
    index.observe(joins, 2.0)
    device = only_device(index)
    assert {one.id: [bool(route.approved) for route in one.routes] for one in device.parts} == {
        "l": [True],
        "o": [False],
    }
    assert waits_for_approval(device)
    again = restored(index)
    assert waits_for_approval(only_device(again))
    again.places.approve("door", 3.0)
    assert not waits_for_approval(only_device(again))


def test_what_joins_an_approved_device_neither_names_nor_places_it(index: DeviceIndex, lock: Sighting) -> None:
    """A right to the lock in the shed, or called so, would be one to this lock."""
    index.observe(lock)
    index.places.approve("door", 1.0)
    index.observe(announce("sensor/evil", part_of("x_sensor"), ids=(MAC,), name="Shed lock", area="Shed"), 2.0)
    assert (only_device(index).names, only_device(index).area) == (("Door",), "")
    index.places.disapprove("door")
    assert (only_device(index).names, only_device(index).area) == (("Door", "Shed lock"), "Shed")


@pytest.mark.parametrize("kind", ["light", "switch", "x_setting"])
@pytest.mark.parametrize("relay", [("door_lock", "lock", ""), ("switch", "on_off", "Gate")])
def test_what_joins_on_the_topic_of_a_lock_always_asks(
    index: DeviceIndex, kind: str, relay: tuple[str, str, str]
) -> None:
    """A lamp may send UNLOCK; one with a topic of its own sends nothing to the lock."""
    driven, capability, name = relay
    bolt = part_of(driven, capability, id="l", writes=("door/set",)).model_copy(update={"name": name})
    lamp = part_of(kind, "on_off", id="g", writes=("door/set",)).model_copy(update={"payloads": "as announced"})
    apart = part_of("light", "on_off", id="a", writes=("porch/set",))
    for key, part in (("lock/door", bolt), ("light/door", lamp), ("light/porch", apart)):
        index.observe(announce(key, part, ids=(MAC,), name="Box"))
    device = only_device(index)
    assert {part.id: always_asks(device, part) for part in device.parts} == {"l": True, "g": True, "a": False}


def test_a_further_route_to_an_approved_part_is_not_approved_and_reports_nothing(
    index: DeviceIndex, lock: Sighting
) -> None:
    """Told to lock a door that is said to be locked, homebot would send nothing."""
    index.observe(lock)
    index.places.approve("door", 1.0)
    twin = announce(
        "lock/twin", part_of("door_lock", "lock", id="l", writes=("door/set",)), ids=(MAC,), on=lock.announced_on
    )
    index.observe(twin, 2.0)
    (both,) = only_device(index).parts
    assert {route.key: bool(route.approved) for route in both.routes} == {lock.key: True, twin.key: False}
    index.report(tell(lock, "lock", "unlocked", part="l", at=10))
    index.report(tell(twin, "lock", "locked", part="l", at=20))
    assert [one.value.plain() for one in only_device(index).states] == ["unlocked"]
    index.observe(lock.model_copy(update={"identifiers": (MAC, "id:changed")}), 25.0)
    assert not is_approved(only_device(index))
    assert [one.value.plain() for one in only_device(index).states] == ["unlocked"]
    index.places.approve("door", 30.0)
    assert [one.value.plain() for one in only_device(index).states] == ["locked"]


def test_an_approval_survives_a_restart_and_is_taken_back(index: DeviceIndex, lock: Sighting) -> None:
    index.observe(lock)
    index.places.place("door", "Hall", 1.0)
    index.places.approve("door", 2.0)
    assert [(one.name, one.value, one.key) for one in only_device(index).facts if one.convention == "owner"] == [
        ("approved", "yes", "command"),
        ("area", "Hall", "command"),
    ]
    again = restored(index)
    assert approved(again) == ["door"]
    again.observe(changed(lock, payloads="swapped while it was off"), 11.0)
    assert approved(again) == []
    again.observe(lock, 12.0)
    assert approved(again) == ["door"]
    again.places.disapprove("door")
    again.places.disapprove("door")
    assert approved(again) == []
    assert only_device(again).area == "Hall"
    with pytest.raises(RefusedError, match="no device of that id"):
        again.places.approve("nobody", 3.0)


@pytest.fixture
def relock() -> Sighting:
    """Another announcement of the lock's device."""
    setting = part_of("x_setting", "on_off", id="r", writes=("door/relock/set",))
    return announce("switch/relock", setting, ids=(MAC,), name="Door")


def routes_approved(index: DeviceIndex) -> dict[str, list[bool]]:
    return {part.id: [bool(route.approved) for route in part.routes] for part in only_device(index).parts}


def test_what_was_away_at_the_last_approval_waits_alone(index: DeviceIndex, lock: Sighting, relock: Sighting) -> None:
    index.observe(lock)
    index.observe(relock)
    index.places.approve("door", 1.0)
    index.observe(relock.model_copy(update={"kind": "removed"}), 2.0)
    index.observe(changed(lock, payloads="new firmware"), 3.0)
    index.places.approve("door", 4.0)
    index.observe(relock, 5.0)
    assert routes_approved(index) == {"l": [True], "r": [False]}
    index.places.approve("door", 6.0)
    assert routes_approved(index) == {"l": [True], "r": [True]}


def test_an_approval_is_taken_back_from_what_is_away_too(index: DeviceIndex, lock: Sighting, relock: Sighting) -> None:
    index.observe(lock)
    index.observe(relock)
    index.places.approve("door", 1.0)
    index.observe(lock.model_copy(update={"kind": "removed"}), 2.0)
    index.places.disapprove("door")
    index.observe(lock, 3.0)
    assert routes_approved(index) == {"l": [False], "r": [False]}


def test_another_device_that_comes_with_the_same_id_is_not_approved(index: DeviceIndex, lock: Sighting) -> None:
    index.observe(lock)
    index.places.approve("door", 2.0)
    index.forget("door", 3.0)
    index.observe(lock.model_copy(update={"key": "homeassistant:new", "confirmed": True}), 4.0)
    assert only_device(index).id == "door"
    assert approved(index) == []
    index.places.approve("door", 5.0)
    assert approved(restored(index)) == ["door"]


def test_an_approval_returns_to_its_own_after_a_merge_and_a_split(index: DeviceIndex, lock: Sighting) -> None:
    index.observe(lock)
    index.observe(
        announce("lock/gate", part_of("door_lock", "lock", id="g", writes=("gate/set",)), ids=(), name="Gate")
    )
    index.places.approve("door", 1.0)
    index.merge(("door", "gate"), 2.0)
    assert approved(index) == ["door"]
    assert waits_for_approval(only_device(index))
    index.split("door", None, 3.0)
    assert approved(index) == ["door"]
    index.merge(("door", "gate"), 4.0)
    index.places.approve("door", 4.0)
    index.split("door", None, 5.0)
    assert approved(index) == ["door", "gate"]
    index.merge(("door", "gate"), 6.0)
    index.places.disapprove("door")
    index.split("door", None, 7.0)
    assert approved(index) == []


def test_two_approved_devices_that_an_announcement_makes_one_wait_again(index: DeviceIndex, lock: Sighting) -> None:
    """A program with a right to the lock of the shed would have one to the front door."""
    shed = part_of("door_lock", "lock", id="s", writes=("shed/set",))
    index.observe(lock)
    index.observe(announce("lock/shed", shed, ids=("id:shed17",), name="Shed lock"))
    index.places.approve("door", 1.0)
    index.places.approve("shed_lock", 2.0)
    index.observe(announce("sensor/evil", part_of("x_sensor"), ids=(MAC, "id:shed17")), 3.0)
    assert len(only_device(index).parts) == 3
    assert not is_approved(only_device(index))
    assert waits_for_approval(only_device(index))
    index.places.approve(only_device(index).id, 4.0)
    assert is_approved(only_device(index))


def test_approvals_are_bounded(lock: Sighting) -> None:
    owner = OwnerFacts("Home", NO_PLACES, 5.0)
    some = CommandDescription("", (), (), (), "")
    owner.approvals.restore([("mqtt", f"other{number}", "", some, 1.0) for number in range(MAX_APPROVALS - 1)])
    index = DeviceIndex(forget_after=1000.0, owner=owner)
    index.observe(lock)
    other = changed(lock, writes=("other/set",))
    index.observe(other.model_copy(update={"key": "homeassistant:other", "identifiers": (), "name": "Other"}))
    index.places.approve("door", 1.0)
    with pytest.raises(RefusedError, match="there are 10,000 already"):
        index.places.approve("other", 2.0)
    assert approved(index) == ["door"]


def test_a_places_file_has_no_approvals(index: DeviceIndex, lock: Sighting) -> None:
    index.observe(lock)
    before = exported(index)
    index.places.approve("door", 1.0)
    assert exported(index) == before


def exported(index: DeviceIndex) -> str:
    work = index.places_exchange.export_text()
    while True:
        try:
            next(work)
        except StopIteration as done:
            return str(done.value)
