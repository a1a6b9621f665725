"""One device over several gateways: each way to reach it has its own freshness, and the best is used first."""

from collections.abc import Callable

import pytest
from tests.discovery.announcements import announce, only_device, part_of, tell

from homebot.devices import Device, Sighting
from homebot.discovery import DeviceIndex

Hear = Callable[..., None]

MAC = "mac:aabbccddeeff"
HOUR = 3600.0


@pytest.fixture
def announced() -> dict[str, Sighting]:
    """One lamp as two gateways announce it: silent for at most an hour."""
    lamp = part_of("light", "on_off", id="l")
    return {one: announce("lamp", lamp, ids=(MAC,), gateway=one, confirmed=True) for one in ("radio", "cable")}


@pytest.fixture
def lamp(index: DeviceIndex, announced: dict[str, Sighting]) -> Device:
    """That lamp, heard over both at 0 s."""
    for sighting in announced.values():
        index.observe(sighting, 0.0)
    return only_device(index)


@pytest.fixture
def hear(index: DeviceIndex, announced: dict[str, Sighting]) -> Hear:
    """Lets the lamp report over a gateway."""

    def report(gateway: str, at: float, capability: str = "on_off", *, value: bool = True) -> None:
        part = "l" if capability == "on_off" else ""
        index.report(tell(announced[gateway], capability, value, part=part, at=at), at)

    return report


def life(device: Device) -> list[tuple[str, str, str]]:
    return [(one.gateway, one.freshness, one.reachable) for one in device.endpoints]


def routes(device: Device) -> list[str]:
    (part,) = device.parts
    return [route.gateway for route in part.routes]


def test_it_is_one_device_with_an_endpoint_for_each_gateway(lamp: Device) -> None:
    assert life(lamp) == [("radio", "fresh", "unknown"), ("cable", "fresh", "unknown")]
    assert routes(lamp) == ["radio", "cable"]


def test_a_gateway_at_which_it_is_silent_is_stale_and_used_last_while_the_device_is_fresh(
    index: DeviceIndex, lamp: Device, hear: Hear
) -> None:
    index.pop_changes()
    hear("cable", 1000.0)
    index.pop_changes()
    assert index.next_deadline() == HOUR
    assert index.expire(HOUR) == 0, "the device is not stale"
    (change,) = index.pop_changes()
    assert (change.kind, change.why) == ("changed", "it has been silent for too long over radio")
    assert change.device.freshness == "fresh"
    assert life(change.device) == [("cable", "fresh", "unknown"), ("radio", "stale", "unknown")]
    assert routes(change.device) == ["cable", "radio"]


def test_a_gateway_that_hears_it_again_is_fresh_and_in_its_old_place(
    index: DeviceIndex, lamp: Device, hear: Hear
) -> None:
    hear("cable", 1000.0)
    index.expire(HOUR)
    index.pop_changes()
    hear("radio", 4000.0)
    (change,) = index.pop_changes()
    assert change.why == "it reported again over radio"
    assert life(change.device) == [("radio", "fresh", "unknown"), ("cable", "fresh", "unknown")]
    assert routes(change.device) == ["radio", "cable"]


def test_one_that_was_stale_everywhere_returns_over_the_gateway_that_hears_it(
    index: DeviceIndex, lamp: Device, hear: Hear
) -> None:
    index.expire(HOUR)
    assert life(only_device(index)) == [("radio", "stale", "unknown"), ("cable", "stale", "unknown")]
    hear("cable", 3700.0)
    assert only_device(index).freshness == "fresh"
    assert life(only_device(index)) == [("cable", "fresh", "unknown"), ("radio", "stale", "unknown")]


