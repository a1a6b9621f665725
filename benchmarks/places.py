"""The processor time of the room at a position, in houses of three sizes."""

from __future__ import annotations

import time
from collections.abc import Callable
from random import Random

from homebot.places import FloorPlan, HousePlan, HouseRoom
from plan import Plan
from report import Report, verdict
from rounds import median

__all__ = ["run"]

HEADINGS = ("rooms", "position -> room", "aim", "")
AIM = 50e-6
SIZES = (12, 100, 1000)
SIDE = 4.0
COLUMNS = 32
POINTS = 2000
ROUNDS = 5


def run(plan: Plan) -> Report:
    rows = [HEADINGS, *(_row(size, plan.rounds(ROUNDS)) for size in SIZES)]
    return Report("Places: microseconds of the processor for a position, among square rooms of 4 m", (), (), rows)


def _row(size: int, rounds: int) -> tuple[str, ...]:
    floor_plan = FloorPlan.of(HousePlan("Home", map(_room, range(size))))
    random = Random(size)
    right, top = min(size, COLUMNS) * SIDE, (size / COLUMNS + 1) * SIDE
    points = [(random.uniform(0, right), random.uniform(0, top)) for _ in range(POINTS)]
    one = _each(floor_plan.room_at, points, rounds)
    return str(size), f"{one * 1e6:.1f} µs", f"<= {AIM * 1e6:.0f} µs", verdict(one <= AIM)


def _room(index: int) -> HouseRoom:
    x, y = index % COLUMNS * SIDE, index // COLUMNS * SIDE
    return HouseRoom(f"Room {index}", polygons=((((x, y), (x + SIDE, y), (x + SIDE, y + SIDE), (x, y + SIDE)),),))


def _each(ask: Callable[[float, float], object], points: list[tuple[float, float]], rounds: int) -> float:
    """Return the seconds that each call takes, as the median of the rounds."""
    found = []
    for _ in range(rounds):
        started = time.process_time()
        for x, y in points:
            ask(x, y)
        found.append((time.process_time() - started) / len(points))
    return median(found)
