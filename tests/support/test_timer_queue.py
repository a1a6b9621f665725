"""The queue of everything that waits for a time, held to a plain list of what is due."""

import math

from hypothesis import given
from hypothesis import strategies as st

from homebot.support.timer_queue import TimerQueue

TIMES = st.integers(0, 6).map(float) | st.just(math.inf)
STEPS = st.one_of(
    st.tuples(st.just("set"), st.sampled_from("abcd"), TIMES),
    st.tuples(st.just("discard"), st.sampled_from("abcd"), st.just(0.0)),
    st.tuples(st.just("pop"), st.just(""), TIMES),
)


def empty(queue: TimerQueue[str, int]) -> list[tuple[str, int]]:
    popped = []
    while (found := queue.pop()) is not None:
        popped.append(found)
    return popped


@given(st.lists(STEPS, max_size=40))
def test_the_earliest_comes_first_and_of_equal_times_the_one_set_first(steps: list[tuple[str, str, float]]) -> None:
    queue: TimerQueue[str, int] = TimerQueue()
    plain: dict[str, tuple[float, int]] = {}
    for number, (step, key, at) in enumerate(steps):
        if step == "set":
            queue.set(key, at, number)
            plain[key] = (at, number)
        elif step == "discard":
            queue.discard(key)
            plain.pop(key, None)
        else:
            due = min(
                (entry for entry in plain.items() if math.inf > entry[1][0] <= at),
                key=lambda entry: entry[1],
                default=None,
            )
            assert queue.pop(at) == (None if due is None else (due[0], due[1][1]))
            if due is not None:
                del plain[due[0]]
        assert len(queue) == len(plain)
        assert [queue.time_of(one) for one in "abcd"] == [plain.get(one, (None,))[0] for one in "abcd"]
        times = [entry_at for entry_at, _ in plain.values() if entry_at < math.inf]
        assert queue.earliest <= min(times, default=math.inf)
        assert queue.next() == min(times, default=None)
        assert queue.earliest == min(times, default=math.inf)
    finite = {key: entry for key, entry in plain.items() if entry[0] < math.inf}
    assert empty(queue) == [(key, number) for key, (_, number) in sorted(finite.items(), key=lambda entry: entry[1])]


def test_what_is_put_off_for_ever_is_never_due() -> None:
    queue: TimerQueue[str, int] = TimerQueue()
    queue.set("a", 1.0, 0)
    queue.set("a", math.inf, 1)
    for number in range(100):  # the heap is made anew
        queue.set(f"{number}", 1.0, 0)
        queue.discard(f"{number}")
    assert queue.time_of("a") == math.inf
    assert queue.next() is None
    assert queue.pop() is None
    queue.set("a", 2.0, 2)
    assert queue.pop() == ("a", 2)


def test_it_stays_small_however_often_times_move() -> None:
    queue: TimerQueue[str, int] = TimerQueue()
    for number in range(10_000):
        queue.set("a", -float(number), 0)  # always earlier, so that each is a new entry
        queue.set(f"{number}", 1.0, 0)
        queue.discard(f"{number}")
    assert len(queue) == 1
    assert len(queue._heap) <= 2 + 64 + 1
    assert empty(queue) == [("a", 0)]
