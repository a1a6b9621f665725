"""Conditions of automations as conditions of routines. Pure.

Source: Home Assistant core 2026.11, ``helpers/condition.py``.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple, TypeAlias

from homebot.integrations.homeassistant.automations.entities import Entities
from homebot.integrations.homeassistant.automations.fields import (
    NotCarriedError,
    check_keys,
    fields_of,
    is_enabled,
    items_of,
    limits_of,
    needed,
    shown,
    text_of,
    texts_of,
)
from homebot.integrations.homeassistant.automations.states import limit_text, state_text
from homebot.integrations.homeassistant.automations.times import clock_time, days_text
from homebot.support.located import Located

__all__ = ["NEVER", "Condition", "Conditions"]


class Condition(NamedTuple):
    """A condition in the words of routines.

    Attributes:
        is_query: Whether it is the state of devices, which can be joined by ``or``, and denied.
    """

    text: str
    is_query: bool = False


NEVER: Final = Condition("never")
"""It does not hold for the trigger for which an automation is read."""

_Read: TypeAlias = Callable[[Located, Mapping[str, Located]], list[Condition]]

_GENERAL: Final = ("condition", "alias", "enabled")
_DAY, _NIGHT = Condition("sun is up"), Condition("sun is down")
_SUN_STATES: Final = {"above_horizon": _DAY, "below_horizon": _NIGHT}
_JOINTS: Final = ("and", "or", "not")


class Conditions:
    """Reader of conditions for one automation.

    Args:
        trigger: The id of the trigger for which the automation is read; None for all.
    """

    def __init__(self, entities: Entities, trigger: str | None) -> None:
        self._entities = entities
        self._trigger = trigger
        self._kinds: Mapping[str, _Read] = {
            "state": self._state,
            "numeric_state": self._numeric,
            "time": self._time,
            "sun": self._sun,
            "trigger": self._by_trigger,
            "zone": self._zone,
        }

    def all_of(self, nodes: Sequence[Located]) -> list[Condition]:
        """Return the conditions that hold if all of *nodes* do, perhaps with :data:`NEVER`."""
        return [one for each in self._each(nodes) for one in each]

    def _each(self, nodes: Sequence[Located]) -> list[list[Condition]]:
        """Return the conditions of each of *nodes* that is not switched off."""
        return [self._read(one) for one in nodes if not isinstance(one.value, dict) or is_enabled(one.value)]

    def _read(self, node: Located) -> list[Condition]:
        if not isinstance(node.value, dict):
            raise NotCarriedError(node.line, f"condition: {shown(node)}; routines have no templates")
        fields = fields_of(node, "condition")
        kind = text_of(fields["condition"], "condition") if "condition" in fields else ""
        joint = kind or next((one for one in _JOINTS if one in fields), "")
        if joint in _JOINTS:
            key = "conditions" if kind else joint
            check_keys(node, f"condition {joint}", *_GENERAL, key)
            return self._joined(joint, self._each(items_of(fields.get(key))), node.line)
        if kind not in self._kinds:
            raise NotCarriedError(node.line, f"condition: {kind!r} has no counterpart in routines")
        return self._kinds[kind](node, fields)

    def _joined(self, joint: str, each: Sequence[list[Condition]], line: int) -> list[Condition]:
        if joint == "or":
            return _any_of(each, line)
        if joint == "not":
            each = [_denied(one, line) for one in each]
        return [one for some in each for one in some]

    def _state(self, node: Located, fields: Mapping[str, Located]) -> list[Condition]:
        check_keys(node, "condition state", *_GENERAL, "entity_id", "state", "match")
        states = texts_of(needed(node, fields, "state"), "state")
        ids = texts_of(needed(node, fields, "entity_id"), "entity_id")
        found = [[self._any_state(one, states, node.line)] for one in ids]
        match = text_of(fields["match"], "match") if "match" in fields else "all"
        return [one for (one,) in found] if match == "all" else _any_of(found, node.line)

    def _any_state(self, entity_id: str, states: Sequence[str], line: int) -> Condition:
        if entity_id == _SUN and len(states) == 1 and states[0] in _SUN_STATES:
            return _SUN_STATES[states[0]]
        entity = self._entities.find(entity_id, line)
        (found,) = _any_of([[Condition(state_text(entity, one, line), is_query=True)] for one in states], line)
        return found

    def _numeric(self, node: Located, fields: Mapping[str, Located]) -> list[Condition]:
        check_keys(node, "condition numeric_state", *_GENERAL, "entity_id", "above", "below")
        limits = limits_of(node, fields)
        ids = texts_of(needed(node, fields, "entity_id"), "entity_id")
        found = [limit_text(self._entities.find(one, node.line), *limits, node.line) for one in ids]
        return [Condition(one, is_query=True) for one in found]

    def _time(self, node: Located, fields: Mapping[str, Located]) -> list[Condition]:
        check_keys(node, "condition time", *_GENERAL, "after", "before", "weekday")
        after, before = (clock_time(fields[one], one) if one in fields else "" for one in ("after", "before"))
        texts = [f"between {after} and {before}"] if after and before else []
        texts += [f"after {after}"] if after and not before else []
        texts += [f"before {before}"] if before and not after else []
        texts += [f"on {days_text(fields['weekday'])}"] if "weekday" in fields else []
        return [*map(Condition, texts)]

    def _sun(self, node: Located, fields: Mapping[str, Located]) -> list[Condition]:
        check_keys(node, "condition sun", *_GENERAL, "after", "before")
        told = {one: text_of(fields[one], one) for one in ("after", "before") if one in fields}
        match told:
            case {"after": "sunset", "before": "sunrise"}:
                return [_NIGHT]
            case {"after": "sunrise", "before": "sunset"}:
                return [_DAY]
            case {"after": "sunset"} if len(told) == 1:  # until midnight
                return [_NIGHT, Condition("after 12:00")]
            case {"before": "sunrise"} if len(told) == 1:
                return [_NIGHT, Condition("before 12:00")]
        raise NotCarriedError(node.line, "condition sun: routines know day and night, but no such part of a day")

    def _by_trigger(self, node: Located, fields: Mapping[str, Located]) -> list[Condition]:
        check_keys(node, "condition trigger", *_GENERAL, "id")
        if self._trigger is None:
            raise NotCarriedError(node.line, "condition trigger: no trigger has an id")
        return [] if self._trigger in texts_of(needed(node, fields, "id"), "id") else [NEVER]

    def _zone(self, node: Located, fields: Mapping[str, Located]) -> list[Condition]:
        check_keys(node, "condition zone", *_GENERAL, "entity_id", "zone")
        if texts_of(needed(node, fields, "zone"), "zone") != [_HOME]:
            raise NotCarriedError(node.line, f"condition zone: homebot knows {_HOME} alone")
        ids = texts_of(needed(node, fields, "entity_id"), "entity_id")
        texts = [state_text(self._entities.find(one, node.line), "home", node.line) for one in ids]
        return [Condition(one, is_query=True) for one in texts]


_SUN: Final = "sun.sun"
_HOME: Final = "zone.home"


def _any_of(each: Sequence[list[Condition]], line: int) -> list[Condition]:
    """Return one condition for several of which one must hold; only queries can be joined."""
    possible = [one for one in each if NEVER not in one]
    if not possible or [] in possible:
        return [] if possible else [NEVER]
    if len(possible) == 1:
        return possible[0]
    if any(len(one) > 1 or not one[0].is_query for one in possible):
        raise NotCarriedError(line, "condition or: routines join only states of devices by `or`")
    return [Condition(" or ".join(f"({one[0].text})" for one in possible), is_query=True)]


def _denied(conditions: Sequence[Condition], line: int) -> list[Condition]:
    if not conditions or NEVER in conditions:
        return [] if conditions else [NEVER]
    first, *others = conditions
    if not others and first in {_DAY, _NIGHT}:
        return [_NIGHT if first == _DAY else _DAY]
    if others or not first.is_query or "place=" in first.text:
        raise NotCarriedError(line, "condition not: routines deny only single states of devices")
    return [Condition(f"not ({first.text})")]
