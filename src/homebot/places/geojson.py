"""GeoJSON as the table ``[places]``: polygons are rooms, lines are doors, and points are devices. Pure.

Source: RFC 7946. It only supports degrees; these need ``"homebot": {"origin": [lon, lat], "bearing": DEGREES}``: the
origin of the frame ``map``, and the direction of its y axis. A drawing without an origin is in metres, which it may
state: ``"homebot": {"frame": "map", "units": "m"}``.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TypeAlias, cast

from homebot.errors import ConfigError
from homebot.places.facts import OWNER_ERROR, Position
from homebot.places.floor_plan import FloorPlan
from homebot.places.plan import OUTSIDE, HousePlan, HouseRoom, Point
from homebot.places.settings import read_places
from homebot.support.strict_json import parse_strict

_Table: TypeAlias = dict[str, object]

_DEGREE = 111_195.0
"""Metres of a degree of latitude."""

_MIN_METRES = 1.5


def geojson_table(text: str, source: str, known: Iterable[HouseRoom] = ()) -> Mapping[str, object]:
    """Return the table ``[places]`` of a GeoJSON file, whose doors may lead to *known* rooms.

    Raises:
        ConfigError: It is not GeoJSON, or incomplete; names the key and the value.
    """
    try:
        document = parse_strict(text)
    except (ValueError, RecursionError) as exc:
        raise ConfigError(source, "", f"is not JSON: {exc}") from exc
    features = document.get("features") if isinstance(document, dict) else None
    if not isinstance(features, list) or not all(isinstance(feature, dict) for feature in features):
        raise ConfigError(source, "features", "must be an array: GeoJSON is an object with an array of features")
    file = _File(cast("list[_Table]", features), source, _object(cast("_Table", document), "homebot"), known)
    return {"rooms": file.rooms(), "doors": [*file.doors()], "devices": dict(file.devices())}


class _File:
    """The features of a file, in metres."""

    def __init__(self, features: list[_Table], source: str, settings: _Table, known: Iterable[HouseRoom]) -> None:
        self._source = source
        self._known = tuple(known)
        self._features = [(f"features.{index}", feature) for index, feature in enumerate(features)]
        self._origin: Point | None = None
        self._bearing = 0.0
        self._plan = HousePlan(source, self._known, source)
        if (frame := settings.get("frame", "map")) != "map":
            raise ConfigError(source, "homebot.frame", f"must be map, the frame of the house, got {frame!r}")
        if (units := settings.get("units")) not in (None, "m"):
            raise ConfigError(source, "homebot.units", f"must be m, or absent for degrees, got {units!r:.40}")
        self._is_in_metres = units == "m"
        if settings and not self._is_in_metres:
            self._origin = self._point(settings.get("origin"), "homebot.origin")
            bearing = settings.get("bearing", 0)
            if not isinstance(bearing, int | float) or not math.isfinite(bearing):
                raise ConfigError(source, "homebot.bearing", f"must be degrees from north, got {bearing!r}")
            self._bearing = math.radians(bearing)

    def _name(self, key: str, given: Mapping[str, object]) -> str:
        name = given.get("name")
        if name and isinstance(name, str):
            return name
        problem = f"must be a text, got {name!r:.40}" if name else "is missing: the name of the room"
        raise ConfigError(self._source, f"{key}.properties.name", problem)

    def rooms(self) -> dict[str, _Table]:
        tables: dict[str, _Table] = {}
        corners: list[Point] = []
        for key, given, kind, coordinates in self._of("Polygon", "MultiPolygon"):
            name = self._name(key, given)
            several = coordinates if kind == "MultiPolygon" else [coordinates]
            areas = [[self._points(ring, key) for ring in _list(polygon)] for polygon in _list(several)]
            room = tables.setdefault(name, {"floor": _floor(given), "polygon": []})
            if room["floor"] != _floor(given):
                problem = f"is on floor {room['floor']!r} already; give one of the two rooms another name"
                raise ConfigError(self._source, f"{key}.properties.name", f"{name!r} {problem}")
            cast("list[object]", room["polygon"]).extend(areas)
            corners += [corner for area in areas for ring in area for corner in ring]
        if (
            corners
            and not self._is_in_metres
            and max(max(axis) - min(axis) for axis in zip(*corners, strict=True)) < _MIN_METRES
        ):
            hint = 'if they are degrees, state "homebot": {"origin": [lon, lat], "bearing": DEGREES}'
            raise ConfigError(self._source, "homebot", f"the rooms extend less than {_MIN_METRES} m; {hint}")
        rooms = read_places({"rooms": tables}, self._source, self._source, "").rooms
        self._plan = HousePlan(self._source, (*self._known, *rooms), self._source)
        return tables

    def doors(self) -> Iterator[_Table]:
        """Yield the tables of doors, which lead to the nearest rooms by default; call :meth:`rooms` first."""
        for key, given, _, coordinates in self._of("LineString"):
            ends = self._points(coordinates, key)
            if len(ends) != 2:
                raise ConfigError(self._source, f"{key}.geometry", f"a door has two ends, this line has {len(ends)}")
            middle = (ends[0][0] + ends[1][0]) / 2, (ends[0][1] + ends[1][1]) / 2
            rooms = given.get("rooms") or self._rooms_at(middle, _floor(given), key)
            more = {key: given[key] for key in ("name", "contact", "lock", "cost") if given.get(key) is not None}
            yield {"rooms": rooms, "position": ends, **more}

    def devices(self) -> Iterator[tuple[str, _Table]]:
        for key, given, _, coordinates in self._of("Point"):
            if isinstance(device := given.get("device"), str):
                error = given.get("error", OWNER_ERROR)
                if not isinstance(error, int | float):
                    raise ConfigError(self._source, f"{key}.properties.error", f"must be metres, got {error!r}")
                at = Position(*self._point(coordinates, key), _floor(given), error)
                yield device, {"at": at.text} | {key: given[key] for key in ("room",) if key in given}

    def _of(self, *kinds: str) -> Iterator[tuple[str, _Table, str, object]]:
        """Yield key, properties, kind and coordinates of the features of *kinds*."""
        for key, feature in self._features:
            geometry = _object(feature, "geometry")
            if (kind := geometry.get("type")) in kinds:
                yield key, _object(feature, "properties"), kind, geometry.get("coordinates")

    def _points(self, value: object, key: str) -> list[Point]:
        points = [self._point(item, key) for item in _list(value)]
        return points[:-1] if len(points) > 2 and points[0] == points[-1] else points

    def _rooms_at(self, middle: Point, floor: str, key: str) -> list[str]:
        rooms = FloorPlan.of(self._plan).rooms_beside(*middle, floor)[:2]
        if len(rooms) < 2:
            at = f"only at {rooms[0]}" if rooms else "at no room"
            hint = f'state its "rooms", such as ["{(*rooms, "Hall")[0]}", "{OUTSIDE}"]'
            raise ConfigError(self._source, f"{key}.properties.rooms", f"the door is {at}; {hint}")
        return rooms

    def _point(self, value: object, key: str) -> Point:
        if (
            not isinstance(value, list)
            or len(value) < 2
            or not all(isinstance(number, int | float) for number in value)
        ):
            raise ConfigError(self._source, key, f"{str(value)[:40]} is not a position [x, y]")
        x, y = float(value[0]), float(value[1])
        if self._origin is None:
            return x, y
        lon, lat = self._origin
        east, north = (x - lon) * _DEGREE * math.cos(math.radians(lat)), (y - lat) * _DEGREE
        c, s = math.cos(self._bearing), math.sin(self._bearing)
        return round(east * c - north * s, 4), round(east * s + north * c, 4)


def _object(table: _Table, key: str) -> _Table:
    value = table.get(key)
    return value if isinstance(value, dict) else {}


def _list(value: object) -> list[object]:
    return value if isinstance(value, list) else []


def _floor(properties: _Table) -> str:
    stated = (properties.get(key) for key in ("floor", "level"))
    return next((str(floor) for floor in stated if floor is not None), "")
