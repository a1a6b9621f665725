"""Conditions of automations as conditions of routines. Pure.

Source: Home Assistant core 2026.11, ``helpers/condition.py``.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

from homebot.integrations.homeassistant.automations.automation import Automation
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.states import STATES, SUN
from homebot.support.located import Located

__all__ = ["JOINTS", "NEVER", "Condition", "conditions_of"]


class Condition(NamedTuple):
    """A condition in the words of routines.

    Attributes:
        is_query: Whether it is the state of devices, which can be joined by ``or``, and denied.
    """

    text: str
    is_query: bool = False


NEVER: Final = Condition("never")
"""It does not hold for the trigger for which an automation is read."""

JOINTS: Final = ("and", "or", "not")

_DAY, _NIGHT = Condition("sun is up"), Condition("sun is down")
_SUN: Final = {
    ("sunset", "sunrise"): [_NIGHT],
    ("sunrise", "sunset"): [_DAY],
    ("sunset", ""): [_NIGHT, Condition("after 12:00")],  # until midnight
    ("", "sunrise"): [_NIGHT, Condition("before 12:00")],
}
"""By ``after`` and ``before``."""

_BY_SUN: Final = frozenset(SUN["state"].values())


def conditions_of(automation: Automation, nodes: Sequence[Located]) -> list[Condition]:
    """Return the conditions that hold if all of *nodes* do, perhaps with :data:`NEVER`."""
    return [one for each in _each(automation, nodes) for one in each]


def _each(automation: Automation, nodes: Sequence[Located]) -> list[list[Condition]]:
    return automation.each(nodes, "condition", lambda fields: _read(automation, fields))


def _read(automation: Automation, fields: UnreadFields) -> list[Condition]:
    kind = fields.text("condition", "")
    joint = kind or next((one for one in JOINTS if one in fields), "")
    match joint:
        case "and" | "or" | "not":
            return _joined(joint, _each(automation, fields.items("conditions" if kind else joint)))
        case "time":
            return _time(fields)
        case "sun":
            return _sun(fields)
        case "trigger":
            return _trigger(automation, fields)
        case kind if kind in STATES:
            return _state(automation, kind, fields)
    raise NotCarriedError(f"condition: {kind!r} has no counterpart in routines")


def _joined(joint: str, each: Sequence[list[Condition]]) -> list[Condition]:
    if joint == "or":
        return _any_of(each)
    return [one for some in each for one in (_denied(some) if joint == "not" else some)]


def _trigger(automation: Automation, fields: UnreadFields) -> list[Condition]:
    if automation.trigger is None:
        raise NotCarriedError("condition trigger: no trigger has an id")
    return [] if automation.trigger in fields.texts("id") else [NEVER]


def _state(automation: Automation, kind: str, fields: UnreadFields) -> list[Condition]:
    of_any = kind == "state" and fields.text("match", "all") == "any"
    each = STATES[kind](automation.entities, fields, "state")
    found = [_any_of([[Condition(one, one not in _BY_SUN)] for one in states]) for states in each]
    return _any_of(found) if of_any else [one for some in found for one in some]


def _sun(fields: UnreadFields) -> list[Condition]:
    told = fields.text("after", ""), fields.text("before", "")
    if told not in _SUN:
        raise NotCarriedError("condition sun: routines know day and night, but no such part of a day")
    return _SUN[told]


def _time(fields: UnreadFields) -> list[Condition]:
    days, after, before = fields.days(), fields.clock_times("after"), fields.clock_times("before")
    match after, before:
        case [begin], [end]:
            texts = [f"between {begin} and {end}"]
        case _:
            texts = [f"{word} {one}" for word, times in (("after", after), ("before", before)) for one in times]
    return [*map(Condition, [*texts, *filter(None, [days])])]


def _any_of(each: Sequence[list[Condition]]) -> list[Condition]:
    """Return one condition for several of which one must hold; only queries can be joined."""
    possible = [one for one in each if NEVER not in one]
    if not possible or [] in possible:
        return [] if possible else [NEVER]
    if len(possible) == 1:
        return possible[0]
    if any(len(one) > 1 or not one[0].is_query for one in possible):
        raise NotCarriedError("condition or: routines join only states of devices by `or`")
    return [Condition(" or ".join(f"({one[0].text})" for one in possible), is_query=True)]


def _denied(conditions: Sequence[Condition]) -> list[Condition]:
    if not conditions or NEVER in conditions:
        return [] if conditions else [NEVER]
    first, *others = conditions
    if not others and first in {_DAY, _NIGHT}:
        return [_NIGHT if first == _DAY else _DAY]
    if others or not first.is_query or "place=" in first.text:
        raise NotCarriedError("condition not: routines deny only single states of devices")
    return [Condition(f"not ({first.text})")]
