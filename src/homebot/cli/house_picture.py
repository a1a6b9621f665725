"""A house and its story as lines for a terminal. Pure."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING, Final, NamedTuple

from homebot.cli.plan_picture import Line, PlanPicture
from homebot.devices.wording.values import life, state_text
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.cli.story import StoryLine
    from homebot.devices import Device

__all__ = ["HousePicture", "Line", "lines_of"]

_WIDE: Final = 70
"""Columns from which on the rooms stand in two columns."""

_LEAST_STORY, _MOST_STORY = 4, 10
"""Lines of the story, as there is room."""

_STORY_BESIDE_PLAN: Final = 6
"""Lines of the story that a plan of the house leaves."""

_STATE: Final = 9
_DIALECT: Final = 13
_TIGHT: Final = 28
"""Lines below which none stays empty."""

_GAP: Final = 2
_LOST: Final = "red"
_STYLES: Final = (("on", "yellow"), ("off", "dim"), ("clear", "dim"))
"""How the beginning of a state is shown."""


class HousePicture(NamedTuple):
    """All that is shown of a house at one moment.

    Attributes:
        story: What happened, oldest first.
    """

    title: str
    hint: str
    devices: Sequence[Device]
    beings: Mapping[str, Sequence[str]]
    story: Sequence[StoryLine]
    plan: PlanPicture


def lines_of(picture: HousePicture, width: int, height: int) -> list[Line]:
    """Return the lines of *picture*, as many as fit in *height*, each to be cut at *width*."""
    is_wide = width >= _WIDE
    column = (width - _GAP) // 2 if is_wide else width
    blocks = [_room(room, devices, picture.beings.get(room, ()), column) for room, devices in _by_room(picture.devices)]
    rooms = _beside(*_halves(blocks), column) if is_wide else [line for block in blocks for line in block]
    plan = _plan(picture, width, height - 3 - len(rooms) - _STORY_BESIDE_PLAN) if is_wide else []
    head: list[Line] = [[(picture.title, "bold")], *([[("", "")]] if height >= _TIGHT and not plan else [])]
    left = height - len(head) - len(plan) - 2
    story = max(_LEAST_STORY, min(_MOST_STORY, left - len(rooms)))
    told = _story(picture.story, width, story)
    return [
        *head,
        *plan,
        *rooms[: max(0, left - story)],
        [("─" * width, "dim")],
        *told,
        *([[("", "")]] * (story - len(told))),
        [(picture.hint, "dim")],
    ]


def _plan(picture: HousePicture, width: int, height: int) -> list[Line]:
    """Return the plan of the house; rooms with a lamp that is on are lit."""
    signs = {room: "".join(one[0] for one in beings) for room, beings in picture.beings.items()}
    lamps = (one for one in picture.devices if any(part.part.service_type == "light" for part in one.parts))
    lit = {one.area for one in lamps if state_text(one).startswith("on")}
    return picture.plan.lines(signs, lit, width, height)


def _by_room(devices: Iterable[Device]) -> list[tuple[str, list[Device]]]:
    rooms: dict[str, list[Device]] = {}
    for device in sorted(devices, key=lambda one: (not one.area, one.area, one.name)):
        rooms.setdefault(device.area, []).append(device)
    return list(rooms.items())


def _room(room: str, devices: Iterable[Device], beings: Sequence[str], width: int) -> list[Line]:
    with_beings: list[tuple[str, str]] = [(f"  {', '.join(beings)}", "cyan")] if beings else []
    return [[(printable(room) or "no room", "bold"), *with_beings], *(_device(one, width) for one in devices)]


def _device(device: Device, width: int) -> Line:
    """Return the line of one device: its name, its state, and the dialect that it speaks."""
    routes = [route for part in device.parts for route in part.routes]
    dialect = next((one.convention for one in routes if one.convention), "") or "plain MQTT"
    columns = max(8, width - _STATE - _DIALECT - 3)
    name = printable(device.name or device.id, columns)
    is_lost = device.freshness == "stale" or device.reachable.state == "no"
    state = printable(life(device) if is_lost else state_text(device).partition(", ")[0], _STATE)
    style = _LOST if is_lost else next((style for word, style in _STYLES if state.startswith(word)), "")
    return [(f" {name:<{columns}} ", ""), (f"{state:<{_STATE}} ", style), (dialect[:_DIALECT], "dim")]


def _halves(blocks: Sequence[list[Line]]) -> tuple[list[Line], list[Line]]:
    """Return the rooms as two columns, the first one as long as the second or longer by as little as possible."""
    left: list[Line] = []
    half = sum(map(len, blocks)) / 2
    taken = 0
    for block in blocks:
        if left and len(left) >= half:
            break
        left += block
        taken += 1
    return left, [line for block in blocks[taken:] for line in block]


def _beside(left: Sequence[Line], right: Sequence[Line], column: int) -> list[Line]:
    lines: list[Line] = []
    for one, other in zip_longest(left, right, fillvalue=()):
        length = sum(len(text) for text, _ in one)
        lines.append([*one, (" " * max(0, column + _GAP - length), ""), *other])
    return lines


def _story(story: Sequence[StoryLine], width: int, most: int) -> list[Line]:
    """Return the newest lines of the story that fit into *most* lines, where a long one goes on below."""
    lines: list[Line] = []
    for one in reversed(story):
        begin = f"{one.time} "
        indent = " " * (len(begin) + 2)
        first, *others = textwrap.wrap(one.text, max(20, width - len(indent))) or [""]
        if len(lines) + 1 + len(others) > most:
            break
        lines[:0] = [
            [(begin, "dim"), (f"{one.sign} {first}", one.style)],
            *([(f"{indent}{text}", one.style)] for text in others),
        ]
    return lines
