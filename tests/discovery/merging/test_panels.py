"""A zone of an alarm may be a device of its own, whose switch bypasses it."""

from itertools import permutations

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.devices import Device, Sighting
from homebot.devices.always_ask import waits_for_approval, why_it_asks
from homebot.discovery import DeviceIndex

PANEL = announce("panel", part_of("x_alarm_panel", "alarm", writes=("p/set",)), ids=("id:vista",), name="Panel")


def zone(kind: str = "switch", *, via: str = "vista", native: bool = False) -> Sighting:
    bypass = part_of(kind, "on_off", name="Bypass", writes=("z/set",))
    facts = {"via_device": via}
    made = announce("zone", bypass, ids=("id:zone-1",), name="Back window", facts=facts)
    return made.model_copy(update={"native": native})


def found(*sightings: Sighting) -> Device:
    index = DeviceIndex(forget_after=1000.0)
    for number, one in enumerate(sightings):
        index.observe(one, float(number))
        list(index.devices())  # which were described before
    return next(one for one in index.devices() if one.name == "Back window")


@pytest.mark.parametrize("sightings", list(permutations((PANEL, zone()))), ids=["panel first", "zone first"])
def test_the_switch_of_a_zone_asks_because_of_the_panel_on_which_it_hangs(sightings: tuple[Sighting, ...]) -> None:
    one = found(*sightings)
    assert why_it_asks(one, one.parts[0]) == "it hangs on the alarm panel vista"
    assert waits_for_approval(one)


@pytest.mark.parametrize("one", [zone("light"), zone("plug"), zone(via="other"), zone(via=""), zone(native=True)])
def test_a_lamp_there_and_what_hangs_elsewhere_does_not(one: Sighting) -> None:
    """Nor a device of a bridge that announces itself: a stranger may call an alarm panel like the bridge."""
    device = found(PANEL, one)
    assert not why_it_asks(device, device.parts[0])


def test_the_panel_itself_hangs_on_nothing() -> None:
    index = DeviceIndex(forget_after=1000.0)
    index.observe(PANEL, 1.0)
    (panel,) = index.devices()
    assert why_it_asks(panel, panel.parts[0]) == "it is an alarm panel"
