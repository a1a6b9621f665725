"""A flat in which somebody comes and goes, for the tests of the apps; its devices announce their rooms."""

from collections.abc import Iterable, MutableMapping
from typing import Any

from homebot.house import World
from homebot.house.description import parse_world

Table = dict[str, object]


def lamp(room: str, **more: object) -> Table:
    return {"kind": "lamp", "room": room, **more}


def motion(room: str, **more: object) -> Table:
    return {"kind": "motion", "room": room, **more}


def flat(*habits: tuple[str, str], by_hand: bool = False, **devices: Table) -> World:
    """A hall with a study and a kitchen behind it, and Anna, who is out until her first habit."""
    return parse_world(
        {
            "house": {"seed": 1, "dialect": "homeassistant", "by_hand": by_hand},
            "rooms": {
                "hall": {"x": 0.0, "y": 0.0, "window": 0.0, "doors": ["outside"]},
                "study": {"x": 5.0, "y": 0.0, "window": 0.0, "doors": ["hall"]},
                "kitchen": {"x": 0.0, "y": 5.0, "window": 0.05, "doors": ["hall"]},
            },
            "devices": devices,
            "people": {
                "anna": {
                    "starts_in": "outside",
                    "asleep": False,
                    "day": [{"at": at, "room": room} for at, room in habits],
                }
            },
        },
        "flat",
    )


def hall(*habits: tuple[str, str], by_hand: bool = False, **devices: Table) -> World:
    """The flat with a lamp and a motion sensor in its hall, and further *devices*."""
    return flat(*habits, by_hand=by_hand, **{"hall_lamp": lamp("hall"), "hall_motion": motion("hall")} | devices)


def warnings(lines: Iterable[MutableMapping[str, Any]]) -> list[str]:
    """The messages about commands that were not obeyed, of the captured *lines* of a log."""
    return [one["message"] for one in lines if one["event"] == "control.command" and one["log_level"] == "warning"]


def is_on(world: World, device: str) -> bool:
    return world.devices[device].device.state() not in {"off", "0"}
