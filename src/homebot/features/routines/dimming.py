"""Dimming while a button is held: level by level, because few devices report that they take moves."""

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace
from typing import Final

import anyio

from homebot.devices.device import Device, StateChange
from homebot.devices.house_view import HouseView
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.features.routines.watches import PressWatch
from homebot.graph import Node
from homebot.words.house_queries import WordsQuery
from homebot.words.steps import Dim

MAX_DIMMED: Final = 10.0
"""Seconds; a release may get lost."""

_REPEATED: Final = "repeat"
"""The event of Hue's buttons every 0.8 s while they are held."""

_STEP, _EVERY = 10.0, 0.5
"""Percent, and seconds: the whole range in five seconds, as with most dimmers."""

_DARKEST, _MIDDLE, _BRIGHTEST = 1.0, 50.0, 100.0


async def dim(node: Node, step: Dim, devices: Sequence[Device], set_level: Callable[[float], Awaitable[bool]]) -> None:
    """Change the level until the button reports anything else than that it is held, at most :data:`MAX_DIMMED`.

    Args:
        devices: The devices of the house, for the present level of the lamps.
        set_level: Commands a level in percent; returns whether that succeeded.
    """
    level = _level_of(step, devices)
    is_up = step.way == "brighten" or (step.way == "dim" and level < _MIDDLE)
    over = anyio.Event()

    def on_press(change: object) -> None:
        if isinstance(change, StateChange) and str(change.readings[0].value.plain()).casefold() not in held:
            over.set()

    held = {step.held.value, _REPEATED}
    watch = PressWatch(node, replace(step.held, value=""), on_press)
    try:
        with anyio.move_on_after(MAX_DIMMED):
            while not over.is_set() and level != (_BRIGHTEST if is_up else _DARKEST):
                level = min(_BRIGHTEST, max(_DARKEST, level + (_STEP if is_up else -_STEP)))
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(anyio.sleep, _EVERY)
                    is_done = await set_level(level)
                if not is_done:
                    return
    finally:
        HouseView.of(node).remove(watch)


def _level_of(step: Dim, devices: Sequence[Device]) -> float:
    """Return the mean level of the lamps that are on; 0 if none is known to be."""
    query = WordsQuery(step.target, devices).query
    lamps = [one for one in devices if fits(query, facets_of(one))]
    values = [{state.capability: state.value.plain() for state in one.states} for one in lamps]
    lit = [one["level"] for one in values if one.get("on_off") is not False and "level" in one]
    levels = [one for one in lit if isinstance(one, float)]
    return sum(levels) / len(levels) if levels else 0.0
