"""What Python's search for circular garbage costs what serves: counted in objects, for a machine may be busy."""

import gc
from collections.abc import Iterator

import pytest

from homebot.cli.serve import COLLECT_AFTER, on_an_event_loop, short_collections

MOST = 7_500
"""Objects that may be looked at in one go: 0.4 µs each, or 3 ms."""

MOST_OF_OLD = 150_000
"""The same where old objects are looked at, too, or an eighth of all where there are more: 60 ms."""

FULL = COLLECT_AFTER[0] * (COLLECT_AFTER[2] + 2)
"""New objects after which old ones are looked at."""


class Ring:
    """Knows itself."""

    def __init__(self) -> None:
        self.me = self


@pytest.fixture
def collecting() -> Iterator[None]:
    """Collect as ``homebot run`` does, and as if only a house were here."""
    gc.collect()
    gc.freeze()
    with short_collections():
        yield


def rings(*generations: int) -> int:
    return sum(isinstance(one, Ring) for generation in generations for one in gc.get_objects(generation))


def test_what_serves_collects_so_and_leaves_the_collector_as_it_was() -> None:
    async def main() -> tuple[int, int, int]:
        return gc.get_threshold()

    before = gc.get_threshold(), list(gc.callbacks)
    assert on_an_event_loop(main()) == COLLECT_AFTER
    assert (gc.get_threshold(), gc.callbacks) == before


@pytest.mark.usefixtures("collecting")
def test_however_much_comes_to_stay_little_of_it_is_looked_at_in_one_go() -> None:
    looks: list[tuple[int, int]] = []

    def note(phase: str, info: dict[str, int]) -> None:
        if phase == "start":
            generation = info["generation"]
            looks.append((generation, sum(len(gc.get_objects(one)) for one in range(generation + 1))))

    gc.callbacks.append(note)
    try:
        house = [[number] for number in range(700_000)]
    finally:
        gc.callbacks.remove(note)
    assert len(house) == 700_000
    assert {generation for generation, _ in looks} == {1, 2}
    assert max(seen for generation, seen in looks if generation == 1) < MOST
    assert max(seen for _, seen in looks) < max(MOST_OF_OLD, gc.get_freeze_count() / 8)
    assert sum(seen for _, seen in looks) < 3 * len(house)


@pytest.mark.usefixtures("collecting")
def test_circular_garbage_that_grew_old_goes_too() -> None:
    """A connection refers to itself, and lives for minutes: each stayed with its socket for as long as homebot ran."""
    old = [Ring() for _ in range(3 * COLLECT_AFTER[0])]
    more = [[number] for number in range(2 * COLLECT_AFTER[0])]
    assert rings(2) == len(old)
    old.clear()
    more += [[number] for number in range(FULL)]
    assert rings(0, 1, 2) == 0


@pytest.mark.usefixtures("collecting")
def test_what_comes_and_goes_in_a_discovered_house_is_not_lost_to_the_collector() -> None:
    house = [[number] for number in range(700_000)]
    frozen = gc.get_freeze_count()
    for _ in range(30):
        more = [Ring() for _ in range(FULL)]
        assert len(more) == FULL
    assert gc.get_freeze_count() - frozen < 5 * FULL
    assert len(house) == 700_000


@pytest.mark.usefixtures("collecting")
def test_circular_garbage_that_died_young_goes_soon() -> None:
    young = [Ring() for _ in range(100_000)]
    kept = len(young)
    young.clear()
    more = [[number] for number in range(8 * COLLECT_AFTER[0])]
    for _ in range(kept):
        Ring()
    assert len(more) == 8 * COLLECT_AFTER[0]
    assert rings(0, 1) < MOST
