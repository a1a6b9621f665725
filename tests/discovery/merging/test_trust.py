"""A stranger who announces a known identifier is listed with the device, and does not get its commands."""

from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import sighting_of
from tests.discovery.announcements import only_device

from homebot.devices import Sighting
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue, Reading, Value
from homebot.discovery import DeviceIndex
from homebot.discovery.merging.trust import MAX_TRUSTED, WINDOW, Agreement
from homebot.discovery.record import entry_record, read_entry, read_tombstone, tombstone_record
from homebot.errors import RefusedError
from homebot.messages import Time

MAC = "mac:aabbccddeeff"
TRUE, STRANGER = ("cable", "lamp"), ("air", "evil")


def sighting(
    endpoint: tuple[str, str],
    service_type: str = "light",
    *capabilities: str,
    kind: Literal["appeared", "updated", "removed"] = "updated",
    identifiers: tuple[str, ...] = (MAC,),
    authenticated: bool = False,
    settable: bool = True,
    at: float = 0.0,
) -> Sighting:
    gateway, key = endpoint
    names = capabilities or ("lock" if service_type == "door_lock" else "on_off",)
    part = Part(
        id="p", service_type=service_type, capabilities=tuple(Capability(name=one, settable=settable) for one in names)
    )
    return sighting_of(
        key,
        part,
        gateway=gateway,
        kind=kind,
        name=f"{gateway} {key}",
        native=gateway == "air",
        identifiers=identifiers,
        authenticated=authenticated,
        area="Cellar" if gateway == "air" else "Hall",
        at=at,
    )


def report(endpoint: tuple[str, str], value: PlainValue, at: float, capability: str = "on_off") -> Report:
    gateway, key = endpoint
    part = "" if capability == REACHABLE else "p"
    return Report(
        gateway=gateway,
        key=key,
        readings=(Reading(part=part, capability=capability, value=Value.of(value)),),
        address="said",
        stream=key,
        retained=False,
        received_at=Time.from_seconds(at),
    )


def observe(index: DeviceIndex, *sightings: Sighting, at: float = 0.0) -> None:
    for one in sightings:
        index.observe(one, at)


def routes(index: DeviceIndex) -> list[tuple[str, str]]:
    """Return the endpoints that get the commands of any part of any device."""
    return [(route.gateway, route.key) for device in index.devices() for part in device.parts for route in part.routes]


def change(index: DeviceIndex, value: PlainValue, at: float, *endpoints: tuple[str, str]) -> None:
    for one in endpoints:
        index.report(report(one, value, at), at)


