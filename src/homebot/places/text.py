"""A places file: rooms and devices as the text of a table ``[places]``. Pure.

Source of the syntax: TOML 1.0, https://toml.io/en/v1.0.0.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator

from homebot.places.facts import OWNER_ERROR, OwnerFact, position_of
from homebot.places.plan import OUTSIDE, WIDTH, HouseDoor, HousePlan, HouseRoom
from homebot.support.folding import fold

__all__ = ["places_text"]


def places_text(plan: HousePlan, devices: Iterable[tuple[str, tuple[OwnerFact, ...], tuple[str, ...]]] = ()) -> str:
    """Return the text of a places file.

    Args:
        plan: The rooms and doors; rooms that devices are in are added.
        devices: Id, facts and hardware addresses of each device.
    """
    listed = tuple(devices)
    known = {fold(room.name): room for room in plan.rooms}
    for _, facts, _ in listed:
        for fact in facts:
            if fact.name == "area" and fold(fact.value) != OUTSIDE:
                known.setdefault(fold(fact.value), HouseRoom(fact.value))
    lines = [f"# Rooms and devices of {_text(plan.home)[1:-1]}, for `homebot places import` or a homebot.toml."]
    doors = [door for door in plan.doors if not door.is_plain]
    written = {frozenset(map(fold, door.rooms)) for door in doors}
    for room in known.values():
        lines += _room(room, written)
    for door in doors:
        lines += _door(door)
    for device_id, facts, identifiers in listed:
        lines += _device(device_id, facts, identifiers)
    return "\n".join(lines) + "\n"


def _room(room: HouseRoom, written: set[frozenset[str]]) -> Iterator[str]:
    """Yield the lines of a room; a door that is *written* at its other end is left out."""
    yield ""
    yield f"[places.rooms.{_text(room.name)}]"
    if room.floor:
        yield f"floor = {_text(room.floor)}"
    doors = [door for door in room.doors if frozenset((fold(door), fold(room.name))) not in written]
    if doors:
        written.update(frozenset((fold(door), fold(room.name))) for door in doors)
        yield f"doors = {_texts(doors)}"
    if room.polygons:
        several: object = room.polygons if len(room.polygons) > 1 else room.polygons[0]
        yield f"polygon = {json.dumps(room.polygons[0][0] if several == room.polygons[0][:1] else several)}"


def _door(door: HouseDoor) -> Iterator[str]:
    yield ""
    yield f"[places.doors.{_text(door.name)}]"
    yield f"rooms = {_texts(door.rooms)}"
    if door.position:
        yield f"position = {json.dumps(door.position if len(door.position) > 1 else door.position[0])}"
    if door.width != WIDTH:
        yield f"width = {door.width!r}"
    if door.contact:
        yield f"contact = {_text(door.contact)}"
    if door.lock:
        yield f"lock = {_text(door.lock)}"
    if door.cost is not None:
        yield f"cost = {door.cost!r}"


def _device(device_id: str, facts: Collection[OwnerFact], identifiers: Iterable[str]) -> Iterator[str]:
    yield ""
    yield f"[places.devices.{_text(device_id)}]"
    values = {name: [fact.value for fact in facts if fact.name == name] for name in ("area", "name", "tag")}
    yield from (f"room = {_text(room)}" for room in values["area"])
    if (position := position_of(facts)) is not None:
        yield f"at = [{position.x!r}, {position.y!r}]"
        if position.error != OWNER_ERROR:
            yield f"error = {position.error!r}"
        if position.floor:
            yield f"floor = {_text(position.floor)}"
    if values["name"]:
        yield f"aliases = {_texts(values['name'])}"
    if values["tag"]:
        yield f"tags = {_texts(values['tag'])}"
    if known := tuple(identifiers):
        yield f"identifiers = {_texts(known)}"


def _texts(values: Iterable[str]) -> str:
    return f"[{', '.join(map(_text, values))}]"


def _text(value: str) -> str:
    """Return *value* as a basic string: JSON's spelling, but that TOML allows no raw DEL."""
    text = value.encode(errors="replace").decode()  # half a surrogate pair is no text
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
