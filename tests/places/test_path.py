"""Ways through doors: golden distances, closed and locked doors, and the same as by brute force."""

import math
from collections import deque
from collections.abc import Iterable
from heapq import heappop, heappush
from itertools import product
from random import Random

import pytest

from homebot.places.path import Doorway, PathFinder, Spot, Way
from homebot.places.polygon import Point, Polygon
from homebot.places.room_sight import RoomSight

HALL = RoomSight(Polygon(((0, 0), (4, 0), (4, 5), (0, 5))))
KITCHEN = RoomSight(Polygon(((4, 0), (8, 0), (8, 5), (4, 5))))
DOOR = Doorway("Hall-Kitchen", ("Hall", "Kitchen"), (((4.0, 4.5), (4.0, 4.5)),))
ROBOT = Spot("Hall", (3.5, 1.0))


def with_doors(rooms: dict[str, RoomSight], doors: Iterable[Doorway]) -> PathFinder:
    finder = PathFinder(rooms)
    for one in doors:
        finder.add(one)
    return finder


def two_rooms() -> PathFinder:
    finder = with_doors({"Hall": HALL, "Kitchen": KITCHEN}, [DOOR])
    finder.put("kitchen lamp", Spot("Kitchen", (4.5, 1.0)))
    finder.put("hall lamp", Spot("Hall", (1.0, 1.0)))
    return finder


@pytest.mark.parametrize(
    ("extra", "expected"),
    [
        (0.0, [("hall lamp", 2.50), ("kitchen lamp", 7.07)]),
        (3.0, [("hall lamp", 2.50), ("kitchen lamp", 10.07)]),
        (math.inf, [("hall lamp", 2.50)]),
    ],
    ids=["open", "closed", "locked"],
)
def test_the_lamp_behind_the_wall_is_farther_than_the_one_in_the_room(
    extra: float, expected: list[tuple[str, float]]
) -> None:
    """Through the air the lamp in the kitchen is 1 m away."""
    found = [(one.target, round(one.path + one.extra, 2)) for one in two_rooms().nearest(ROBOT, lambda _: extra)]

    assert found == expected


def test_a_route_says_its_doors_and_keeps_their_cost_apart() -> None:
    (_, kitchen) = two_rooms().nearest(ROBOT, lambda _: 3.0)

    assert kitchen.path == pytest.approx(7.071, abs=0.001)
    assert kitchen == Way("kitchen lamp", kitchen.path, 3.0, ("Hall-Kitchen",))


def test_rooms_without_shape_are_four_metres_apart() -> None:
    finder = with_doors({}, [Doorway("a-b", ("a", "b")), Doorway("b-c", ("b", "c"))])
    finder.put("near", Spot("a"))
    finder.put("next", Spot("b"))
    finder.put("far", Spot("c"))

    found = [(one.target, one.path) for one in finder.nearest(Spot("a"), lambda _: 0.0)]

    assert found == [("near", 2.0), ("next", 4.0), ("far", 8.0)]


def test_a_target_that_moves_is_found_at_its_new_place_alone() -> None:
    finder = two_rooms()
    list(finder.nearest(ROBOT, lambda _: 0.0))

    finder.put("hall lamp", Spot("Kitchen", (4.0, 4.4)))
    finder.discard("kitchen lamp")

    assert [one.target for one in finder.nearest(ROBOT, lambda _: 0.0)] == ["hall lamp"]


def way_in(room: RoomSight, start: Point, end: Point) -> float:
    """The length of the way between two points of a room."""
    finder = with_doors({"a": room}, ())
    finder.put("end", Spot("a", end))
    (way,) = finder.nearest(Spot("a", start), lambda _: 0.0)
    return way.path


L_SHAPE = RoomSight(Polygon(((0, 0), (6, 0), (6, 2), (2, 2), (2, 6), (0, 6))))


@pytest.mark.parametrize(
    ("start", "end", "metres"),
    [
        ((1.0, 1.0), (5.0, 1.0), 4.0),
        ((5.0, 1.0), (1.0, 5.0), math.dist((5, 1), (2, 2)) + math.dist((2, 2), (1, 5))),
        ((2.0, 6.0), (6.0, 2.0), 8.0),
    ],
)
def test_a_way_in_a_room_goes_around_its_inward_corners(start: Point, end: Point, metres: float) -> None:
    assert way_in(L_SHAPE, start, end) == pytest.approx(metres)


def test_between_areas_of_a_room_that_do_not_touch_a_straight_line_counts() -> None:
    apart = RoomSight(Polygon(((0, 0), (2, 0), (2, 2), (0, 2))), Polygon(((5, 0), (7, 0), (7, 2), (5, 2))))

    assert way_in(apart, (1.0, 1.0), (6.0, 1.0)) == pytest.approx(5.0)


def test_a_way_goes_around_a_hole() -> None:
    ring = RoomSight(Polygon(((0, 0), (6, 0), (6, 6), (0, 6)), [((2, 2), (4, 2), (4, 4), (2, 4))]))

    assert way_in(ring, (1.0, 3.0), (5.0, 3.0)) == pytest.approx(2 * math.dist((1, 3), (2, 2)) + 2)


