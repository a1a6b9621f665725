"""The index is pure: sightings and readings of a clock go in, changes come out."""

from typing import Literal

import pytest
from tests.announcements import sighting_of

from homebot.devices import DeviceChange, KeyValue, Sighting, StateChange
from homebot.devices.gateway_messages import Report
from homebot.devices.part import Capability, Part
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex
from homebot.messages import Time

FORGET_AFTER = 1000.0
EXPIRES_AFTER = 60.0


def sighting(
    key: str = "lights/lamp1",
    *,
    kind: Literal["appeared", "updated", "removed"] = "appeared",
    at: float = 0.0,
    gateway: str = "mqtt",
    confirmed: bool = True,
    name: str = "lamp1",
) -> Sighting:
    return sighting_of(
        key,
        gateway=gateway,
        kind=kind,
        name=name,
        service_type=key.partition("/")[0],
        address=f"home/{key}/out",
        command_address=f"home/{key}/in",
        confirmed=confirmed,
        at=at,
        lasts=EXPIRES_AFTER,
    )


def observe(index: DeviceIndex, one: Sighting) -> DeviceChange | None:
    """Take a sighting in and return what it changes."""
    index.observe(one)
    changes = index.pop_changes()
    assert len(changes) <= 1
    return changes[0] if changes else None


def expire(index: DeviceIndex, now: float, at_most: int | None = None) -> tuple[DeviceChange, ...]:
    """Return what the passing of time changes."""
    index.expire(now, at_most)
    return index.pop_changes()


@pytest.fixture
def index() -> DeviceIndex:
    return DeviceIndex(forget_after=FORGET_AFTER)


def test_a_first_sighting_makes_a_device_appear(index: DeviceIndex) -> None:
    """The device carries what the sighting said, and both times are that of the sighting."""
    change = observe(index, sighting(at=5))

    assert change is not None
    assert (change.kind, change.device.id, change.device.service_type) == ("appeared", "lights/lamp1", "lights")
    assert change.device.endpoints[0].address == "home/lights/lamp1/out"
    assert change.device.first_seen == change.device.last_seen == Time.from_seconds(5)


def test_a_second_sighting_of_the_same_device_says_nothing_new_but_moves_last_seen(index: DeviceIndex) -> None:
    """Every message of a device is no event."""
    observe(index, sighting(at=0))

    assert observe(index, sighting(kind="updated", at=7)) is None
    (device,) = index.devices()
    assert device.first_seen.sec == 0
    assert device.last_seen.sec == 7


def test_many_devices_of_one_type_are_all_kept(index: DeviceIndex) -> None:
    """The thesis stored None when a second device of a type appeared."""
    for number in range(50):
        observe(index, sighting(f"lights/lamp{number:02}"))
    observe(index, sighting("windows/motor"))

    lights = index.devices("lights")
    assert [device.id for device in lights] == [f"lights/lamp{number:02}" for number in range(50)]
    assert len(index) == 51


def test_a_changed_description_is_a_change(index: DeviceIndex) -> None:
    """A device that is called something else now is the same device."""
    observe(index, sighting())
    change = observe(index, sighting(kind="updated", name="reading lamp"))

    assert change is not None
    assert (change.kind, change.device.id, change.device.name) == ("changed", "lights/lamp1", "reading lamp")


def test_a_removed_device_is_gone_and_can_appear_again(index: DeviceIndex) -> None:
    """Removal is no death sentence."""
    observe(index, sighting())
    removed = observe(index, sighting(kind="removed"))
    again = observe(index, sighting(at=9))

    assert removed is not None
    assert removed.kind == "removed"
    assert again is not None
    assert (again.kind, again.device.first_seen.sec) == ("appeared", 0)


def test_removing_what_was_never_seen_changes_nothing(index: DeviceIndex) -> None:
    """A gateway may say more than the index knows."""
    assert observe(index, sighting(kind="removed")) is None


def test_a_silent_device_becomes_stale_once_and_is_forgotten_later(index: DeviceIndex) -> None:
    """At exactly its expiry, and exactly `forget_after` later."""
    observe(index, sighting())

    assert expire(index, EXPIRES_AFTER - 0.001) == ()
    assert [change.kind for change in expire(index, EXPIRES_AFTER)] == ["stale"]
    assert expire(index, EXPIRES_AFTER + 1) == ()
    assert [change.kind for change in expire(index, EXPIRES_AFTER + FORGET_AFTER)] == ["removed"]
    assert len(index) == 0


def test_a_long_jump_of_the_clock_makes_stale_and_forgets_in_one_go(index: DeviceIndex) -> None:
    """Both are announced, in order."""
    observe(index, sighting())
    assert [change.kind for change in expire(index, 10_000)] == ["stale", "removed"]


def test_a_stale_device_that_speaks_returns(index: DeviceIndex) -> None:
    """It is the same device with its old first_seen."""
    observe(index, sighting())
    expire(index, EXPIRES_AFTER)
    change = observe(index, sighting(kind="updated", at=100))

    assert change is not None
    assert (change.kind, change.device.freshness, change.device.first_seen.sec) == ("returned", "fresh", 0)


