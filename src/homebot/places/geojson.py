"""GeoJSON as the table ``[places]``: polygons are rooms, lines doors, and points devices. Pure.

Source: RFC 7946, and IMDF 1.0 (OGC 20-094), whose units are rooms, and openings doors. RFC 7946 knows degrees alone;
a drawing in metres is told by its extent, or by the member ``"homebot": {"units": "m"}``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import TypeAlias, cast

from homebot.errors import ConfigError
from homebot.places.floor_plan import FloorPlan
from homebot.places.plan import OUTSIDE, HousePlan, HouseRoom, Point, Rings
from homebot.support.strict_json import parse_strict

__all__ = ["geojson_table"]

_Table: TypeAlias = dict[str, object]
_Convert: TypeAlias = Callable[[object, str], Point]

_DEGREE = 111_195.0
"""Metres of a degree of latitude."""

_LARGEST_DEGREES, _LEAST_METRES = 0.02, 1.5
_REACH = 0.3
_ROOMS, _DOORS = {"", "unit"}, {"", "opening"}
"""The types of IMDF's features; those of other files are empty."""


def geojson_table(text: str, source: str) -> Mapping[str, object]:
    """Return the table ``[places]`` of a GeoJSON file.

    Raises:
        ConfigError: It is none, or lacks something; names the place and the value.
    """
    try:
        document = parse_strict(text)
    except (ValueError, RecursionError) as exc:
        raise ConfigError(source, "", f"is no JSON: {exc}") from exc
    features = document.get("features") if isinstance(document, dict) else None
    if not isinstance(features, list) or not all(isinstance(one, dict) for one in features):
        raise ConfigError(source, "features", "must be an array: GeoJSON is an object with an array of features")
    file = _File(cast("_Table", document), cast("list[_Table]", features), source)
    return {"rooms": file.rooms(), "doors": [*file.doors()], "devices": dict(file.devices())}


