"""``homebot places``: ``list``, ``rename``, ``remove``, ``export`` and ``import``."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, cast

from homebot.cli.arguments import add_verb, add_verbs, set_client_command
from homebot.cli.device_json import json_text
from homebot.cli.device_queries import all_devices
from homebot.cli.door_client import DoorClient, set_door_command, with_client
from homebot.cli.terminal import print_rows, print_table
from homebot.devices.names import CHANGE_ROOM, EXPORT_PLACES, GET_PLACES, IMPORT_PLACES
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import LinkError, PeerError, UsageError
from homebot.places import HousePlan, places_text, read_position
from homebot.places.polygon import Polygon
from homebot.plugins import check_extra
from homebot.support.folding import fold
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.cli.robot_map import RobotMap
    from homebot.devices import Device
    from homebot.devices.places_messages import (
        ChangeRoomResponse,
        ExportPlacesResponse,
        GetPlacesResponse,
        ImportPlacesResponse,
    )

_HEAD = ("ROOM", "FLOOR", "DOORS", "DEVICES")
_MAX_BYTES = 800_000
_MAX_NAMED = 5
_MAP = "/map"
_WAIT = 10.0
"""Seconds to wait for a robot's map."""

_LIST = """\
  homebot places list
  homebot places list --json

Rooms come from the configuration, imported files and devices. `homebot find 'in ROOM'` lists the devices of a room or a
floor.
"""
_EDIT = """\
  homebot places rename Attic 'Guest room'
  homebot places remove Attic

Devices that you placed in a room stay in it when it is renamed; a room that devices announce keeps its name. Change
rooms of the configuration in that file.
"""
_EXPORT = """\
  homebot places export house.toml

The file contains the rooms, and the rooms, aliases and tags that you gave devices, with their hardware addresses.
Another homebot can import it; its content may also be part of a homebot.toml.
"""
_IMPORT = """\
  homebot places import house.toml
  homebot places import house.toml --replace

  homebot places import house.geojson
  homebot places import map.yaml --room Hall=1,2 --room Kitchen=6,2.5

An import only adds facts; existing ones are kept. If the file has a mistake, nothing is imported. In GeoJSON, polygons
with a `name` are rooms, lines are doors, and points with a `device` are positions. A robot's map, from map_server
(YAML) or on a topic /map, has walls but no rooms: a room is the free area around a point, up to the doors with both
ends in [places].
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, f"{_LIST.partition(chr(10))[0]}\n  homebot places export house.toml\n")
    listed = add_verb(verbs, "list", "list the rooms of the house")
    set_door_command(listed, _list, _LIST)
    listed.add_argument(
        "--json", action="store_true", help="print a JSON object: home, rooms, doors, positions, absent devices"
    )
    rename = add_verb(verbs, "rename", "rename an imported room, or one in which devices were placed")
    set_door_command(rename, _edit, _EDIT, acts=True)
    rename.add_argument("room", metavar="ROOM", help="the room")
    rename.add_argument("name", metavar="NAME", help="its new name")
    remove = add_verb(verbs, "remove", "remove an imported room")
    set_door_command(remove, _edit, _EDIT, acts=True)
    remove.add_argument("room", metavar="ROOM", help="the room; no device may be placed in it")
    remove.set_defaults(name="")
    export = add_verb(verbs, "export", "write the rooms, and your facts about devices, to a file")
    set_door_command(export, _export, _EXPORT)
    export.add_argument(
        "file", nargs="?", default="-", metavar="FILE", help="the file; - for standard output (default)"
    )
    imported = add_verb(verbs, "import", "import the rooms, and facts about devices, from a file")
    set_client_command(imported, _import, _IMPORT, acts=True)
    imported.add_argument(
        "file", metavar="FILE", help="the file; - for standard input, /map or /NAME/map for a robot's map"
    )
    imported.add_argument(
        "--room", action="append", default=[], metavar="ROOM=X,Y", help="a point in a room of a map; repeatable"
    )
    imported.add_argument(
        "--replace", action="store_true", help="if the file has another room for a device, use that of the file"
    )


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    answer = door.call(GET_PLACES, {})
    places = cast("GetPlacesResponse", JsonMessage(answer))
    devices = all_devices(door, lambda device: (device.id, device.area, _position(device)))
    rooms = _rooms(places, [area for _, area, _ in devices])
    positions = {device_id: position for device_id, _, position in devices if position}
    if options.json:
        absent = [{"device": item.key, "room": item.value} for item in places.absent]
        doors = answer["doors"]
        listing = {"home": places.home, "rooms": rooms, "doors": doors, "absent": absent, "positions": positions}
        print(json_text(listing))
    else:
        placed = [(printable(device.key), printable(device.value)) for device in places.absent]
        if rooms:
            rows = [(room["name"], room["floor"], ", ".join(room["doors"]), str(room["devices"])) for room in rooms]
            print_table(_HEAD, rows, if_any=("FLOOR", "DOORS"))
        elif not placed:
            print("no room is known; state some with `homebot place DEVICE ROOM` or [places] in the configuration")
        print_rows(placed, "placed, but absent:")
        print_rows([(printable(name), printable(at)) for name, at in positions.items()], "positions:")
    return 0


def _position(device: Device) -> str:
    return next((fact.value for fact in device.facts if fact.name in {"position", "txt_position"}), "")


class _Room(TypedDict):
    name: str
    floor: str
    doors: list[str]
    devices: int
    areas: list[object]


def _rooms(places: GetPlacesResponse, areas: Iterable[str]) -> list[_Room]:
    """Return the stated rooms, followed by those that only devices announce."""
    named = [area for area in areas if area]
    counts = Counter(map(fold, named))
    announced = {fold(area): area for area in reversed(named)}  # in the spelling of the first device
    rooms: list[_Room] = []
    for room in places.rooms:
        announced.pop(fold(room.name), None)
        count = counts[fold(room.name)]
        shape: list[object] = [{"x": [*area.x], "y": [*area.y], "is_hole": area.is_hole} for area in room.areas]
        rooms.append({"name": room.name, "floor": room.floor, "doors": [*room.doors], "devices": count, "areas": shape})
    return rooms + [
        {"name": name, "floor": "", "doors": [], "devices": counts[key], "areas": []}
        for key, name in sorted(announced.items())
    ]


def _edit(door: DoorClient, options: argparse.Namespace) -> int:
    answer = cast("ChangeRoomResponse", door.ask(CHANGE_ROOM, {"room": options.room, "name": options.name}))
    became = f"called {printable(answer.name)} now" if answer.name else "removed"
    print(f"{printable(options.room)} is {became}")
    if answer.name and fold(answer.name) != fold(options.room) and (left := _devices_in(door, options.room)):
        named = ", ".join(map(printable, left[:_MAX_NAMED])) + (", …" if len(left) > _MAX_NAMED else "")
        print(f"devices that announce {printable(options.room)} stay there until `homebot place` moves them: {named}")
    return 0


def _devices_in(door: DoorClient, room: str) -> list[str]:
    devices = all_devices(door, lambda device: (device.id, device.area))
    return [device_id for device_id, area in devices if fold(area) == fold(room)]


def _export(door: DoorClient, options: argparse.Namespace) -> int:
    text = cast("ExportPlacesResponse", JsonMessage(door.call(EXPORT_PLACES, {}))).text
    if options.file == "-":
        print(text, end="")
        return 0
    try:
        Path(options.file).write_text(text, encoding="utf-8")
    except OSError as exc:
        raise UsageError(f"{options.file} cannot be written: {exc.strerror or exc}") from exc
    print(f"wrote {options.file}")
    return 0


def _import(options: argparse.Namespace) -> int:
    is_map = _is_topic(options.file) or options.file.endswith((".yaml", ".yml"))
    if is_map and not options.room:
        raise UsageError("a map has walls and no rooms; give a point in each room: --room Hall=1,2")
    if options.room and not is_map:
        raise UsageError("--room is for the map of a robot, such as map.yaml or /map")
    points = dict(map(_room_point, options.room))
    text = "" if is_map else _read(options.file)

    def run(door: DoorClient, _: argparse.Namespace) -> int:
        request = {"text": _map_text(door, options.file, points) if is_map else text, "replaces": options.replace}
        try:
            answer = cast("ImportPlacesResponse", door.ask(IMPORT_PLACES, request))
        except PeerError as exc:
            raise PeerError(f"{options.file}: {exc}") from exc
        for line in answer.added:
            print(f"imported {printable(line)}")
        for line in answer.kept:
            print(f"kept: {printable(line)}")
        if answer.kept:
            print("use --replace to use the rooms of the file")
        if not answer.added and not answer.kept:
            print("everything in the file is already known")
        return 0

    return with_client(options, run)


def _room_point(text: str) -> tuple[str, tuple[float, float]]:
    name, is_given, at = text.rpartition("=")
    if not is_given or not name:
        raise UsageError(f"{text!r} is not a point in a room; write ROOM=X,Y in metres, such as Hall=1,2")
    position = read_position(at)
    return name, (position.x, position.y)


def _is_topic(file: str) -> bool:
    return file.startswith("/") and file.endswith(_MAP) and not Path(file).is_file()


def _map_text(door: DoorClient, file: str, points: Mapping[str, tuple[float, float]]) -> str:
    doors = cast("GetPlacesResponse", JsonMessage(door.call(GET_PLACES, {}))).doors
    rooms = [
        *_map(door, file).rooms(
            points, [[*zip(outline.x, outline.y, strict=True)] for outline in doors if len(outline.x) > 1]
        )
    ]
    for room in rooms:
        print(f"{printable(room.name)} has {Polygon(room.polygons[0][0]).area:.1f} m²")
    return places_text(HousePlan("a map", rooms))


def _map(door: DoorClient, file: str) -> RobotMap:
    check_extra("a map", "maps", "PIL", "yaml")
    from homebot.cli.robot_map import RobotMap, read_map  # noqa: PLC0415 - with the first map

    if _is_topic(file):
        door.subscribe(file)
        received = next((message for message in door.until(_WAIT) if message.topic == file), None)
        if received is None:
            raise LinkError(f"no map was published on {file}; start the robot's map_server, or give a FILE")
        robot_map = RobotMap.of(received.message)
    else:
        robot_map, warning = read_map(file)
        if warning:
            print(f"warning: {printable(warning)}")
    width, height = robot_map.cells.size
    print(f"the map has {width} x {height} cells of {robot_map.resolution:g} m")
    return robot_map


def _read(file: str) -> str:
    try:
        with nullcontext(sys.stdin.buffer) if file == "-" else Path(file).open("rb") as opened:
            content = opened.read(_MAX_BYTES + 1)
        if len(content) > _MAX_BYTES:
            raise UsageError(f"{file} is larger than {_MAX_BYTES // 1000} kB")
        return content.decode("utf-8-sig")
    except OSError as exc:
        raise UsageError(f"{file} cannot be read: {exc.strerror or exc}") from exc
    except UnicodeDecodeError as exc:
        raise UsageError(f"{file} cannot be read: it is not UTF-8 text") from exc
