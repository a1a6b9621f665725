"""Signs of life: what they are, how long silence is none, and what becomes of those who went."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.discovery.announcements import announce, part_of, tell

from homebot.devices import DeviceChange, Sighting
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.discovery import DeviceIndex
from homebot.discovery.entry import ReportInterval
from homebot.discovery.ids import Tombstone, Tombstones
from homebot.words.queries import parse_query

HOUR = 3600.0
DAY = 24 * HOUR


@pytest.fixture
def index() -> DeviceIndex:
    return DeviceIndex(forget_after=DAY)


def after(index: DeviceIndex, one: Sighting | Report) -> list[str]:
    if isinstance(one, Sighting):
        index.observe(one)
    else:
        index.report(one)
    return [change.kind for change in index.pop_changes()]


def expire(index: DeviceIndex, now: float) -> tuple[DeviceChange, ...]:
    while index.expire(now):
        pass
    return index.pop_changes()


def freshness(index: DeviceIndex) -> str:
    (device,) = index.devices()
    return device.freshness


def test_a_sensor_that_reports_every_two_hours_is_not_stale_between_its_reports(index: DeviceIndex) -> None:
    """Once it was heard twice; and it is when it misses three."""
    sensor = announce("t", part_of("temperature_sensor", "temperature", id="t"), ids=("id:sensor",))
    index.observe(sensor)
    stale = 0
    for number in range(1, 12):
        stale += sum(one.kind == "stale" for one in expire(index, number * 2 * HOUR - 1))
        index.report(tell(sensor, "temperature", float(number), part="t", at=number * 2 * HOUR))
    assert stale == 2
    assert expire(index, 22 * HOUR + 6 * HOUR - 1) == ()
    assert [one.kind for one in expire(index, 22 * HOUR + 6 * HOUR)] == ["stale"]


def test_a_kept_message_is_no_sign_of_life(index: DeviceIndex) -> None:
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",))
    after(index, lamp)
    assert after(index, tell(lamp, "on_off", True, part="l", retained=True)) == []
    assert freshness(index) == "unconfirmed"
    assert after(index, tell(lamp, "on_off", True, part="l")) == ["changed"]
    assert freshness(index) == "fresh"


def test_what_a_gateway_concludes_by_itself_is_no_sign_of_life(index: DeviceIndex) -> None:
    """A value that fades does so without the device."""
    lamp = announce("l", part_of("occupancy_sensor", "occupancy", id="l"), ids=("id:pir",))
    after(index, lamp)
    assert after(index, tell(lamp, "occupancy", False, part="l", address="")) == []
    assert freshness(index) == "unconfirmed"


def test_a_last_will_says_that_a_device_is_gone_and_is_no_sign_of_life(index: DeviceIndex) -> None:
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",))
    after(index, lamp)
    assert after(index, tell(lamp, REACHABLE, True, at=5)) == ["changed"]
    assert (index.devices()[0].reachable.state, freshness(index)) == ("yes", "fresh")

    assert after(index, tell(lamp, REACHABLE, False, at=9)) == ["changed"]
    (device,) = index.devices()
    assert (device.reachable.state, device.reachable.since.sec, device.last_seen.sec) == ("no", 9, 5)
    assert "offline" in device.reachable.why
    assert after(index, tell(lamp, REACHABLE, None, at=10)) == ["changed"]
    assert index.devices()[0].reachable.state == "unknown"


def test_a_device_that_said_live_that_it_is_online_may_be_silent_for_a_day(index: DeviceIndex) -> None:
    """Its last will watches over it; one that the broker had kept watches over nothing."""
    said = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",), name="said")
    kept = announce("k", part_of("light", "on_off", id="l"), ids=("id:kept",), name="kept")
    for one in (said, kept):
        index.observe(one)
        index.report(tell(one, REACHABLE, True, at=5, retained=one is kept))
    index.pop_changes()
    assert [one.device.id for one in expire(index, DAY)] == ["kept"]
    assert [one.device.id for one in expire(index, DAY + 5)] == ["said"]


def test_a_forgotten_ghost_does_not_come_back_by_what_the_broker_kept(index: DeviceIndex) -> None:
    """Its own word brings it back, under its old id."""
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("mac:aabbccddeeff",), name="Lamp")
    other = announce("m", part_of("light", "on_off", id="l"), ids=("mac:000000000001",), name="Lamp", at=3 * DAY)
    after(index, lamp)
    assert [one.kind for one in expire(index, 3 * DAY)] == ["stale", "removed"]

    assert after(index, lamp.model_copy(update={"seen_at": other.seen_at})) == []
    assert index.counters.retained_only == 1
    assert after(index, other) == ["appeared"]
    alive = lamp.model_copy(update={"confirmed": True, "seen_at": other.seen_at, "expires_at": other.expires_at})
    index.observe(alive)
    (change,) = index.pop_changes()
    assert (change.kind, change.device.id) == ("appeared", "lamp")
    assert change.why.startswith("it returned")
    assert sorted(one.id for one in index.devices()) == ["lamp", "lamp_0001"]


def test_a_forgotten_device_is_back_with_its_first_live_word(index: DeviceIndex) -> None:
    """Whether its gateway announces it anew or not; a last will is no word."""
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("mac:aabbccddeeff",), name="Lamp")
    after(index, lamp)
    expire(index, 3 * DAY)
    assert after(index, tell(lamp, REACHABLE, False, at=3 * DAY)) == []
    assert after(index, tell(lamp, "on_off", True, part="l", at=3 * DAY, retained=True)) == []
    assert after(index, tell(lamp, "on_off", True, part="l", at=3 * DAY)) == ["appeared"]
    (device,) = index.devices()
    assert (device.id, device.freshness, device.expires.sec) == ("lamp", "fresh", 3 * DAY + 3600)
    assert [one.value.plain() for one in device.states] == [True]


def test_a_removed_device_that_is_announced_under_another_key_is_recognised(index: DeviceIndex) -> None:
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("eui64:00158d0001abcdef",), name="Lamp")
    after(index, lamp)
    after(index, lamp.model_copy(update={"kind": "removed"}))
    again = announce("new", part_of("light", "on_off", id="l"), ids=("eui64:00158d0001abcdef",), name="Hall lamp")
    assert after(index, again) == ["appeared"]
    assert [one.id for one in index.devices()] == ["lamp"]


def test_a_device_that_somebody_wants_forgotten_is_gone_until_it_speaks(index: DeviceIndex) -> None:
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("mac:aabbccddeeff",), name="Lamp")
    after(index, lamp)
    assert index.forget("lamp", 5.0) == (("mqtt", "homeassistant/l/aabbccddeeff/config"),)
    assert [one.kind for one in index.pop_changes()] == ["removed"]
    assert after(index, lamp) == []
    assert after(index, lamp.model_copy(update={"confirmed": True})) == ["appeared"]
    assert index.forget("nobody", 5.0) is None


def test_a_report_that_comes_before_its_announcement_waits_for_it(index: DeviceIndex) -> None:
    """For a minute; the two come on two topics."""
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",), at=30)
    index.report(tell(lamp, "on_off", True, part="l", at=25))
    index.report(tell(lamp, "on_off", False, part="l", at=30))
    index.observe(lamp)
    (device,) = index.devices()
    assert [one.value.plain() for one in device.states] == [False]
    assert device.freshness == "fresh"

    late = announce("m", part_of("light", "on_off", id="l"), ids=("id:late",), at=300)
    index.report(tell(late, "on_off", True, part="l", at=25))
    index.observe(late)
    assert index.devices()[1].states == ()


def test_reports_of_nobody_and_of_unknown_parts_are_counted(index: DeviceIndex) -> None:
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",))
    index.report(tell(lamp, "on_off", True, part="l"))
    index.observe(lamp)
    index.report(tell(lamp, "on_off", False, part="other"))
    index.report(tell(lamp, "level", 5.0, part="l"))
    assert {("strays", 1), ("unknown_parts", 2)} <= {(one.name, one.count) for one in index.counts()}
    (device,) = index.devices()
    assert [(one.part, one.capability, one.value.plain()) for one in device.states] == [("l", "on_off", True)]


def test_an_old_report_of_a_part_that_vanished_changes_nothing(index: DeviceIndex) -> None:
    """Nor one of a capability that the part has no longer; what waited to be told of them is not told."""
    before = announce(
        "l", part_of("light", "on_off", "level", id="l"), part_of("x_sensor", "value", id="s"), ids=("id:lamp",)
    )
    index.observe(before)
    index.sort()
    index.changes.collects_states = True
    old = [
        tell(before, "level", 5.0, part="l"),
        tell(before, "value", 7.0, part="s"),
        tell(before, "on_off", True, part="l"),
    ]
    for one in old:
        index.report(one)
    index.observe(announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",)))
    for one in old:
        index.report(one.model_copy(update={"retained": True}))
    index.pop_changes()
    (device,) = index.devices()
    assert [(one.part, one.capability) for one in device.states] == [("l", "on_off")]
    assert [state.capability for one in index.pop_states() for state in one.states] == ["on_off"]
    assert not index.find(parse_query("level > 1"))


def test_a_part_that_left_an_address_has_no_value_until_it_reports_on_the_present_ones(index: DeviceIndex) -> None:
    """What was said there is of another source: nobody may call it recent."""
    part = part_of("light", "on_off", id="l")
    found = []
    for reads in (("a",), ("a", "b"), ("b",), ("b",)):
        lamp = announce("l", part.model_copy(update={"reads": reads}), ids=("id:lamp",))
        index.observe(lamp)
        found.append([one.value.plain() for one in index.devices()[0].states])
        index.report(tell(lamp, "on_off", True, part="l"))
    assert found == [[], [True], [], [True]]


def test_what_a_part_told_goes_with_it(index: DeviceIndex) -> None:
    """However often a device changes its parts, it is no bigger than they are."""
    for number in range(5):
        lamp = announce("l", part_of("light", "on_off", id=f"l{number}"), ids=("id:lamp",))
        index.observe(lamp)
        index.report(tell(lamp, "on_off", True, part=f"l{number}"))
    (device,) = index.devices()
    assert [one.part for one in device.states] == ["l4"]
    entry = index.entry(device.id)
    assert entry is not None
    (source,) = entry.sources.values()
    assert len(source.values) == 1


def test_states_are_told_where_somebody_wants_them(index: DeviceIndex) -> None:
    """Each new value once, numbered above the change that went before."""
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",), name="Lamp")
    index.observe(lamp)
    index.report(tell(lamp, "on_off", True, part="l", at=1))
    index.changes.collects_states = True
    index.report(tell(lamp, "on_off", True, part="l", at=2))
    index.report(tell(lamp, "on_off", False, part="l", at=3))
    changes, states = index.pop_changes(), index.pop_states()
    (change,) = states
    assert [(one.value.plain(), one.since.sec) for one in change.states] == [(False, 3)]
    assert (change.device, change.sequence) == ("lamp", changes[-1].sequence + 1)


def test_new_values_of_one_message_are_one_change(index: DeviceIndex) -> None:
    """With those that changed alone; the key names them, so that no newer change of others takes its place."""
    lamp = announce("l", part_of("light", "on_off", "level", "effect", id="l"), ids=("id:lamp",), name="Lamp")
    index.observe(lamp)
    index.sort()
    index.changes.collects_states = True
    for at, level in ((1, 5.0), (2, 6.0)):
        on, off = tell(lamp, "on_off", True, part="l", at=at), tell(lamp, "level", level, part="l", at=at)
        index.report(on.model_copy(update={"readings": (*on.readings, *off.readings)}))
    both, level_alone = index.pop_states()
    assert [(one.capability, one.value.plain()) for one in both.states] == [("on_off", True), ("level", 5.0)]
    assert [(one.capability, one.value.plain()) for one in level_alone.states] == [("level", 6.0)]
    assert both.stream != level_alone.stream
    assert index.find(parse_query("level > 5.5"))


def test_tombstones_are_bounded_and_the_oldest_is_forgotten() -> None:
    stones = Tombstones(at_most=3)
    forgotten = [
        stones.put(Tombstone(str(one), (("g", str(one)),), (f"mac:{one}",), retained_only=True, at=0.0))
        for one in range(5)
    ]
    assert [one.id if one else None for one in forgotten] == [None, None, None, "0", "1"]
    assert [one.id for one in stones] == ["2", "3", "4"]
    assert stones.find(("g", "0"), ("mac:0",)) is None
    found = stones.find(("g", "new"), ("mac:3",))
    assert found is not None
    assert found.id == "3"


def test_one_outage_does_not_make_a_rhythm() -> None:
    rhythm = ReportInterval()
    now = 0.0
    for gap in (60.0, 60.0, 10 * DAY, 60.0, 60.0):
        rhythm.record(now)
        now += gap
    rhythm.record(now)
    assert rhythm.expected_silence == 180.0


def test_messages_of_one_moment_are_one_word() -> None:
    rhythm = ReportInterval()
    for now in (0.0, 0.1, 0.2, 600.0, 600.1):
        rhythm.record(now)
    assert rhythm.gaps == (600.0,)


@given(st.lists(st.floats(0, 1e9), max_size=100))
def test_patience_is_bounded_whatever_was_heard(times: list[float]) -> None:
    rhythm = ReportInterval()
    for now in times:
        rhythm.record(now)
    assert 0 <= rhythm.expected_silence <= 7 * DAY
    assert len(rhythm.gaps) <= 8


def test_the_first_value_is_first_until_the_device_reports_another_one(index: DeviceIndex) -> None:
    """Also where it was known from the broker: since when it is so is not known then."""
    lamp = announce("l", part_of("light", "on_off", id="l"), ids=("id:lamp",))
    index.observe(lamp)
    found = []
    for is_on, retained in ((False, True), (True, True), (True, False), (True, False), (False, False), (False, False)):
        index.report(tell(lamp, "on_off", is_on, part="l", retained=retained))
        (state,) = index.devices()[0].states
        found.append(state.is_first)
    assert found == [True] * 4 + [False] * 2
