"""Values in the messages of automations, in the words of homebot. Pure."""

import re
from collections.abc import Mapping
from typing import Final, cast

from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.integrations.homeassistant.automations.entities import Automation
from homebot.integrations.homeassistant.automations.expressions import (
    entity_value,
    path_of,
    refused_template,
    shown_tree,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import value_name
from homebot.integrations.homeassistant.automations.template_calculations import calculation_text, is_calculated
from homebot.integrations.homeassistant.automations.template_lists import (
    count_text,
    counted_list,
    entity_list,
    names_text,
)
from homebot.integrations.homeassistant.automations.template_times import is_now
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes

_TIME_FORM: Final = re.compile(r"%-?[HI]:%M(:%S)?( ?%p)?|%[TRX]")
"""A time of day, however it is written."""

_DAY_FORM: Final = re.compile("%-?[deDFxcAaBbm]")
"""A part of a form that tells the day."""

_NAMED: Final[Mapping[tuple[str, ...], str]] = {
    ("trigger", "to_state", "name"): "{name}",
    ("trigger", "to_state", "attributes", "friendly_name"): "{name}",
    ("trigger", "from_state", "name"): "{name}",
    ("trigger", "entity_id"): "{name}",
    ("trigger", "to_state", "entity_id"): "{name}",
    ("this", "attributes", "friendly_name"): "{routine}",
    ("this", "name"): "{routine}",
}
"""The values of messages that are names."""

NAME_PATHS: Final = frozenset(path for path, text in _NAMED.items() if text == "{name}" and "entity_id" not in path)
"""The values of a trigger that are the name of its entity."""

_FORMS: Final = frozenset({"float", "int", "round", "title", "lower", "upper", "string", "default", "d"})
"""Filters that only shape a value of a message."""


def without_unit(text: str, unit: str) -> str:
    """Return *text* after a value without its unit, which homebot writes itself."""
    names = {"%": ("%", "percent"), "°C": ("°C", "°", "C", "degrees", "ºC"), "W": ("W", "watts", "Watt")}.get(
        unit, (unit,)
    )
    for name in filter(None, names):
        rest = text.lstrip(" ")
        if rest.startswith(name) and not rest[len(name) : len(name) + 1].isalnum():
            return rest[len(name) :]
    return text


def value_text(automation: Automation, node: nodes.Node) -> tuple[str, str]:
    """Return a value for a message, and its unit, which homebot writes itself."""
    if listed := _list_value(automation, node):
        return listed, ""
    if (single := _single_value(automation, node)) is not None:
        return single
    if is_calculated(node):
        return f"{{{calculation_text(automation, cast('nodes.Expr', node))}}}", ""
    raise refused_template(shown_tree(node), "a message has states, {name}, {room}, {routine} and {time}")


def _list_value(automation: Automation, node: nodes.Node) -> str:
    """Return the names, or the number, of the entities that *node* lists; empty for another value."""
    is_joined = isinstance(node, nodes.Filter) and node.name == "join"
    known = entity_list(node.node if isinstance(node, nodes.Filter) and is_joined else node)
    if known is not None and (known.told == "name" or (is_joined and not known.told)):
        return names_text(automation, known)
    return "" if (known := counted_list(node)) is None else f"{{{count_text(automation, known)}}}"


def _single_value(automation: Automation, node: nodes.Node) -> tuple[str, str] | None:
    """Return a state, name or time, and its unit; None for another value."""
    while isinstance(node, nodes.Filter) and node.name in _FORMS:
        assert node.node is not None  # noqa: S101 - only the filter of a block has none
        node = node.node
    entity, attribute = entity_value(node)
    if entity and attribute == "friendly_name":
        return automation.entities.find(entity).device.name, ""
    if entity:
        return _state_value(automation, entity, attribute)
    if moment := _moment(automation, node):
        return moment, ""
    return _value_of_trigger(automation, node)


def _value_of_trigger(automation: Automation, node: nodes.Node) -> tuple[str, str] | None:
    """Return a value of the trigger, and its unit; None for another value."""
    path, triggers = path_of(node), automation.triggers
    if path in _NAMED:
        return _NAMED[path], ""
    match path:
        case ("trigger", "from_state", "state") if not any(trigger.value(path) for trigger in triggers):
            return _before(automation)
        case ("trigger", "to_state", "state"):
            entities = {trigger.entity for trigger in triggers}
            note_length(automation)
            if len(entities) == 1 and "" not in entities:
                return _state_value(automation, entities.pop(), "")
    match node:
        case nodes.Call(node=nodes.Name(name="area_name"), args=[inner]) if path_of(inner)[:1] == ("trigger",):
            return "{room}", ""
        case nodes.Call(node=nodes.Name(name="state_attr"), args=[inner, nodes.Const(value="friendly_name")]) if (
            path_of(inner) == ("trigger", "entity_id")
        ):
            return "{name}", ""
        case nodes.Or(left=left, right=right) if (
            path_of(right)[:1] == ("trigger",) and value_text(automation, left)[0] == "{room}"
        ):
            if all(automation.entities.find(trigger.entity).device.area for trigger in triggers):
                return "{room}", ""
    return None


def _moment(automation: Automation, node: nodes.Node) -> str:
    """Return the value that *node*, this moment in any form, is in a message; empty for another expression."""
    form, moment = "", node
    match node:
        case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]):
            moment = inner
        case nodes.Filter(name="timestamp_custom", node=inner, args=[nodes.Const(value=str(form)), *_]) if inner:
            moment = inner
    while True:
        match moment:
            case (
                nodes.Filter(name="as_local" | "as_timestamp" | "as_datetime", node=inner)
                | nodes.Call(node=nodes.Name(name="as_local" | "as_timestamp"), args=[inner, *_])
            ) if inner and form:
                moment = inner
            case _:
                break
    if not is_now(moment) and not (form and _is_of_start(automation, moment)):
        return ""
    if _TIME_FORM.fullmatch(form):
        return "{time}"
    if form and not _DAY_FORM.search(form):
        return ""
    if form:
        automation.notes.append("a day in a message is written as 2026-12-24, with its time")
    return "{now}"


