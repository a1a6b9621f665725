"""What a bridge announces of a device that it lists is left out since, and forgotten after a restart."""

from collections.abc import Callable

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.devices import Sighting
from homebot.discovery import DeviceIndex
from homebot.discovery.record import entry_record, read_entry

LAMP = "eui64:00158d0001abcdef"
ORIGIN = {"origin": "Zigbee2MQTT"}


def announced(base: str = "zigbee2mqtt", origin: str = "Zigbee2MQTT", gateway: str = "mqtt") -> Sighting:
    part = part_of("light", "on_off", id="light", writes=(f"{base}/lamp/set",))
    return announce("light/lamp", part, ids=(LAMP,), facts={"origin": origin}, gateway=gateway)


LISTED = announce(
    "0x00158d0001abcdef",
    part_of("light", "on_off", id="light", writes=("zigbee2mqtt/lamp/set",)),
    convention="zigbee2mqtt",
    ids=(LAMP,),
    facts=ORIGIN,
    owns=("zigbee2mqtt/lamp",),
)


def restarted(other: Sighting) -> DeviceIndex:
    index, again = (DeviceIndex(forget_after=1000.0) for _ in range(2))
    index.observe(LISTED)
    index.observe(other)
    for device in index.devices():
        entry = index.entry(device.id)
        assert entry is not None
        again.restore(read_entry(device.id, entry_record(entry)), 1.0)
    return again


def count(index: DeviceIndex) -> int:
    (device,) = index.devices()
    entry = index.entry(device.id)
    assert entry is not None
    return len(entry.sources)


def test_a_derived_announcement_is_forgotten_once_the_device_is_listed() -> None:
    index = restarted(announced())
    assert count(index) == 2
    index.observe(LISTED)
    assert count(index) == 1
    index.observe(announced())  # whoever announces it again has a reason
    index.observe(LISTED)
    assert count(index) == 2


@pytest.mark.parametrize(
    "make",
    [lambda: announced("z2m"), lambda: announced(origin="Node-RED"), lambda: announced(gateway="other")],
    ids=["elsewhere", "another program", "another gateway"],
)
def test_any_other_announcement_is_kept(make: Callable[[], Sighting]) -> None:
    index = restarted(make())
    index.observe(LISTED)
    assert count(index) == 2


def test_one_that_was_announced_since_the_start_is_kept() -> None:
    index = restarted(announced())
    index.observe(announced())
    index.observe(LISTED)
    assert count(index) == 2
