"""Who may be told something on a topic that several devices name."""

from __future__ import annotations

from collections.abc import Callable

from homebot.devices import Sighting
from homebot.devices.part import Part
from homebot.discovery import DeviceIndex
from homebot.discovery.disputes import MAX_CONCERNED, Disputes

TOPIC = ("mqtt", "all/set")


def users(*devices: str, bridge: str = "") -> Disputes:
    disputes = Disputes()
    for device in devices:
        disputes.put(device, [TOPIC], bridge)
    return disputes


def test_a_newcomer_concerns_nobody_who_is_there_already() -> None:
    disputes = users("first", "second")

    assert disputes.put("third", [TOPIC], "") == frozenset()
    assert disputes.add("fourth", [TOPIC], "") == frozenset()
    assert [disputes.owner(TOPIC, one) for one in ("first", "second", "third", "fourth")] == ["", *["first"] * 3]


def test_a_topic_passes_to_the_next_where_the_first_goes_and_that_concerns_the_others() -> None:
    disputes = users("first", "second", "third")

    assert disputes.discard("third") == frozenset()
    assert disputes.put("third", [TOPIC], "") == frozenset()
    assert disputes.discard("first") == {"second", "third"}
    assert [disputes.owner(TOPIC, one) for one in ("second", "third")] == ["", "second"]


def test_a_silent_device_keeps_nothing_from_others_until_it_speaks_again() -> None:
    disputes = users("first", "second", "third")

    assert disputes.set_idle("second", idle=True) == frozenset()
    assert disputes.set_idle("first", idle=True) == {"second", "third"}
    assert disputes.owner(TOPIC, "third") == ""
    assert disputes.set_idle("third", idle=True) == {"first", "second"}
    assert disputes.add("fourth", [TOPIC], "") == {"first", "second", "third"}
    assert disputes.set_idle("first", idle=False) == {"second", "third", "fourth"}


def test_devices_of_one_bridge_are_looked_at_anew_where_the_first_is_behind_another_now() -> None:
    disputes = users("first", "second", bridge="hub")

    assert disputes.owner(TOPIC, "second") == ""
    assert disputes.put("first", [TOPIC, ("mqtt", "more")], "another") == {"second"}
    assert disputes.owner(TOPIC, "second") == "first"


def test_of_a_crowd_at_one_topic_a_part_is_looked_at_anew_and_none_may_use_it() -> None:
    crowd = [f"device{number}" for number in range(3 * MAX_CONCERNED)]
    disputes = users("first", *crowd)

    concerned = disputes.discard("first")

    assert "device0" in concerned
    assert len(concerned) <= MAX_CONCERNED + 1
    assert {disputes.owner(TOPIC, one) for one in crowd[1:]} == {"device0"}


def test_of_a_newcomer_to_a_crowd_only_it_and_the_first_are_told(
    announce: Callable[..., Sighting], part: Callable[..., Part]
) -> None:
    index = DeviceIndex(forget_after=1e6)
    told = []
    for number in range(20):
        lamp = part("light", "on_off", writes=("all/set",))
        index.observe(announce(f"l{number}", lamp, ids=(f"id:lamp-{number}",), name=f"Lamp {number}"))
        told.append({change.device.id for change in index.take_changes()})

    assert told == [{"lamp_0"}, *({"lamp_0", f"lamp_{number}"} for number in range(1, 20))]
