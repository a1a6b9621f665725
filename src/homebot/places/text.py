"""A places file: rooms and devices as the text of a table ``[places]``. Pure.

Source of the syntax: TOML 1.0, https://toml.io/en/v1.0.0.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator

from homebot.places.facts import OwnerFact
from homebot.places.plan import OUTSIDE, HouseRoom
from homebot.support.folding import fold

__all__ = ["places_text"]


def places_text(
    home: str, rooms: Iterable[HouseRoom], devices: Iterable[tuple[str, tuple[OwnerFact, ...], tuple[str, ...]]]
) -> str:
    """Return the text of a places file.

    Args:
        home: The name of the home.
        rooms: The rooms; those that devices are in are added.
        devices: Id, facts and hardware addresses of each device.
    """
    listed = tuple(devices)
    known = {fold(room.name): room for room in rooms}
    for _, facts, _ in listed:
        for fact in facts:
            if fact.name == "area" and fold(fact.value) != OUTSIDE:
                known.setdefault(fold(fact.value), HouseRoom(fact.value))
    lines = [f"# Rooms and devices of {_text(home)[1:-1]}, for `homebot places import` or a homebot.toml."]
    written: set[frozenset[str]] = set()
    for room in known.values():
        lines += _room(room, written)
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


def _device(device_id: str, facts: Iterable[OwnerFact], identifiers: Iterable[str]) -> Iterator[str]:
    yield ""
    yield f"[places.devices.{_text(device_id)}]"
    values = {name: [fact.value for fact in facts if fact.name == name] for name in ("area", "name", "tag")}
    yield from (f"room = {_text(room)}" for room in values["area"])
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
