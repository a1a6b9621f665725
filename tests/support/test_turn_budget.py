"""Turn budget: whatever is asked of a server, its share of one turn is bounded, and each client has its part of it."""

from collections.abc import Callable, Iterator

import pytest

from homebot.support.turn_budget import SHARE, TurnBudget


class Loop:
    """An event loop without one: its turns, and a clock that goes on with the work alone.

    Args:
        slowness: Times longer that a slow computer takes for a piece of work of 0.1 ms.
    """

    def __init__(self, slowness: float = 1.0) -> None:
        self.now = 0.0
        self.budget = TurnBudget(lambda: self.now, self._call_soon)
        self._slowness = slowness
        self._ready: list[Callable[[], None]] = []

    def work(self) -> None:
        self.now += 0.0001 * self._slowness

    def turn(self) -> float:
        """Run what is ready; return how long it took."""
        began, ready = self.now, self._ready
        self._ready = []
        for call in ready:
            call()
        return self.now - began

    def _call_soon(self, call: Callable[[], None]) -> None:
        self._ready.append(call)


class Flood:
    """A client with more work than one turn takes."""

    def __init__(self, loop: Loop, pieces: int) -> None:
        self.left = pieces
        self._loop = loop

    def go_on(self) -> None:
        while self.left:
            self._loop.work()
            self.left -= 1
            if not self._loop.budget.has_time():
                self._loop.budget.defer(self.go_on)
                return

    def begin(self) -> None:
        """Do as a socket does that is read: begin in this turn if there is time."""
        if self._loop.budget.has_time():
            self.go_on()
        else:
            self._loop.budget.defer(self.go_on)


@pytest.mark.parametrize("slowness", [1.0, 2.5, 10.0])
@pytest.mark.parametrize("clients", [1, 16, 48])
def test_the_share_of_a_turn_is_that_of_all_clients_however_slow_the_computer(slowness: float, clients: int) -> None:
    loop = Loop(slowness)
    floods = [Flood(loop, 200) for _ in range(clients)]
    began = loop.now
    for flood in floods:
        flood.begin()
    turns = [loop.now - began]
    while loop.budget.waiting:
        turns.append(loop.turn())
    assert max(turns) < 2 * SHARE + 0.0003 * slowness
    assert sum(turns) == pytest.approx(0.0001 * slowness * 200 * clients)
    assert not any(flood.left for flood in floods)


def test_no_time_is_left_until_the_next_turn_however_late_it_is() -> None:
    loop = Loop()
    assert loop.budget.has_time()
    loop.now += 3600
    assert not loop.budget.has_time()
    loop.turn()
    assert loop.budget.has_time()


def test_the_next_client_is_first_in_the_next_turn() -> None:
    loop = Loop()
    floods = [Flood(loop, 1000) for _ in range(20)]
    for flood in floods:
        flood.begin()
    loop.turn()
    served = [flood.left < 1000 for flood in floods].index(False)
    assert served > 3
    loop.turn()
    assert [flood.left < 1000 for flood in floods[: 2 * served - 1]] == [True] * (2 * served - 1)
    assert not any(flood.left < 1000 for flood in floods[2 * served :])


def test_little_work_of_a_newcomer_waits_behind_the_others_for_one_slice_each() -> None:
    loop = Loop()
    floods = [Flood(loop, 100_000) for _ in range(48)]
    for flood in floods:
        flood.begin()
    honest = Flood(loop, 1)
    honest.begin()
    while honest.left:
        loop.turn()
    assert loop.now < 0.06


def test_what_is_forgotten_is_not_called() -> None:
    loop = Loop()
    called: list[str] = []

    def job() -> None:
        called.append("job")

    loop.budget.defer(job)
    loop.budget.defer(job)
    loop.turn()
    assert called == ["job"]
    loop.budget.defer(job)
    loop.budget.forget(job)
    loop.turn()
    assert called == ["job"]


def test_a_job_that_fails_costs_none_of_the_others() -> None:
    loop = Loop()
    called: list[str] = []

    def fail() -> None:
        raise ValueError("broken")

    def job() -> None:
        called.append("job")

    loop.budget.defer(fail)
    loop.budget.defer(job)
    with pytest.raises(ValueError, match="broken"):
        loop.turn()
    loop.turn()
    assert called == ["job"]


def test_steps_are_taken_in_their_order_and_as_many_in_a_turn_as_there_is_time_for() -> None:
    loop = Loop()
    taken: list[int] = []

    def steps() -> Iterator[None]:
        for number in range(200):
            loop.work()
            taken.append(number)
            yield

    loop.budget.run(steps())
    assert 10 < len(taken) < 60
    while loop.budget.waiting:
        assert loop.turn() < SHARE + 0.0003
    assert taken == list(range(200))
