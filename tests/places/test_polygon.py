"""Polygons: points on shared walls, holes, and shapes that are refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import UsageError
from homebot.places.polygon import Polygon

SQUARE = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0))
HOLE = ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))


def test_rings_turn_the_same_way_in_whatever_order_they_are_given() -> None:
    backwards = Polygon(SQUARE[::-1], [HOLE[::-1]])

    def turned(ring: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        first = ring.index(min(ring))
        return ring[first:] + ring[:first]

    assert [turned(ring) for ring in backwards.rings] == [turned(ring) for ring in Polygon(SQUARE, [HOLE]).rings]
    assert backwards.area == 15.0


def test_a_repeated_corner_counts_once() -> None:
    assert len(Polygon([*SQUARE, SQUARE[0], SQUARE[0]]).rings[0]) == 4


@given(st.integers(0, 40), st.integers(0, 40))
def test_each_point_of_a_tiling_is_in_exactly_one_tile(column: int, row: int) -> None:
    x, y = column / 10, row / 10
    tiles = [Polygon(((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))) for i in range(-1, 6) for j in range(-1, 6)]

    assert sum(tile.contains(x, y) for tile in tiles) == 1


@given(st.floats(-2, 6), st.floats(-2, 6))
def test_the_nearest_point_inside_is_inside_and_no_farther_than_the_border(x: float, y: float) -> None:
    shape = Polygon(SQUARE, [HOLE])

    inside = shape.nearest_inside(x, y)

    away = 0.0 if shape.contains(x, y) else shape.border_distance(x, y)
    assert math.dist((x, y), inside) == pytest.approx(away, abs=0.0011)
    assert shape.contains(*inside) or shape.border_distance(*inside) < 0.0011


def test_the_centroid_of_a_square_is_its_middle() -> None:
    assert Polygon(SQUARE).centroid() == (2.0, 2.0)


@pytest.mark.parametrize(
    ("corners", "problem"),
    [
        (SQUARE[:2], "3 is the least"),
        ((SQUARE[0], SQUARE[1], SQUARE[1], SQUARE[0]), "3 is the least"),
        ((SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]), "cross"),
        (((0.0, 0.0), (0.05, 0.0), (0.05, 0.05)), "area"),
        (((0.0, 0.0), (math.nan, 0.0), (1.0, 1.0)), "corner nan"),
        (((0.0, 0.0), (math.inf, 0.0), (1.0, 1.0)), "10,000 m"),
        (((0.0, 0.0), (20_000.0, 0.0), (1.0, 1.0)), "10,000 m"),
        ([(math.cos(n / 200), math.sin(n / 200)) for n in range(1200)], "1,000 is the limit"),
    ],
)
def test_a_shape_that_is_no_room_is_refused(corners: tuple[tuple[float, float], ...], problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        Polygon(corners)
