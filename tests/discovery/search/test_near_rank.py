"""The best of what is near are those that a look at every device finds, and few devices are looked at for them."""

import math
from random import Random

import pytest

from homebot.discovery.search.near_rank import CostTerm, nearest
from homebot.places.path import Doorway, PathFinder, Spot

DEVICES = 2000
SIDE = 4


def house(random: Random) -> tuple[PathFinder, list[str]]:
    """Return rooms in a square, each joined to its neighbours, with devices all over."""
    doors = [
        Doorway(
            f"{x},{y}-{x + dx},{y + dy}",
            (f"{x},{y}", f"{x + dx},{y + dy}"),
            (((5.0 * (x + dx), 5.0 * (y + dy)), (5.0 * (x + dx), 5.0 * (y + dy))),),
        )
        for x in range(SIDE)
        for y in range(SIDE)
        for dx, dy in ((1, 0), (0, 1))
        if x + dx < SIDE and y + dy < SIDE
    ]
    finder = PathFinder({})
    for door in doors:
        finder.add(door)
    for number in range(DEVICES):
        x, y = random.randrange(SIDE), random.randrange(SIDE)
        finder.put(f"d{number}", Spot(f"{x},{y}", (5 * x + random.random() * 5, 5 * y + random.random() * 5)))
    return finder, [door.name for door in doors]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("within", [math.inf, 6.0])
def test_the_best_are_those_of_brute_force(seed: int, within: float) -> None:
    random = Random(seed)  # noqa: S311
    finder, names = house(random)
    metres = {name: random.choice([0.0, 0.0, 3.0, math.inf]) for name in names}
    locked = frozenset(name for name, cost in metres.items() if math.isinf(cost))
    against = {f"d{number}": random.choice([0.0, 1.0, 4.0]) for number in range(0, DEVICES, 7)}
    asked: list[str] = []

    def terms(device: str) -> tuple[CostTerm, ...]:
        asked.append(device)
        return (CostTerm(against[device], "it is stale"),)

    start = Spot("1,1", (7.0, 8.0))
    total = len(against.keys() - finder.unreachable(start.room, locked))
    found, near = nearest(finder, start, metres.__getitem__, against.keys(), terms, total=total, within=within, limit=5)

    def passing(name: str) -> float:
        return math.inf if name in locked else 0.0

    members = {one.target for one in finder.nearest(start, passing) if one.path <= within} & against.keys()
    costs = [
        one.path + one.extra + against[one.target]
        for one in finder.nearest(start, metres.__getitem__)
        if one.target in members
    ]
    assert near == len(members)
    assert [one.cost for one in found] == pytest.approx(sorted(costs)[:5])
    assert len(asked) < len(members) or len(members) < 30
