"""Devices of a gateway that has lost its link to all of them."""

from __future__ import annotations

from tests.discovery.announcements import announce, part_of, tell

from homebot.devices import Device
from homebot.devices.gateway_messages import REACHABLE
from homebot.devices.query import parse_query
from homebot.discovery import DeviceIndex
from homebot.discovery.source_record import LostLink
from homebot.messages import Time

LAMP = announce("lamp", part_of("light", "on_off", id="l", writes=("l/set",)), ids=("id:multi",), name="Multi")
METER = announce("meter", part_of("electrical_meter", "power", id="m", reads=("m",)), ids=("id:multi",), name="Multi")


def only(index: DeviceIndex) -> Device:
    (device,) = index.devices()
    return device


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
    device = only(index)
    assert (device.reachable.state, device.reachable.since.sec) == ("no", 9)
    assert (device.reachable.why, device.offline_parts) == ("mqtt is unavailable: gone", ("l", "m"))
    assert [(one.kind, one.why) for one in index.pop_changes()] == [("changed", "gone")]
    assert index.find(parse_query("offline"))
    link(index, "mqtt")
    assert (only(index).reachable.state, only(index).offline_parts) == ("yes", ())
    assert [one.why for one in index.pop_changes()] == ["mqtt has its link again"]


def test_a_gateway_without_its_link_may_still_reach_devices_by_links_of_their_own(index: DeviceIndex) -> None:
    """It says so by itself, and when that ends; a last will says nothing any more."""
    thing = announce("thing", *LAMP.parts, gateway="directory", convention="")
    index.observe(thing)
    index.report(tell(thing, REACHABLE, True, at=2))
    link(index, "directory", "gone")
    assert only(index).reachable.state == "yes"
    index.report(tell(thing, REACHABLE, False, at=10))
    assert (only(index).reachable.state, only(index).reachable.why) == ("no", "gone")


def test_a_device_that_another_gateway_reaches_is_only_without_the_parts_of_the_lost_one(index: DeviceIndex) -> None:
    """Its commands go by the other first; so for a device that is announced while the link is lost."""
    more = part_of("humidity_sensor", "humidity", id="h")
    hub = announce("x", *LAMP.parts, more, ids=("id:multi",), gateway="hub", convention="")
    hub = hub.model_copy(update={"authenticated": True})
    index.observe(LAMP)
    link(index, "mqtt", "gone")
    index.observe(hub)
    device = only(index)
    assert (device.reachable.state, device.offline_parts) == ("unknown", ())
    assert {one.gateway: one.reachable for one in device.endpoints} == {"mqtt": "no", "hub": "unknown"}
    assert [one.gateway for one in device.parts[0].routes] == ["hub", "mqtt"]
    link(index, "mqtt")
    link(index, "hub", "gone")
    device = only(index)
    assert (device.reachable.state, device.offline_parts) == ("unknown", ("h",))
    assert [one.gateway for one in device.parts[0].routes] == ["mqtt", "hub"]
