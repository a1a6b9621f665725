"""The room at a point, against golden cases."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from homebot.places.polygon import Polygon
from homebot.places.room_shapes import RoomShape, RoomShapes

GOLDEN = json.loads((Path(__file__).parent / "data/room_cases.json").read_text())
SHAPES = {name: Polygon(one["polygon"], one.get("holes", ())) for name, one in GOLDEN["rooms"].items()}
ROOMS = RoomShapes(RoomShape(name, "", shape) for name, shape in SHAPES.items())


@pytest.mark.parametrize("case", GOLDEN["cases"], ids=lambda one: f"{one['x']},{one['y']}")
def test_a_point_is_in_the_smallest_room_that_holds_it_or_near_one(case: dict[str, Any]) -> None:
    found = ROOMS.room_at(case["x"], case["y"])

    assert (None if found is None or found.is_nearest else found.room) == case["room"]
    assert (None if found is None else found.room) == case["nearest"]
    distance = min(shape.border_distance(case["x"], case["y"]) for shape in SHAPES.values())
    assert distance == pytest.approx(case["border_m"], abs=1e-6)


def test_a_room_is_found_on_its_floor_alone() -> None:
    upstairs = RoomShapes([RoomShape("Attic", "Upstairs", SHAPES["Hall"])])

    assert upstairs.room_at(1, 1) is None
    found = upstairs.room_at(1, 1, "Upstairs")
    assert found is not None
    assert found.room == "Attic"
