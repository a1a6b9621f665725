"""The deadlines: always the earliest first, however they are moved."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from homebot.discovery.deadlines import Deadlines

keys = st.sampled_from("abcde")
times = st.integers(0, 20).map(float)
steps = st.one_of(
    st.tuples(st.just("set"), keys, times),
    st.tuples(st.just("discard"), keys, st.just(0.0)),
    st.tuples(st.just("pop"), st.just(""), times),
)


@given(st.lists(steps, max_size=200))
def test_they_are_what_a_plain_table_is(moves: list[tuple[str, str, float]]) -> None:
    """Set, moved either way, discarded and popped in any order."""
    deadlines, table = Deadlines(), dict[str, float]()
    for move, key, time in moves:
        if move == "set":
            deadlines.set(key, time)
            table[key] = time
        elif move == "discard":
            deadlines.discard(key)
            table.pop(key, None)
        else:
            popped = deadlines.pop(time)
            due = {one for one, at in table.items() if at <= time and at == min(table.values())}
            assert popped in due if due else popped is None
            table.pop(popped or "", None)
        assert deadlines.next() == min(table.values(), default=None)


def test_they_take_no_more_room_than_there_are_keys() -> None:
    """A flood of devices that come and go, or whose deadline moves forward, leaves nothing behind."""
    deadlines = Deadlines()
    for number in range(10_000):
        deadlines.set(f"guest {number}", 1e9)
        deadlines.discard(f"guest {number}")
        deadlines.set("hasty", 1e9 - number)
    assert len(deadlines._heap) < 100
    assert deadlines.next() == 1e9 - 9_999