def test_a_room_with_many_corners_is_simplified_and_keeps_its_ways() -> None:
    jagged = [(x / 10, 0.05 * (x % 2)) for x in range(100)]
    paths = RoomSight(Polygon([*jagged, (9.9, 4.0), (0.0, 4.0)]))

    assert sum(map(len, paths.areas[0].rings)) <= 30
    assert way_in(paths, (1.0, 2.0), (9.0, 2.0)) == pytest.approx(8.0)


@pytest.mark.parametrize("seed", range(40))
def test_the_order_and_the_distances_equal_those_of_brute_force(seed: int) -> None:
    random = Random(seed)  # noqa: S311 - no secret
    columns, rows = 4, 3
    rooms = {
        f"{i}{j}": Polygon(((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
        for i in range(columns)
        for j in range(rows)
    }
    doors: list[Doorway] = []
    for i in range(columns):
        for j in range(rows):
            at = random.uniform(0.1, 0.9)
            if i + 1 < columns and random.random() < 0.8:
                point = (i + 1.0, j + at)
                doors.append(Doorway(f"{i}{j}>", (f"{i}{j}", f"{i + 1}{j}"), ((point, point),)))
            if j + 1 < rows and random.random() < 0.8:
                point = (i + at, j + 1.0)
                doors.append(Doorway(f"{i}{j}^", (f"{i}{j}", f"{i}{j + 1}"), ((point, point),)))
    costs = {door.name: random.choice((0.0, 0.0, 3.0, math.inf)) for door in doors}
    targets = {}
    for number in range(60):
        i, j = random.randrange(columns), random.randrange(rows)
        targets[f"t{number}"] = Spot(f"{i}{j}", (i + random.random(), j + random.random()))
    finder = with_doors({name: RoomSight(shape) for name, shape in rooms.items()}, doors)
    for name, place in targets.items():
        finder.put(name, place)
    start = Spot("00", (0.5, 0.5))

    found = {one.target: one.path + one.extra for one in finder.nearest(start, costs.__getitem__)}

    assert list(found.values()) == sorted(found.values())
    assert found == pytest.approx(brute_force(start, doors, costs, targets))


def brute_force(
    start: Spot, doors: list[Doorway], costs: dict[str, float], targets: dict[str, Spot]
) -> dict[str, float]:
    """All targets by distance, by going from room to room with a plain Dijkstra over doors."""
    best: dict[tuple[str, str], float] = {}
    assert start.point is not None
    heap: list[tuple[float, str, str]] = []
    by_name = {door.name: door for door in doors}
    for door in doors:
        if start.room in door.rooms:
            heappush(heap, (math.dist(start.point, door.points[0][0]), door.name, start.room))
    found: dict[str, float] = {}
    while heap:
        distance, name, room = heappop(heap)
        if (name, room) in best:
            continue
        best[name, room] = distance
        door = by_name[name]
        point = door.points[0][0]
        (there,) = set(door.rooms) - {room}
        entered = distance + costs[name]
        if math.isinf(entered):
            continue
        for target, place in targets.items():
            if place.room == there and place.point is not None:
                found[target] = min(found.get(target, math.inf), entered + math.dist(point, place.point))
        for other in doors:
            if there in other.rooms and other is not door:
                heappush(heap, (entered + math.dist(point, other.points[0][0]), other.name, there))
    for target, place in targets.items():
        if place.room == start.room and place.point is not None:
            found[target] = min(found.get(target, math.inf), math.dist(start.point, place.point))
    return found


@pytest.mark.parametrize("closed", [0.0, 0.3])
def test_a_search_for_one_target_asks_for_few_doors_and_finds_the_same_way(closed: float) -> None:
    """Of 1,740 doors; otherwise most of them are nearer than it."""
    random, side = Random(1), 30  # noqa: S311 - no secret
    doors: list[Doorway] = []
    for i, j in product(range(side), repeat=2):
        for di, dj in ((1, 0), (0, 1)):
            if max(i + di, j + dj) < side:
                point = (i + 0.5 + di / 2, j + 0.5 + dj / 2)
                doors.append(Doorway(f"{i},{j},{di}", (f"{i},{j}", f"{i + di},{j + dj}"), ((point, point),)))
    costs = {door.name: random.choice((0.0, closed)) for door in doors}
    finder = with_doors({}, doors)
    deque(finder.look_around(), maxlen=0)
    for number in range(100):
        i, j = random.randrange(side), random.randrange(side)
        finder.put(f"t{number}", Spot(f"{i},{j}", (i + random.random(), j + random.random())))
    start = Spot("15,15", (15.5, 15.4))
    expected = {way.target: way.path + way.extra for way in finder.nearest(start, costs.__getitem__)}
    asked: list[str] = []

    def crossing(door: str) -> float:
        asked.append(door)
        return costs[door]

    for target, metres in expected.items():
        way = next(finder.nearest(start, crossing, {target}))
        assert way.path + way.extra == pytest.approx(metres)
    assert len(asked) < len(expected) * len(doors) / 8