class _File:
    """The features of a file, in metres."""

    def __init__(self, document: _Table, features: list[_Table], source: str) -> None:
        self._source = source
        self._features = [(f"features.{index}", one) for index, one in enumerate(features)]
        self._levels = {str(one.get("id")): _name(one) for one in features if one.get("feature_type") == "level"}
        self._convert = self._converter(document.get("homebot", {}))
        self._plan = HousePlan(source, source=source)

    def rooms(self) -> dict[str, _Table]:
        """Return the tables of rooms."""
        found: dict[str, _Table] = {}
        for key, feature, kind, coordinates in self._of(_ROOMS, "Polygon", "MultiPolygon"):
            if not (name := _name(feature)):
                raise ConfigError(self._source, f"{key}.properties.name", "is missing: the name of the room")
            several = coordinates if kind == "MultiPolygon" else [coordinates]
            areas = [[self._points(ring, key) for ring in _list(one)] for one in _list(several)]
            room = found.setdefault(name, {"floor": self._floor(feature), "polygon": []})
            cast("list[object]", room["polygon"]).extend(areas)
        self._plan = HousePlan(self._source, [_room(name, one) for name, one in found.items()], self._source)
        return found

    def doors(self) -> Iterator[_Table]:
        """Yield the tables of doors, whose rooms are the nearest if none are stated; call :meth:`rooms` before."""
        for key, feature, _, coordinates in self._of(_DOORS, "LineString"):
            ends = self._points(coordinates, key)
            if len(ends) != 2:
                raise ConfigError(self._source, f"{key}.geometry", f"a door has two ends, and this line {len(ends)}")
            given = _properties(feature)
            door: _Table = {one: given[one] for one in ("contact", "lock", "cost", "rooms") if one in given}
            middle = (ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2
            if "rooms" not in door:
                door["rooms"] = self._rooms_at(middle, self._floor(feature), key)
            yield {"name": _name(feature), "position": ends, **door}

    def devices(self) -> Iterator[tuple[str, _Table]]:
        """Yield the tables of devices, by id."""
        for key, feature, _, coordinates in self._of({""}, "Point"):
            given = _properties(feature)
            if isinstance(device := given.get("device"), str):
                table: _Table = {"at": [*self._convert(coordinates, key)], "floor": self._floor(feature)}
                yield device, table | {one: given[one] for one in ("error", "room") if one in given}

    def _of(self, types: set[str], *kinds: str) -> Iterator[tuple[str, _Table, str, object]]:
        for key, feature in self._features:
            geometry = feature.get("geometry")
            if isinstance(geometry, dict) and feature.get("feature_type", "") in types:
                kind = geometry.get("type")
                if kind in kinds:
                    yield key, feature, cast("str", kind), geometry.get("coordinates")

    def _points(self, value: object, key: str) -> list[Point]:
        points = [self._convert(one, key) for one in _list(value)]
        return points[:-1] if len(points) > 2 and points[0] == points[-1] else points

    def _floor(self, feature: _Table) -> str:
        given = _properties(feature)
        floor = given.get("floor", given.get("level", self._levels.get(str(given.get("level_id")), "")))
        return str(floor)

    def _rooms_at(self, middle: Point, floor: str, key: str) -> list[str]:
        plan = FloorPlan.of(self._plan)
        near = {shape.room for shape in plan.shapes.near(*middle, plan.level(floor))}
        known = sorted((plan.distance(room, *middle), room) for room in near)
        rooms = [room for distance, room in known if distance <= _REACH]
        if len(rooms) < 2:
            at = f"at {rooms[0]} alone" if rooms else f"not within {_REACH} m of a room"
            hint = f'state its "rooms", such as ["{(*rooms, "Hall")[0]}", "{OUTSIDE}"]'
            raise ConfigError(self._source, f"{key}.properties.rooms", f"the door is {at} of this file; {hint}")
        return rooms[:2]

    def _converter(self, stated: object) -> _Convert:
        """Return the function that makes metres of coordinates."""
        settings = stated if isinstance(stated, dict) else {}
        units = settings.get("units") or self._units()
        if units == "m":
            return self._point
        origin, bearing = settings.get("origin"), settings.get("bearing")
        if units != "degrees" or origin is None or not isinstance(bearing, int | float):
            text = 'state "homebot": {"units": "m"}, or {"units": "degrees", "origin": [lon, lat], "bearing": DEGREES}'
            raise ConfigError(self._source, "homebot", f"{text}, where the frame map begins and its y axis points")
        lon, lat = self._point(origin, "homebot.origin")
        east, (c, s) = math.cos(math.radians(lat)), (math.cos(math.radians(bearing)), math.sin(math.radians(bearing)))

        def metres(value: object, key: str) -> Point:
            x, y = self._point(value, key)
            x, y = (x - lon) * _DEGREE * east, (y - lat) * _DEGREE
            return round(x * c - y * s, 4), round(x * s + y * c, 4)

        return metres

    def _units(self) -> str:
        """Return the units that the extent of the file tells: that of a house is under 2 km, or over 1.5 m."""
        geometries = (one.get("geometry") for _, one in self._features)
        points = [*_points_in([one.get("coordinates") for one in geometries if isinstance(one, dict)])]
        extent = max((max(axis) - min(axis) for axis in zip(*points, strict=True)), default=_LEAST_METRES + 1)
        if extent < _LARGEST_DEGREES:
            return "degrees"
        if extent > _LEAST_METRES:
            return "m"
        reason = f'the extent {extent:g} may be degrees or metres; state "homebot": {{"units": "m"}}'
        raise ConfigError(self._source, "homebot", reason)

    def _point(self, value: object, key: str) -> Point:
        found = next(_points_in(value), None)
        if found is None or not isinstance(value, list) or isinstance(value[0], list):
            raise ConfigError(self._source, key, f"{str(value)[:40]} is no position; it is [x, y]")
        return found


def _points_in(value: object) -> Iterator[Point]:
    """Yield the positions in coordinates of any depth."""
    stack = [value]
    while stack:
        one = stack.pop()
        if isinstance(one, list) and len(one) >= 2 and all(isinstance(each, int | float) for each in one):
            yield float(one[0]), float(one[1])
        elif isinstance(one, list):
            stack += one


def _list(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _properties(feature: _Table) -> _Table:
    found = feature.get("properties")
    return found if isinstance(found, dict) else {}


def _name(feature: _Table) -> str:
    """Return the name of a feature; of names by language, as IMDF has them, the first."""
    name = _properties(feature).get("name")
    if isinstance(name, dict):
        name = next(iter(name.values()), "")
    return name if isinstance(name, str) else ""


def _room(name: str, table: _Table) -> HouseRoom:
    areas = cast("list[list[list[Point]]]", table["polygon"])
    polygons: tuple[Rings, ...] = tuple(tuple(tuple(ring) for ring in one) for one in areas)
    return HouseRoom(name, str(table["floor"]), polygons=polygons)
