"""Whether a device can be reached: what its parts are together, and each part by itself."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import sighting_of
from tests.discovery.announcements import announce, only_device, part_of, tell

from homebot.devices import Sighting
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.part import Part
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex
from homebot.discovery.source_record import LostLink
from homebot.messages import Time
from homebot.words.queries import parse_query

HOUR = 3600.0


@pytest.fixture
def index() -> DeviceIndex:
    return DeviceIndex(forget_after=24 * HOUR)


LAMP = announce("lamp", part_of("light", "on_off", id="l", writes=("l/set",)), ids=("id:multi",), name="Multi")


METER = announce("meter", part_of("electrical_meter", "power", id="m", reads=("m",)), ids=("id:multi",), name="Multi")


def test_an_entity_that_is_offline_makes_itself_unreachable_while_another_speaks(index: DeviceIndex) -> None:
    for one in (LAMP, METER):
        index.observe(one)
    index.report(tell(METER, "power", 5.0, part="m", at=1))
    index.report(tell(LAMP, REACHABLE, False, at=2))
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("no", ("l",))
    index.pop_changes()
    index.report(tell(METER, "power", 6.0, part="m", at=3))
    device = only_device(index)
    assert (device.reachable.state, device.offline_parts) == ("unknown", ("l",))
    assert device.reachable.why == "homeassistant:lamp is offline, but homeassistant:meter reported since"
    assert [one.kind for one in index.pop_changes()] == ["changed"]
    assert not index.find(parse_query("offline"))


def test_it_is_told_which_address_says_that_a_device_is_offline(index: DeviceIndex) -> None:
    """While Zigbee2MQTT was down, each of its devices was said to be offline according to itself."""
    index.observe(LAMP)
    index.report(tell(LAMP, REACHABLE, False, address="zigbee2mqtt/bridge/state"))
    assert only_device(index).reachable.why == "homeassistant:lamp is offline, according to zigbee2mqtt/bridge/state"


def test_one_part_that_can_be_reached_is_enough(index: DeviceIndex) -> None:
    for one in (LAMP, METER):
        index.observe(one)
    index.report(tell(LAMP, REACHABLE, False, at=2))
    index.report(tell(METER, REACHABLE, True, at=1))
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("yes", ("l",))
    index.report(tell(METER, REACHABLE, False, at=3))
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("no", ("l", "m"))
    index.report(tell(LAMP, REACHABLE, True, at=4))
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("yes", ("m",))


def test_parts_of_one_announcement_each_have_their_own(index: DeviceIndex) -> None:
    both = announce("both", part_of("light", "on_off", id="l"), part_of("switch", "on_off", id="s"), ids=("id:both",))
    index.observe(both)
    index.report(tell(both, REACHABLE, False, part="l", at=1))
    assert only_device(index).offline_parts == ("l",)
    index.report(tell(both, "on_off", True, part="s", at=2))
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("unknown", ("l",))
    index.report(tell(both, REACHABLE, True, part="l", at=3))
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("yes", ())


def test_the_reason_names_a_part_only_where_others_differ(index: DeviceIndex) -> None:
    both = announce("both", part_of("light", "on_off", id="l"), part_of("switch", "on_off", id="s"), ids=("id:both",))
    index.observe(both)
    index.report(tell(both, REACHABLE, True, part="l", at=1))
    assert only_device(index).reachable.why.startswith("homeassistant:both (l) is online")
    index.report(tell(both, REACHABLE, True, part="s", at=2))
    assert only_device(index).reachable.why.startswith("homeassistant:both is online")


def test_what_tells_it_no_more_is_nothing_to_go_by(index: DeviceIndex) -> None:
    """As where the announcement that comes next names no availability."""
    index.observe(LAMP)
    index.report(tell(LAMP, REACHABLE, False, at=1))
    index.report(tell(LAMP, REACHABLE, None, at=2, address=""))
    assert (only_device(index).reachable.why, only_device(index).offline_parts) == ("it does not report it", ())


@given(st.lists(st.tuples(st.integers(0, 3), st.booleans()), max_size=20))
def test_a_device_of_which_each_part_tells_is_reachable_as_long_as_any_is(said: list[tuple[int, bool]]) -> None:
    index = DeviceIndex(forget_after=HOUR)
    names = "abcd"
    last: dict[str, bool] = {}
    for name in names:
        index.observe(_sighting(name))
    for number, (which, value) in enumerate(said):
        last[names[which]] = value
        reading = Reading(part="", capability=REACHABLE, value=Value.of(value))
        at = Time.from_seconds(float(number))
        index.report(
            Report(gateway="g", key=names[which], readings=(reading,), address="x", retained=False, received_at=at)
        )
        device = only_device(index)
        ids = {one.routes[0].key: one.id for one in device.parts}
        assert set(device.offline_parts) == {ids[one] for one, is_online in last.items() if not is_online}
        assert device.reachable.state == ("yes" if True in last.values() else "no")


def _sighting(key: str) -> Sighting:
    return sighting_of(
        key,
        Part(id=key, service_type="light", tag=key, reads=(key,)),
        gateway="g",
        convention="homeassistant",
        identifiers=("id:panel-4711",),
        announced_on=key,
        confirmed=False,
        lasts=HOUR,
    )


def link(index: DeviceIndex, gateway: str, why: str = "", at: float = 9.0) -> None:
    """Let *gateway* lose its link, or have it again."""
    for _ in index.record_link(gateway, LostLink(Time.from_seconds(at), why) if why else None):
        pass


def test_without_the_link_of_its_gateway_a_device_is_unreachable_and_then_as_before(index: DeviceIndex) -> None:
    for one in (LAMP, METER):
        index.observe(one)
    index.report(tell(LAMP, REACHABLE, True, at=2))
    index.pop_changes()
    link(index, "mqtt", "gone")
    link(index, "mqtt", "mqtt is unavailable: gone", at=20)
    device = only_device(index)
    assert (device.reachable.state, device.reachable.since.sec) == ("no", 9)
    assert (device.reachable.why, device.offline_parts) == ("mqtt is unavailable: gone", ("l", "m"))
    assert [(one.kind, one.why) for one in index.pop_changes()] == [("changed", "gone")]
    assert index.find(parse_query("offline"))
    link(index, "mqtt")
    assert (only_device(index).reachable.state, only_device(index).offline_parts) == ("yes", ())
    assert [one.why for one in index.pop_changes()] == ["mqtt has its link again"]


def test_a_gateway_without_its_link_may_still_reach_devices_by_links_of_their_own(index: DeviceIndex) -> None:
    """It says so by itself, and when that ends; a last will says nothing any more."""
    thing = announce("thing", *LAMP.parts, gateway="directory", convention="")
    index.observe(thing)
    index.report(tell(thing, REACHABLE, True, at=2))
    link(index, "directory", "gone")
    assert only_device(index).reachable.state == "yes"
    index.report(tell(thing, REACHABLE, False, at=10))
    assert (only_device(index).reachable.state, only_device(index).reachable.why) == ("no", "gone")


def test_a_device_that_another_gateway_reaches_is_only_without_the_parts_of_the_lost_one(index: DeviceIndex) -> None:
    """Its commands go by the other first; so for a device that is announced while the link is lost."""
    more = part_of("humidity_sensor", "humidity", id="h")
    hub = announce("x", *LAMP.parts, more, ids=("id:multi",), gateway="hub", convention="")
    hub = hub.model_copy(update={"authenticated": True})
    index.observe(LAMP)
    link(index, "mqtt", "gone")
    index.observe(hub)
    device = only_device(index)
    assert (device.reachable.state, device.offline_parts) == ("unknown", ())
    assert {one.gateway: one.reachable for one in device.endpoints} == {"mqtt": "no", "hub": "unknown"}
    assert [one.gateway for one in device.parts[0].routes] == ["hub", "mqtt"]
    link(index, "mqtt")
    link(index, "hub", "gone")
    device = only_device(index)
    assert (device.reachable.state, device.offline_parts) == ("unknown", ("h",))
    assert [one.gateway for one in device.parts[0].routes] == ["mqtt", "hub"]
