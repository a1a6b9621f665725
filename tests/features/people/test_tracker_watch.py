"""The persons among the trackers of a house."""

import pytest

from homebot.devices.device import Device, DeviceChange, DevicePart, Endpoint, Freshness, Reachability, Route
from homebot.devices.part import Capability, Part
from homebot.features.people.tracker_watch import TrackerWatch
from homebot.messages import Time

NOW = Time.from_seconds(0.0)


def watch(*members: str, freshness: Freshness = "fresh", **reachable: str) -> TrackerWatch:
    part = Part(id="p", service_type="x_tracker", capabilities=(Capability(name="place"),), members=members)
    device = Device(
        id="anna",
        name="Anna",
        names=("Anna",),
        service_type="x_tracker",
        endpoints=(Endpoint(gateway="hub", key="a", address="a", command_address=""),),
        parts=(DevicePart(id="p", part=part, routes=(Route(gateway="hub", key="a", part="p"),)),),
        metadata=(),
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness=freshness,
        reachable=Reachability.model_validate(reachable),
    )
    found = TrackerWatch()
    found.on_device(DeviceChange(kind="appeared", device=device, sequence=1, why=""))
    return found


def test_a_tracker_that_stands_for_others_is_a_person_and_no_other_one() -> None:
    assert watch("#phone").persons({}) == {"anna": "Anna"}
    assert watch().persons({}) == {}


@pytest.mark.parametrize(
    ("freshness", "reachable", "counts"),
    [("unconfirmed", "unknown", True), ("stale", "no", True), ("stale", "unknown", False)],
)
def test_a_person_whom_the_system_does_not_list_any_more_is_none(
    freshness: Freshness, reachable: str, *, counts: bool
) -> None:
    """But one whose system is away, or has not answered yet, counts, and is unknown."""
    assert bool(watch("#phone", freshness=freshness, state=reachable).persons({})) is counts
