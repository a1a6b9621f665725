"""Covers whose motor reports nothing but that it runs or stands still, as ESPSomfy-RTS announces its own."""

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.openings import build_cover

_ROLLER = {
    "command_topic": "shades/1/direction/set",
    "state_topic": "shades/1/direction",
    "position_topic": "shades/1/position",
    "set_position_topic": "shades/1/target/set",
    "payload_open": "-1",
    "payload_close": "1",
    "payload_stop": "0",
    "state_opening": "-1",
    "state_closing": "1",
    "state_stopped": "0",
    "position_open": 0,
    "position_closed": 100,
}


@pytest.fixture
def roller() -> DescribedPart:
    return build_cover(DiscoveryConfig("cover", "1", _ROLLER))


def movements(part: DescribedPart, *messages: str) -> list[object]:
    found: list[object] = []
    for message in messages:
        topic, payload = message.split()
        readings = part.codec.read(f"shades/1/{topic}", payload.encode(), retained=False)
        found.append(readings.get("movement"))
    return found


def test_a_cover_that_stopped_at_an_end_is_open_or_closed(roller: DescribedPart) -> None:
    assert movements(roller, "position 0", "direction 0") == [None, "open"]
    assert movements(roller, "direction 1", "position 60", "position 100", "direction 0") == [
        *("closing", None, None, "closed")
    ]


def test_a_cover_that_stopped_on_its_way_is_stopped(roller: DescribedPart) -> None:
    assert movements(roller, "direction -1", "position 40", "direction 0") == ["opening", None, "stopped"]


def test_a_position_after_the_stop_tells_where_it_is(roller: DescribedPart) -> None:
    assert movements(roller, "direction 0", "position 100", "position 40") == ["stopped", "closed", "stopped"]


def test_a_position_that_it_has_left_since_does_not_count(roller: DescribedPart) -> None:
    assert movements(roller, "position 100", "direction -1", "direction 0", "position 55") == [
        *(None, "opening", "stopped", "stopped")
    ]
