"""Random people of a house: where they go in the day, and whether they sit still there."""

from collections.abc import Mapping
from typing import Any, Final

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn

from homebot.house.rooms import DAY, OUTSIDE
from homebot.testing.day_event import write_time
from homebot.testing.strategies.choices import several

Table = dict[str, Any]

_STILL: Final = st.sampled_from((0.0, 600.0, 3600.0, DAY))
"""For how long people sit still, awake, where they go; 0 for those who move all the time."""

_MOST_VISITS: Final = 8
_MINUTE: Final = 60.0


@st.composite
def random_people(draw: DrawFn, rooms: Mapping[str, Table], start: float, length: float) -> dict[str, Table]:
    """Draw people who walk about in *rooms* from *start*, in seconds since midnight, for *length* seconds."""
    places = st.sampled_from((*rooms, OUTSIDE))
    times = st.integers(0, int(length / _MINUTE)).map(lambda minute: write_time((start + minute * _MINUTE) % DAY))
    visits = st.fixed_dictionaries(
        {"at": times, "room": places, "asleep": st.sampled_from((False, False, False, True)), "still": _STILL}
    )
    return {
        f"person_{number}": {
            "starts_in": draw(places),
            "asleep": draw(st.booleans()),
            "speed": draw(st.sampled_from((1.0, 0.1, 10.0))),
            "day": several(draw, visits, 2, _MOST_VISITS),
        }
        for number in range(draw(st.sampled_from((1, 2, 2, 3, 0))))
    }