def test_the_route_that_says_that_it_cannot_be_reached_there_comes_last(
    index: DeviceIndex, lamp: Device, hear: Hear
) -> None:
    index.pop_changes()
    hear("radio", 10.0, "reachable", value=False)
    (change,) = index.pop_changes()
    assert life(change.device) == [("cable", "fresh", "unknown"), ("radio", "fresh", "no")]
    assert routes(change.device) == ["cable", "radio"]
    hear("radio", 11.0, "reachable", value=True)
    (change,) = index.pop_changes()
    assert routes(change.device) == ["radio", "cable"]


def test_a_gateway_without_a_part_of_it_is_an_endpoint_as_well(index: DeviceIndex, lamp: Device) -> None:
    index.observe(announce("page", ids=(MAC,), gateway="web", confirmed=True), 1.0)
    assert [one.gateway for one in only_device(index).endpoints] == ["radio", "cable", "web"]


def test_a_gateway_that_loses_it_is_no_endpoint_any_more(index: DeviceIndex, lamp: Device) -> None:
    index.observe(announce("lamp", ids=(MAC,), gateway="radio", kind="removed", at=5.0), 5.0)
    assert life(only_device(index)) == [("cable", "fresh", "unknown")]


def test_a_device_of_one_gateway_is_as_fresh_there_as_everywhere(index: DeviceIndex) -> None:
    index.observe(announce("lamp", part_of("light", "on_off", id="l"), ids=(MAC,), confirmed=True), 0.0)
    index.expire(HOUR)
    (endpoint,) = only_device(index).endpoints
    assert (endpoint.freshness, endpoint.last_seen) == ("stale", only_device(index).last_seen)


def test_two_devices_that_become_one_keep_which_gateway_was_silent(index: DeviceIndex) -> None:
    index.observe(announce("lamp", part_of("light", "on_off", id="l"), ids=("id:first one",), confirmed=True), 0.0)
    index.expire(HOUR)
    late = announce("lamp", part_of("light", "on_off", id="l"), ids=(MAC,), gateway="cable", at=4000.0, confirmed=True)
    index.observe(late, 4000.0)
    both = announce("lamp", part_of("light", "on_off", id="l"), ids=(MAC,), at=0.0)
    index.observe(both, 4001.0)
    assert only_device(index).freshness == "fresh"
    assert {one[0]: one[1] for one in life(only_device(index))} == {"mqtt": "stale", "cable": "fresh"}


@pytest.mark.parametrize(
    ("prefer", "order"), [(("cable",), ["cable", "radio"]), (("web", "radio"), ["radio", "cable"])]
)
def test_the_gateways_that_the_owner_prefers_take_commands_first(
    index: DeviceIndex, announced: dict[str, Sighting], prefer: tuple[str, ...], order: list[str]
) -> None:
    index.owner.prefer = prefer
    for sighting in announced.values():
        index.observe(sighting, 0.0)
    assert routes(only_device(index)) == order
    assert [one.gateway for one in only_device(index).endpoints] == order
    (fact,) = [one for one in only_device(index).facts if one.name == "prefer"]
    assert (fact.value, fact.convention) == (order[0], "owner")


def test_a_preferred_gateway_that_cannot_reach_the_device_or_is_stale_comes_last(
    index: DeviceIndex, announced: dict[str, Sighting], hear: Hear
) -> None:
    index.owner.prefer = ("cable", "radio")
    for sighting in announced.values():
        index.observe(sighting, 0.0)
    hear("radio", 1000.0)
    index.expire(HOUR)
    assert routes(only_device(index)) == ["radio", "cable"], "cable was silent for too long"
    hear("cable", 4000.0)
    assert routes(only_device(index)) == ["cable", "radio"]
    hear("cable", 4010.0, "reachable", value=False)
    assert routes(only_device(index)) == ["radio", "cable"], "cable cannot reach it"


def test_a_device_of_one_gateway_says_nothing_of_a_preference(
    index: DeviceIndex, announced: dict[str, Sighting]
) -> None:
    index.owner.prefer = ("cable", "radio")
    index.observe(announced["cable"], 0.0)
    assert all(one.name != "prefer" for one in only_device(index).facts)
