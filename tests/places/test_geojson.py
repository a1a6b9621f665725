"""GeoJSON files: rooms, doors and devices of a drawing in metres, of one in degrees, and of IMDF."""

import json
import math

import pytest

from homebot.errors import ConfigError
from homebot.places import FloorPlan, HousePlan, read_places
from homebot.places.facts import Places, read_position
from homebot.places.geojson import geojson_table


def feature(kind: str, coordinates: object, **properties: object) -> dict[str, object]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}


def square(x: float, y: float, size: float = 4.0) -> list[list[float]]:
    return [[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]]


HOUSE = [
    feature("Polygon", [square(0, 0), square(1, 1, 0.5)], name="Hall", floor="Ground"),
    feature("MultiPolygon", [[square(4, 0)], [square(20, 0)]], name="Kitchen", level="Ground"),
    feature("LineString", [[4, 1], [4, 2]], contact="a contact", cost=1),
    feature("LineString", [[0, 1], [0, 2]], name="Front door", rooms=["Hall", "outside"]),
    feature("Point", [5, 2, 1.5], device="lights/lamp", error=0.2, floor="Ground"),
    feature("Point", [5, 2], name="a tree"),
]


def read(features: list[dict[str, object]], **more: object) -> tuple[Places, HousePlan]:
    text = json.dumps({"type": "FeatureCollection", "features": features, **more})
    places = read_places(geojson_table(text, "house.geojson"), "Home", "house.geojson", "import", 1.0)
    return places, HousePlan("Home", places.rooms, doors=places.doors)


def moved(value: object, lon: float, lat: float, bearing: float) -> object:
    """Return coordinates in metres as degrees, for a house whose y axis points to *bearing*."""
    if not isinstance(value, list):
        return value
    if isinstance(value[0], list):
        return [moved(one, lon, lat, bearing) for one in value]
    angle = math.radians(bearing)
    east = value[0] * math.cos(angle) + value[1] * math.sin(angle)
    north = value[1] * math.cos(angle) - value[0] * math.sin(angle)
    return [lon + east / 111_195 / math.cos(math.radians(lat)), lat + north / 111_195]


def test_polygons_are_rooms_lines_doors_and_points_devices() -> None:
    places, plan = read(HOUSE)

    assert [(room.name, room.floor, len(room.polygons)) for room in plan.rooms] == [
        ("Hall", "Ground", 1),
        ("Kitchen", "Ground", 2),
    ]
    assert len(plan.rooms[0].polygons[0]) == 2  # with a hole
    assert FloorPlan.of(plan).room_at(1.2, 1.2) is not None
    assert [(set(door.rooms), door.contact, door.cost) for door in plan.doors] == [
        ({"Hall", "Kitchen"}, "a contact", 1),
        ({"Hall", "outside"}, "", None),
    ]
    (fact,) = places.devices["lights/lamp",]
    assert (fact.name, read_position(fact.value)[:4]) == ("position", (5.0, 2.0, "Ground", 0.2))


@pytest.mark.parametrize("bearing", [0, 30, -100])
def test_degrees_are_metres_from_the_stated_origin_and_bearing(bearing: float) -> None:
    features = json.loads(json.dumps(HOUSE))
    for one in features:
        one["geometry"]["coordinates"] = moved(one["geometry"]["coordinates"], 16.37, 48.2, bearing)

    _, plan = read(features, homebot={"origin": [16.37, 48.2], "bearing": bearing})

    corners = [corner for rings in plan.rooms[1].polygons for corner in rings[0]]
    expected = [corner for x in (4, 20) for corner in square(x, 0)[:-1]]
    for found, corner in zip(corners, expected, strict=True):
        assert found == pytest.approx(corner, abs=0.001)


def test_a_drawing_may_say_that_it_is_in_metres() -> None:
    _, plan = read([feature("Polygon", [square(0, 0, 1.2)], name="Closet")], homebot={"frame": "map", "units": "m"})
    assert plan.rooms[0].polygons[0][0][2] == (1.2, 1.2)


def test_a_floor_that_is_null_is_none() -> None:
    """Drawing programs write every property of every feature."""
    _, plan = read([feature("Polygon", [square(0, 0)], name="Hall", floor=None, level=None)])
    assert plan.rooms[0].floor == ""


@pytest.mark.parametrize(
    ("features", "more", "key", "reason"),
    [
        ([feature("Polygon", [square(0, 0)])], {}, "features.0.properties.name", "is missing"),
        ([feature("Polygon", [square(0, 0)], name=101)], {}, "features.0.properties.name", "must be a text, got 101"),
        ([], {"homebot": {"units": "ft"}}, "homebot.units", "must be m, or absent for degrees, got 'ft'"),
        ([feature("Polygon", [square(0, 0, 0.001)], name="a")], {}, "homebot", '"origin": [lon, lat]'),
        ([feature("Polygon", [square(0, 0, 0.01)], name="a")], {"homebot": {"origin": 3}}, "homebot.origin", "[x, y]"),
        ([], {"homebot": {"frame": "odom", "units": "m"}}, "homebot.frame", "must be map, the frame of the house"),
        (
            [feature("Polygon", [square(0, 0)], name="a", floor=one) for one in (1, 2)],
            {},
            "features.1.properties.name",
            "is on floor '1'",
        ),
        ([*HOUSE, feature("LineString", [[9, 9], [9, 10]])], {}, "features.6.properties.rooms", "at no room"),
        ([*HOUSE, feature("LineString", [[0, 3], [0, 4]])], {}, "features.6.properties.rooms", '["Hall", "outside"]'),
        ([*HOUSE, feature("LineString", [[4, 1], [4, 2], [4, 3]])], {}, "features.6.geometry", "two ends"),
        ([feature("Polygon", [[[0, 0], ["x", 3], [9, 9]]], name="a")], {}, "features.0", "is not a position"),
        ([feature("Polygon", [square(0, 0)], name="Home")], {}, "places.rooms.Home", "name of the home"),
    ],
)
def test_a_mistake_is_named_by_place_and_value(
    features: list[dict[str, object]], more: dict[str, object], key: str, reason: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        read(features, **more)
    assert caught.value.key == key
    assert reason in caught.value.reason


@pytest.mark.parametrize("text", ['{"type": "Polygon"}', '{"features": {}}', '{"features": [3]}', "{", "{" * 3000])
def test_a_text_without_features_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match=r"features|not JSON"):
        geojson_table(text, "house.geojson")
