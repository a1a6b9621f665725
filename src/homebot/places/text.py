"""A places file: rooms and devices as the text of a table ``[places]``. Pure."""

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import get_args

from homebot.places.facts import FactName, OwnerFact
from homebot.places.plan import OUTSIDE, WIDTH, HousePlan, HouseRoom
from homebot.support.folding import fold
from homebot.support.toml_text import toml_value


def places_text(plan: HousePlan, devices: Iterable[tuple[str, tuple[OwnerFact, ...], tuple[str, ...]]] = ()) -> str:
    """Return the text of a places file.

    Args:
        plan: The rooms and doors; the rooms of devices are added.
        devices: Id, facts and hardware addresses of each device.
    """
    listed = tuple(devices)
    lines = [f"# Rooms and devices of {toml_value(plan.home)[1:-1]}, for `homebot places import` or a homebot.toml."]
    doors = [door for door in plan.doors if not door.is_plain]
    written = {frozenset(map(fold, door.rooms)) for door in doors}
    for room in _rooms(plan, chain.from_iterable(facts for _, facts, _ in listed)):
        lines += _room(room, written)
    for door in doors:
        values = door._asdict() | {"width": None if door.width == WIDTH else door.width}
        lines += _table(
            "[[places.doors]]", **values | {"position": door.position[0] if len(door.position) == 1 else door.position}
        )
    for device_id, facts, identifiers in listed:
        stated = {name: tuple(fact.value for fact in facts if fact.name == name) for name in get_args(FactName)}
        lines += _table(
            f"[places.devices.{toml_value(device_id)}]",
            room=next(iter(stated["area"]), ""),
            at=next(iter(stated["position"]), ""),
            aliases=stated["name"],
            tags=stated["tag"],
            identifiers=tuple(identifiers),
        )
    return "\n".join(lines) + "\n"


def _rooms(plan: HousePlan, facts: Iterable[OwnerFact]) -> Iterable[HouseRoom]:
    known = {fold(room.name): room for room in plan.rooms}
    for fact in facts:
        if fact.name == "area" and fold(fact.value) != OUTSIDE:
            known.setdefault(fold(fact.value), HouseRoom(fact.value))
    return known.values()


def _room(room: HouseRoom, written: set[frozenset[str]]) -> Iterator[str]:
    """Yield the lines of a room; a door that is *written* at its other end is left out."""
    doors = {frozenset((fold(door), fold(room.name))): door for door in room.doors}
    doors = {ends: door for ends, door in doors.items() if ends not in written}
    written.update(doors)
    polygon: tuple[object, ...] = room.polygons
    while len(polygon) == 1 and isinstance(polygon[0], tuple):
        polygon = polygon[0]
    yield from _table(
        f"[places.rooms.{toml_value(room.name)}]", floor=room.floor, doors=tuple(doors.values()), polygon=polygon
    )


def _table(head: str, **values: object) -> Iterator[str]:
    """Yield the lines of a table, without values that are None or empty."""
    yield ""
    yield head
    yield from (f"{key} = {toml_value(value)}" for key, value in values.items() if value not in {None, "", ()})