def _is_of_start(automation: Automation, node: nodes.Node) -> bool:
    """Return whether *node* is the time of the change that started it, which is this moment."""
    is_change = path_of(node) in {("trigger", "to_state", last) for last in ("last_changed", "last_updated")}
    lengths = [length for trigger in automation.triggers if (length := dict(trigger.data).get("for"))]
    if not is_change or automation.has_waited or not all(length.startswith("0:00:") for length in lengths):
        return False
    note_length(automation)
    automation.notes.append("the time in a message is that of the home's zone")
    return True


def _before(automation: Automation) -> tuple[str, str] | None:
    """Return the value before the change that started the automation, and its unit; None if it may be unknown."""
    known = [value_name(automation.entities, trigger.entity, "")[1] for trigger in automation.triggers]
    facts = [dict(trigger.data) for trigger in automation.triggers]
    is_lost = any("for" in data and not data.keys().isdisjoint({"above", "below"}) for data in facts)
    units = {CAPABILITIES.get(capability, OWN).unit for capability in known}
    if is_lost or len(units) != 1 or not EVENTS.isdisjoint(known):
        return None
    automation.notes.append("{before} is the value before, in the words of homebot, with its unit")
    return "{before}", units.pop()


def note_length(automation: Automation) -> None:
    """Add the note that a state that lasted may have changed since it started."""
    if any("for" in dict(trigger.data) for trigger in automation.triggers):
        automation.notes.append("after `for` a message has the value of now, and not that from before it")


def is_value(automation: Automation, node: nodes.Node) -> bool:
    """Return whether *node* is a value that a message may have."""
    noted = len(automation.notes)
    try:
        value_text(automation, node)
    except NotCarriedError:
        return False
    finally:
        del automation.notes[noted:]
    return True


def _state_value(automation: Automation, entity_id: str, attribute: str) -> tuple[str, str]:
    name, capability = value_name(automation.entities, entity_id, attribute)
    automation.notes.append(f"{entity_id} is written in the words of homebot, with its unit")
    return f"{{{capability} of {name}}}", CAPABILITIES.get(capability, OWN).unit
