"""What Python's search for circular garbage costs what serves: counted in objects, for a machine may be busy."""

import gc
from collections.abc import Iterator

import pytest

from homebot.cli.main import main
from homebot.cli.serve import COLLECT_AFTER

MOST = 7_500
"""Objects that may be looked at in one go: 0.4 µs each, or 3 ms."""


@pytest.fixture
def collecting() -> Iterator[None]:
    """Collect as ``homebot run`` does."""
    before = gc.get_threshold()
    gc.collect()
    gc.set_threshold(*COLLECT_AFTER)
    yield
    gc.set_threshold(*before)


def test_the_broker_alone_looks_as_seldom(capsys: pytest.CaptureFixture[str]) -> None:
    before = gc.get_threshold()
    try:
        assert main(["broker", "--listen", "127.0.0.1:0", "--for", "0.01"]) == 0
        assert gc.get_threshold() == COLLECT_AFTER
    finally:
        gc.set_threshold(*before)
    assert "listening" in capsys.readouterr().err


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
    assert {generation for generation, _ in looks} == {1}
    assert max(seen for _, seen in looks) < MOST


@pytest.mark.usefixtures("collecting")
def test_circular_garbage_that_died_young_goes_soon() -> None:
    class Ring:
        """Knows itself."""

        def __init__(self) -> None:
            self.me = self

    rings = [Ring() for _ in range(100_000)]
    kept = len(rings)
    rings.clear()
    more = [[number] for number in range(8 * COLLECT_AFTER[0])]
    for _ in range(kept):
        Ring()
    assert len(more) == 8 * COLLECT_AFTER[0]
    left = sum(isinstance(one, Ring) for generation in (0, 1) for one in gc.get_objects(generation))
    assert left < MOST