def test_a_retained_message_alone_leaves_a_device_unconfirmed(index: DeviceIndex) -> None:
    """It may be a ghost; its own word confirms it."""
    ghost = observe(index, sighting(confirmed=False))
    alive = observe(index, sighting(kind="updated", at=3))

    assert ghost is not None
    assert ghost.device.freshness == "unconfirmed"
    assert alive is not None
    assert (alive.kind, alive.device.freshness) == ("changed", "fresh")


def test_a_retained_message_does_not_refresh_a_device_that_has_spoken(index: DeviceIndex) -> None:
    """What the broker repeats after a reconnect is old news: last_seen and expiry stay."""
    observe(index, sighting(at=0))
    assert observe(index, sighting(kind="updated", at=50, confirmed=False)) is None

    (device,) = index.devices()
    assert (device.last_seen.sec, device.freshness, device.expires.sec) == (0, "fresh", 60)


def test_the_same_key_at_two_gateways_is_two_devices(index: DeviceIndex) -> None:
    """A key is unique at its gateway only."""
    observe(index, sighting(gateway="mqtt"))
    observe(index, sighting(gateway="garage"))

    assert [device.id for device in index.devices()] == ["lights/lamp1", "lights/lamp1@garage"]


def test_the_next_deadline_is_the_earliest_of_all_devices(index: DeviceIndex) -> None:
    """None when there is nothing to wait for."""
    assert index.next_deadline() is None
    observe(index, sighting("lights/a", at=0))
    observe(index, sighting("lights/b", at=10))
    assert index.next_deadline() == EXPIRES_AFTER
    expire(index, EXPIRES_AFTER)
    assert index.next_deadline() == EXPIRES_AFTER + 10


def test_sequences_grow_with_every_change_and_start_where_they_are_told() -> None:
    """A restarted directory goes on above the numbers of the one before."""
    index = DeviceIndex(forget_after=1, first_sequence=100)
    first = observe(index, sighting("lights/a"))
    second = observe(index, sighting("lights/b"))

    assert first is not None
    assert second is not None
    assert (first.sequence, second.sequence, index.sequence) == (100, 101, 101)


def test_an_id_is_never_given_twice(index: DeviceIndex) -> None:
    """Not even when a device is called what another one's id was made of."""
    observe(index, sighting("lights/a@garage", gateway="mqtt"))
    observe(index, sighting("lights/a", gateway="mqtt"))
    observe(index, sighting("lights/a", gateway="garage"))

    assert [device.id for device in index.devices()] == ["lights/a", "lights/a@garage", "lights/a@garage@garage"]
    removed = observe(index, sighting("lights/a", gateway="garage", kind="removed"))
    assert removed is not None
    assert removed.device.id == "lights/a@garage@garage"


def test_what_the_passing_of_time_changes_can_be_taken_in_portions(index: DeviceIndex) -> None:
    """In the order of the deadlines."""
    for number in range(5):
        observe(index, sighting(f"lights/{number}", at=-number))

    first = expire(index, EXPIRES_AFTER, at_most=3)
    second = expire(index, EXPIRES_AFTER, at_most=3)
    assert [change.device.id for change in first] == ["lights/4", "lights/3", "lights/2"]
    assert [change.device.id for change in second] == ["lights/1", "lights/0"]
    assert expire(index, EXPIRES_AFTER, at_most=3) == ()


def test_one_device_is_found_by_its_id(index: DeviceIndex) -> None:
    """As it is now."""
    observe(index, sighting())
    expire(index, EXPIRES_AFTER)
    found = index.get("lights/lamp1")
    assert found is not None
    assert found.freshness == "stale"
    assert index.get("lights/lamp2") is None


def test_a_full_index_takes_nothing_new_in_and_counts_it() -> None:
    """What is known already goes on."""
    index = DeviceIndex(forget_after=FORGET_AFTER, max_devices=1)
    observe(index, sighting("lights/a"))
    assert observe(index, sighting("lights/b")) is None
    assert index.counters.rejected == 1
    changed = observe(index, sighting("lights/a", name="other"))
    assert changed is not None
    assert changed.kind == "changed"


def test_what_is_told_holds_all_that_its_types_ask_for(index: DeviceIndex) -> None:
    """The index makes these messages without checks, of what was checked in sightings and reports."""
    lamp = Part(id="lamp", service_type="light", capabilities=(Capability(name="on_off", settable=True),))
    described = sighting("homeassistant:light/lamp").model_copy(
        update={
            "convention": "homeassistant",
            "identifiers": ("eui64:00158d0001abcdef",),
            "parts": (lamp,),
            "metadata": (KeyValue(key="model", value="bulb"),),
        }
    )
    index.changes.collects_states = True
    index.observe(described)
    index.report(
        Report(
            gateway="mqtt",
            key=described.key,
            readings=(Reading(part="lamp", capability="on_off", value=Value.of(True)),),
            address="lamp",
            retained=False,
            received_at=Time.from_seconds(1),
        )
    )
    changes, states = index.pop_changes(), index.pop_states()

    assert changes[0].device.states
    for change in changes:
        assert DeviceChange.model_validate_json(change.model_dump_json()) == change
    assert states
    for state in states:
        assert StateChange.model_validate_json(state.model_dump_json()) == state
