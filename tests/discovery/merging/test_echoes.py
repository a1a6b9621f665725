"""A capability is an echo only where no announcement of it reports what the device does."""

from __future__ import annotations

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.devices.part import Part
from homebot.discovery import DeviceIndex

MAC = "mac:aabbccddeeff"


def marked(part: Part, *, echoed: bool, readable: bool = True) -> Part:
    changes = {"echoed": echoed, "readable": readable}
    return part.model_copy(update={"capabilities": tuple(one.model_copy(update=changes) for one in part.capabilities)})


@pytest.mark.parametrize(
    ("bridge", "other", "echoed"),
    [
        ({"echoed": False}, {"echoed": True}, False),
        ({"echoed": True}, {"echoed": False}, False),
        ({"echoed": True}, {"echoed": True}, True),
        ({"echoed": True}, {"echoed": False, "readable": False}, True),
    ],
)
def test_one_honest_way_is_enough(bridge: dict[str, bool], other: dict[str, bool], *, echoed: bool) -> None:
    index = DeviceIndex(forget_after=1000.0)
    lamp = part_of("light", "on_off", id="l")
    index.observe(announce("a", marked(lamp, **bridge), ids=(MAC,), gateway="radio"), 0.0)
    index.observe(announce("b", marked(lamp, **other), ids=(MAC,), gateway="cable"), 0.0)
    (device,) = index.devices()
    (merged,) = device.parts
    assert {one.echoed for one in merged.part.capabilities} == {echoed}
