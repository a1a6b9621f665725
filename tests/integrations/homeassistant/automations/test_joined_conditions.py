"""Conditions joined by ``and``, ``or`` and ``not`` hold in routines when they hold in Home Assistant."""

import json
from datetime import datetime, time
from itertools import product
from typing import cast

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tests.integrations.homeassistant.automations.test_automations import HOUSE, NOW, read

from homebot.devices.device import State
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.value import Value
from homebot.features.routines.text import read_routines
from homebot.words.conditions import AnyOf, Condition, Matches, OnDays, SunIs, read_condition
from homebot.words.times import SunSpan, TimeSpan

LAMP, PLUG = (next(one for one in HOUSE if one.name == name) for name in ("Hall lamp", "Kitchen plug"))
LEAVES = {
    "lamp": {"condition": "state", "entity_id": "light.hall_lamp", "state": "on"},
    "plug": {"condition": "state", "entity_id": "switch.kitchen_plug", "state": "off"},
    "night": {"condition": "sun", "after": "sunset", "before": "sunrise"},
    "late": {"condition": "time", "after": "18:00", "before": "02:00"},
    "evening": {"condition": "sun", "after": "sunset", "after_offset": "-01:00:00"},
    "dark": {"condition": "sun", "after": "sunset", "before": "sunrise", "before_offset": "00:30:00"},
    "weekend": {"condition": "time", "weekday": ["sat", "sun"]},
}
Tree = str | tuple[str, list["Tree"]]
TREES: st.SearchStrategy[Tree] = st.recursive(
    st.sampled_from([*LEAVES]),
    lambda inner: st.tuples(st.sampled_from(["and", "or", "not"]), st.lists(inner, min_size=1, max_size=3)),
    max_leaves=6,
)
HOUR = 3600
SUN = {"sunset": 20, "sunrise": 6}
MOMENTS = [datetime(2024, 6, day, hour) for day in (7, 8) for hour in (1, 9, 19)]  # noqa: DTZ001 - in the home's zone


def written(tree: Tree) -> object:
    return LEAVES[tree] if isinstance(tree, str) else {"condition": tree[0], "conditions": [*map(written, tree[1])]}


def holds_there(tree: Tree, facts: dict[str, bool]) -> bool:
    if isinstance(tree, str):
        return facts[tree]
    each = [holds_there(one, facts) for one in tree[1]]
    return {"and": all(each), "or": any(each), "not": not any(each)}[tree[0]]


def holds_here(condition: Condition, facts: dict[str, bool], at: datetime) -> bool:
    match condition:
        case AnyOf():
            return any(holds_here(one, facts, at) for one in condition.conditions)
        case SunIs():
            return condition.is_up is not facts["night"]
        case TimeSpan():
            return condition.has(at.time())
        case SunSpan():
            span = condition.on_day(lambda one: time(SUN[one.event] + round(one.seconds / HOUR)))
            return span is not None and span.has(at.time())
        case OnDays():
            return condition.days.has(at)
        case Matches():
            states = {LAMP: facts["lamp"], PLUG: not facts["plug"]}
            house = [
                one.model_copy(update={"states": (State(part="", capability="on_off", value=Value.of(is_on), since=NOW,
                                                        told_at=NOW, live=True),)})
                for one, is_on in states.items()
            ]  # fmt: skip
            return any(fits(condition.state.query, facets_of(one)) for one in house) is not condition.is_none
    pytest.fail(f"unexpected: {condition}")


@settings(deadline=None)
@given(TREES)
@example(("not", ["dark"]))
@example(("or", ["lamp", ("not", ["plug"])]))
@example(("or", [("not", ["lamp"]), "plug"]))
def test_they_hold_at_the_same_moments(tree: Tree) -> None:
    automations = [{"triggers": {"trigger": "sun", "event": "sunset"}, "conditions": [written(tree)],
             "actions": {"action": "scene.turn_on", "target": {"entity_id": "scene.movie"}}}]  # fmt: skip
    found = read(json.dumps(automations))
    if found.refused and "too many" in found.refused[0].problem:
        return
    never = bool(found.refused)
    reasons = "it would do nothing", "never hold together"
    assert not never or any(reason in found.refused[0].problem for reason in reasons)
    routines = [] if never else read_routines(found.texts[0], "")
    conditions = [read_condition(text) for one in routines for text in cast("list[str]", one.table.get("if", []))]
    for lamp, plug, night, at in product((True, False), (True, False), (True, False), MOMENTS):
        of_time = {"late": at.hour in {1, 19}, "evening": at.hour == 19, "dark": at.hour == 1}
        facts = {"lamp": lamp, "plug": plug, "night": night, "weekend": at.weekday() > 4, **of_time}
        here = not never and all(holds_here(one, facts, at) for one in conditions)
        assert here is holds_there(tree, facts), (automations, conditions, facts)