def test_a_stranger_is_listed_and_gets_no_commands(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    device = only_device(index)
    assert [(one.gateway, one.claimed) for one in device.endpoints] == [("cable", False), ("air", True)]
    assert routes(index) == [TRUE]
    assert (device.name, device.area) == ("cable lamp", "Hall")
    assert any("evil on air only claims to be it, and gets no commands yet" in one for one in device.evidence)
    assert device.conflicts == ()


def test_nor_while_the_true_one_is_unreachable(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    index.report(report(TRUE, False, 1.0, REACHABLE), 1.0)
    index.report(report(STRANGER, True, 2.0, REACHABLE), 2.0)
    assert routes(index) == [TRUE]
    assert only_device(index).reachable.state == "no", "the stranger's word does not make it reachable"
    assert only_device(index).endpoints[0].gateway == "cable"


def test_what_a_stranger_reports_does_not_count_beside_what_the_device_is(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(STRANGER, "door_lock"))
    index.changes.collects_states = True
    index.report(report(TRUE, "unlocked", 1.0, "lock"), 1.0)
    index.pop_changes()
    index.pop_states()
    index.report(report(STRANGER, "locked", 2.0, "lock"), 2.0)
    assert [one.value.plain() for one in only_device(index).states] == ["unlocked"]
    assert index.pop_states() == ()


def test_a_stranger_does_not_say_what_the_device_is(index: DeviceIndex) -> None:
    """A plug stays one that takes texts, and is found as a plug, whatever else somebody says that it is."""
    observe(index, sighting(TRUE, "plug"))
    (alone,) = index.devices()
    nowhere = sighting(STRANGER, "light", "on_off", "level", identifiers=(MAC, "mac:000000000001"))
    observe(index, nowhere)
    device = only_device(index)
    shown = [(one.name, one.names, one.area, one.service_type, one.service_types) for one in (alone, device)]
    assert shown[0] == shown[1]
    assert device.endpoints[0].command_address == alone.endpoints[0].command_address != ""
    assert [part.part.service_type for part in device.parts] == ["plug", "light"], "it is shown"
    assert device.parts[1].routes == ()


def test_a_stranger_does_not_keep_two_true_announcements_from_being_one(index: DeviceIndex) -> None:
    """Three lamps with one name fit each other equally well; the two of trusted endpoints are matched first."""
    observe(index, sighting(TRUE), sighting(("radio", "lamp"), authenticated=True))
    assert len(only_device(index).parts) == 1
    lamp = sighting(("radio", "evil")).parts[0]
    evil = sighting(("radio", "evil")).model_copy(update={"parts": (lamp.model_copy(update={"id": "q"}),)})
    observe(index, evil)
    assert len(only_device(index).parts[0].routes) == 2


def test_a_stranger_in_the_same_gateway_is_one_as_well(index: DeviceIndex) -> None:
    """Two services on one network: what the gateway calls them is all that tells them apart."""
    true, stranger = ("air", "lamp"), ("air", "evil")
    observe(index, sighting(true), sighting(stranger))
    assert routes(index) == [true]


def test_of_a_gateway_whose_addresses_belong_to_devices_all_announcements_are_one_endpoint(index: DeviceIndex) -> None:
    """Whose an address is there follows from where it was announced."""
    with_address = [
        one.model_copy(update={"announced_on": f"homeassistant/light/{one.key}/config"})
        for one in (sighting(("mqtt", "a")), sighting(("mqtt", "b")))
    ]
    observe(index, *with_address)
    assert routes(index) == [("mqtt", "a"), ("mqtt", "b")]


def test_sensors_need_no_trust_and_make_none(index: DeviceIndex) -> None:
    """A thermometer that was heard first does not keep the lamp with it from being used."""
    sensor = sighting(("ble", "t"), "temperature_sensor", "temperature", settable=False)
    observe(index, sensor, sighting(TRUE))
    assert routes(index)[-1] == TRUE
    assert not any(one.claimed for one in only_device(index).endpoints)


def test_one_that_proves_who_it_is_gets_commands_at_once(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(("air", "lock"), "door_lock", authenticated=True))
    assert sorted(routes(index)) == [("air", "lock"), TRUE]


def test_one_that_reports_the_same_changes_becomes_a_fallback(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    change(index, False, 0.0, TRUE, STRANGER)
    for number in range(1, 4):
        index.pop_changes()
        assert routes(index) == [TRUE]
        change(index, number % 2 == 1, number * 60.0, *((TRUE, STRANGER) if number % 2 else (STRANGER, TRUE)))
    assert sorted(routes(index)) == [STRANGER, TRUE]
    *_, last = index.pop_changes()
    assert (last.kind, last.why) == ("changed", "air reported the same changes as its other endpoints")


def test_one_that_misses_a_change_begins_anew(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    change(index, False, 0.0, TRUE, STRANGER)
    for number in range(1, 30):
        both = (TRUE,) if number % 3 == 0 else (TRUE, STRANGER)
        change(index, number % 2 == 1, number * 60.0, *both)
    assert routes(index) == [TRUE]


def test_one_that_changes_all_the_time_is_not_believed_when_it_is_right(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    for second in range(600):
        change(index, second % 2 == 1, float(second), STRANGER)
        if second % 50 == 0:
            change(index, second % 100 == 0, second + 0.5, TRUE)
    assert routes(index) == [TRUE]


def test_one_burst_of_equal_changes_counts_once(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    change(index, False, 0.0, TRUE, STRANGER)
    for number in range(1, 20):
        change(index, number % 2 == 1, 100.0 + number * WINDOW / 20, TRUE, STRANGER)
    assert routes(index) == [TRUE]


def test_what_can_hurt_is_not_given_to_one_that_only_reports_the_same(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(STRANGER, "door_lock"))
    for number in range(10):
        for one in (TRUE, STRANGER):
            index.report(report(one, ("locked", "unlocked")[number % 2], number * 60.0, "lock"), number * 60.0)
    assert routes(index) == [TRUE]


def test_the_owner_confirms_it(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(STRANGER, "door_lock"))
    device = only_device(index)
    assert index.merge([device.id], 1.0) == device.id
    assert sorted(routes(index)) == [STRANGER, TRUE]
    with pytest.raises(RefusedError, match="it takes two different devices"):
        index.merge([device.id], 2.0)


def test_two_devices_that_the_owner_merges_have_the_endpoints_of_both(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(STRANGER, "door_lock", identifiers=("mac:000000000001",)))
    index.merge([one.id for one in index.devices()], 1.0)
    assert sorted(routes(index)) == [STRANGER, TRUE]


def test_a_split_makes_a_device_of_its_own_that_gets_its_own_commands(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER))
    index.split(only_device(index).id, STRANGER, 1.0)
    assert len(index.devices()) == 2
    assert sorted(routes(index)) == [STRANGER, TRUE]


def test_two_that_become_one_later_trust_the_older_one(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER, identifiers=("mac:000000000001",)))
    assert len(index.devices()) == 2
    observe(index, sighting(STRANGER, identifiers=("mac:000000000001", MAC)))
    assert routes(index) == [TRUE]


def test_a_lamp_whose_only_endpoint_is_a_claimed_one_can_be_used(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE), sighting(STRANGER), sighting(TRUE, kind="removed"))
    assert routes(index) == [STRANGER]
    observe(index, sighting(TRUE))
    assert routes(index) == [TRUE], "and the known one is trusted again at once"


def test_a_lock_whose_only_endpoint_is_a_claimed_one_says_why_it_cannot(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(STRANGER, "door_lock"))
    observe(index, sighting(TRUE, "door_lock", kind="removed"))
    assert routes(index) == []
    assert only_device(index).conflicts == (
        "evil on air only claims to be this device, and gets no commands; confirm it with `homebot merge` and the name "
        "of the device, or undo it with `homebot split`",
    )


def test_a_lock_that_went_is_not_brought_back_by_a_stranger(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"))
    device_id = only_device(index).id
    observe(index, sighting(TRUE, "door_lock", kind="removed"), sighting(STRANGER, "door_lock"))
    assert (only_device(index).id, routes(index)) == (device_id, [])
    observe(index, sighting(TRUE, "door_lock"))
    assert routes(index) == [TRUE]


def test_trust_is_remembered_over_a_restart(index: DeviceIndex) -> None:
    observe(index, sighting(TRUE, "door_lock"), sighting(STRANGER, "door_lock"), sighting(TRUE, kind="removed"))
    entry = index.entry(only_device(index).id)
    assert entry is not None
    again = DeviceIndex(forget_after=1000.0)
    again.restore(read_entry(entry.id, entry_record(entry)), 0.0)
    observe(again, sighting(STRANGER, "door_lock"))
    assert routes(again) == []
    observe(again, sighting(STRANGER, kind="removed"))
    (stone,) = again.tombstones
    assert read_tombstone(stone.id, tombstone_record(stone)).trusted == (TRUE,)


def test_endpoints_that_are_remembered_are_bounded(index: DeviceIndex) -> None:
    everywhere = [sighting(("air", str(number)), authenticated=True) for number in range(MAX_TRUSTED + 10)]
    observe(index, *everywhere)
    entry = index.entry(only_device(index).id)
    assert entry is not None
    assert len(entry.trusted) <= MAX_TRUSTED


def test_changes_that_wait_are_bounded() -> None:
    agreement = Agreement()
    for number in range(1000):
        assert not agreement.record((number, "value", "x"), STRANGER, [STRANGER], 0.0)
    assert len(agreement._lately) == 32


Step = tuple[str, int, int]
steps = st.lists(
    st.tuples(
        st.sampled_from(["announce", "remove", "report", "offline", "online", "wait"]),
        st.integers(0, 4),
        st.integers(0, 1),
    ),
    max_size=60,
)
ENDPOINTS = [TRUE, STRANGER, ("air", "evil 2"), ("cable", "evil 3"), ("radio", "evil 4")]


def play(index: DeviceIndex, service_type: str, step: Step, now: float, *, may_report: range) -> None:
    what, number, value = step
    endpoint = ENDPOINTS[number]
    if what in {"announce", "remove"}:
        index.observe(sighting(endpoint, service_type, kind="removed" if what == "remove" else "updated", at=now), now)
    elif what == "wait":
        index.expire(now)
    elif what in {"offline", "online"}:
        index.report(report(endpoint, what == "online", now, REACHABLE), now)
    elif number in may_report:
        said: PlainValue = ("locked", "unlocked")[value] if service_type == "door_lock" else bool(value)
        index.report(report(endpoint, said, now, "lock" if service_type == "door_lock" else "on_off"), now)


@given(steps)
def test_whatever_strangers_do_a_lock_is_commanded_where_it_was_first_known(taken: list[Step]) -> None:
    index = DeviceIndex(forget_after=1e9)
    index.observe(sighting(TRUE, "door_lock"), 0.0)
    for number, step in enumerate(taken):
        play(index, "door_lock", step, number * 20.0, may_report=range(5))
        if number % 7 == 6:
            restarted = DeviceIndex(forget_after=1e9)
            for one in index.tombstones:
                restarted.tombstones.put(read_tombstone(one.id, tombstone_record(one)))
            for device in index.devices():
                entry = index.entry(device.id)
                assert entry is not None
                restarted.restore(read_entry(entry.id, entry_record(entry)), number * 20.0)
            index = restarted
        assert set(routes(index)) <= {TRUE}


@given(steps)
def test_whatever_strangers_do_a_lamp_that_is_there_is_commanded_where_it_was_first_known(taken: list[Step]) -> None:
    """As long as it does not change itself, so that nobody can be right about that."""
    index = DeviceIndex(forget_after=1e9)
    index.observe(sighting(TRUE), 0.0)
    for number, step in enumerate(taken):
        play(index, "light", step, number * 20.0, may_report=range(1, 5))
        there = {(one.gateway, one.key) for device in index.devices() for one in device.endpoints}
        if TRUE in there:
            assert set(routes(index)) == {TRUE}
