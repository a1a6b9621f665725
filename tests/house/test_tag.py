"""A tag that people hold to a reader."""

from __future__ import annotations

from homebot.house.description import parse_world
from homebot.house.tag import SimulatedTag


def test_a_tag_is_at_the_reader_for_a_while() -> None:
    tag = SimulatedTag("tag", "hall_lamp")
    assert tag.state() == "away"
    assert tag.handle_command("tap", 10.0) == ("hall_lamp",)
    assert tag.handle_command("tap", 11.0) == ()
    assert (tag.state(), tag.next_event()) == ("hall_lamp", 13.0)
    assert tag.advance(20.0) == ("away",)
    assert tag.next_event() is None


def test_a_tag_that_is_tapped_again_and_again_comes_and_goes() -> None:
    tag = SimulatedTag("tag", "hall_lamp", hold=1.0, every=60.0)
    assert tag.advance(130.0) == ("hall_lamp", "away") * 2
    assert tag.next_event() == 180.0


def test_a_timer_of_a_house_taps_it() -> None:
    tables = {
        "rooms": {"hall": {}},
        "devices": {"tag": {"kind": "tag", "room": "hall", "dialect": "nfc", "text": "lamp"}},
        "errands": [{"at": "07:00", "device": "tag", "command": "tap"}],
    }
    world = parse_world(tables, "test")
    said = [event.what for event in world.run_until(8 * 3600.0) if event.verb == "says"]
    assert said == ["lamp", "away"]
