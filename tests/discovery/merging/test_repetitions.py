"""Announcements of one part, such as one that is left over from a rename: the same commands on the same topics."""

from itertools import permutations

import pytest
from tests.discovery.announcements import announce, part_of

from homebot.devices import Device, Sighting
from homebot.devices.part import Part
from homebot.discovery import DeviceIndex


@pytest.fixture
def lamp() -> Part:
    found = part_of("light", "on_off", id="l", writes=("hall/set",), reads=("hall",))
    return found.model_copy(update={"payloads": "ON or OFF"})


@pytest.fixture
def leftovers(lamp: Part) -> list[Sighting]:
    return [
        announce("light/old", lamp, ids=("id:m1234",), name="Old"),
        announce("light/new", lamp.model_copy(update={"id": "n"}), ids=("id:m5678",), name="New"),
        announce("light/newest", lamp.model_copy(update={"id": "o"}), name="Newest"),
    ]


def routes(device: Device) -> list[list[str]]:
    return [sorted(route.key for route in part.routes) for part in device.parts]


def test_they_are_one_part_of_one_device_in_any_order(leftovers: list[Sighting]) -> None:
    keys = sorted(one.key for one in leftovers)
    for order in permutations(leftovers):
        index = DeviceIndex(forget_after=1000.0)
        for one in order:
            index.observe(one)
        (device,) = index.devices()
        assert (routes(device), device.conflicts) == ([keys], ())
        assert any("left over from a rename" in one for one in device.evidence)


def test_the_device_stays_with_the_last_of_them(index: DeviceIndex, leftovers: list[Sighting]) -> None:
    for one in leftovers:
        index.observe(one)
    for one in leftovers[:2]:
        index.observe(one.model_copy(update={"kind": "removed"}))
    (device,) = index.devices()
    assert (routes(device), device.name) == ([["homeassistant:light/newest"]], "Newest")


@pytest.mark.parametrize(
    "change",
    [
        {"payloads": "1 or 0"},
        {"payloads": ""},
        {"service_type": "switch"},
        {"reads": ("cellar",)},
        {"writes": ("hall/set", "hall/level")},
    ],
    ids=["payloads", "none", "type", "state", "commands"],
)
def test_other_commands_are_those_of_another_part(index: DeviceIndex, lamp: Part, change: dict[str, object]) -> None:
    """Settings of a bridge share their topics, and a stranger names those of others."""
    index.observe(announce("light/a", lamp, ids=("id:m1234",), name="A"))
    index.observe(announce("light/b", lamp.model_copy(update=change), ids=("id:m5678",), name="B"))
    assert len(index.devices()) == 2


def test_one_that_is_announced_with_other_commands_is_another_device_again(
    index: DeviceIndex, lamp: Part, leftovers: list[Sighting]
) -> None:
    for one in leftovers[:2]:
        index.observe(one)
    cellar = lamp.model_copy(update={"writes": ("cellar/set",), "reads": ("cellar",)})
    index.observe(announce("light/new", cellar, ids=("id:m5678",), name="New"))
    assert sorted((one.name, routes(one)) for one in index.devices()) == [
        ("New", [["homeassistant:light/new"]]),
        ("Old", [["homeassistant:light/old"]]),
    ]


def test_the_owner_may_split_them(index: DeviceIndex, leftovers: list[Sighting]) -> None:
    for one in leftovers[:2]:
        index.observe(one)
    (device,) = index.devices()
    index.split(device.id, None, 1.0)
    assert len(index.devices()) == 2
    index.observe(leftovers[0].model_copy(update={"why": "it was announced again"}))
    assert len(index.devices()) == 2
