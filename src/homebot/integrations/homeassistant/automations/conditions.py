"""Conditions of automations as conditions of routines. Pure.

Source: Home Assistant core 2026.11, ``helpers/condition.py``.
"""

import re
from collections.abc import Iterable, Sequence
from itertools import chain, product
from math import prod
from typing import Final

from homebot.integrations.homeassistant.automations.entities import Automation, Condition, is_of_two_values
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.states import STATES, helper_time, sun_moment
from homebot.integrations.homeassistant.automations.templates import Templates, bracketed
from homebot.support.located import Located
from homebot.words.times import read_span

JOINTS: Final = ("and", "or", "not")

_MAX_CONDITIONS: Final = 50
"""Conditions that an ``or`` or ``not`` of others becomes."""

_BY_SUN: Final[dict[Condition, list[Condition]]] = {
    ("after sunset", "before sunrise"): [("sun is down",)],
    ("after sunrise", "before sunset"): [("sun is up",)],
}
_OPPOSITES: Final = {"sun is up": "sun is down", "sun is down": "sun is up"}
_HOUSEHOLD: Final = {
    "somebody is home": "nobody is home",
    "nobody is home": "somebody is home",
    "everybody is home": "not everybody is home",
}
_LASTING: Final = re.compile(r" for (?:less than )?[\w.]+\)$")
_OTHER_SIDE: Final = {"after": "before", "before": "after"}
_LIMIT: Final = re.compile(r"(?P<value>[^<>]*)(?P<sign>[<>])(?P<number>[-+.e\d]+\))")
_LIMITS: Final = re.compile(r"[<>][-+.e\d]+\)$")


def conditions_of(automation: Automation, nodes: Sequence[Located]) -> list[Condition]:
    """Return the conditions that hold if all of *nodes* do, perhaps with :data:`NEVER`."""
    return [*chain.from_iterable(_each(automation, nodes))]


def templates_of(automation: Automation) -> Templates:
    """Return the reader of templates of *automation*."""
    return Templates(automation, any_of, denied)


def template_text(node: Located | None) -> str:
    """Return the template *node*, perhaps with values of its variables."""
    if node is None or node.tag or not isinstance(node.value, str | bool):
        raise NotCarriedError("a template is missing")
    return node.value if isinstance(node.value, str) else str(node.value)


def texts_of(conditions: Iterable[Condition]) -> list[str]:
    """Return the texts of *conditions* in routines."""
    texts = (
        condition[0][1:-1] if len(condition) == 1 and condition[0][:1] == "(" else " or ".join(condition)
        for condition in conditions
    )
    return [*dict.fromkeys(texts)]


def _each(automation: Automation, nodes: Sequence[Located]) -> list[list[Condition]]:
    return automation.each([*map(_with_fields, nodes)], "condition", lambda fields: _read(automation, fields))


def _with_fields(node: Located) -> Located:
    """Return a condition that is only a template as those with fields."""
    if not isinstance(node.value, str | bool):
        return node
    return Located({"condition": Located("template", node.line), "value_template": node}, node.line)


def _read(automation: Automation, fields: UnreadFields) -> list[Condition]:
    if "{" in str(fields.left["condition"].value if "condition" in fields else ""):
        return templates_of(automation).conditions(template_text(fields.take("condition")))
    kind = fields.text("condition", "")
    joint = kind or fields.first_of(JOINTS)
    match joint:
        case "and" | "or" | "not":
            return _joined(joint, _each(automation, fields.items("conditions" if kind else joint)))
        case "time":
            return _time(automation, fields)
        case "sun":
            return _sun(fields)
        case "trigger":
            ids = fields.texts("id")
            return templates_of(automation).started_by([one for one in automation.triggers if one.id in ids])
        case "template":
            node = fields.take("value_template")
            return templates_of(automation).conditions(template_text(node))
        case kind if kind in STATES:
            return _states(automation, kind, fields)
        case "":
            fields.end()
    raise NotCarriedError(f"condition: {kind!r} has no counterpart in routines")


def _joined(joint: str, alternatives: Sequence[list[Condition]]) -> list[Condition]:
    if joint == "or":
        return any_of(alternatives)
    return [condition for some in alternatives for condition in (_not_so(some) if joint == "not" else some)]


def _states(automation: Automation, kind: str, fields: UnreadFields) -> list[Condition]:
    of_any = kind == "state" and fields.text("match", "all") == "any"
    named, asked = fields.texts_of("entity_id"), fields.texts_of("state") if kind == "state" else []
    if asked in (["on"], ["off"]) and len(named) == 1 and (members := automation.entities.members(named[0])):
        fields.left["entity_id"] = fields.left["entity_id"]._replace(value=[Located(one, 0) for one in members])
        of_any = asked == ["on"]  # a group is on if any of its members is
    states_of_entities = STATES[kind](automation.entities, fields, "state")
    lasting = fields.duration("for")
    length = f" for {lasting}" if lasting else ""
    conditions = [any_of([[(bracketed(f"{state}{length}"),)] for state in states]) for states in states_of_entities]
    texts = chain.from_iterable(chain.from_iterable(conditions))
    if length and any(text in _OPPOSITES or is_of_two_values(text) for text in texts):
        raise NotCarriedError("condition: `for` of the sun, or of two values")
    return any_of(conditions) if of_any else [*chain.from_iterable(conditions)]


def _sun(fields: UnreadFields) -> list[Condition]:
    events = {side: fields.text(side, "") for side in _OTHER_SIDE}
    texts = [f"{side} {sun_moment(fields, event, f'{side}_offset')}" for side, event in events.items() if event]
    if not texts:
        raise NotCarriedError("condition sun: `after` and `before` are missing")
    if (condition := _BY_SUN.get(tuple(texts))) is not None:
        return condition
    return [tuple(texts)] if [*events.values()] == ["sunset", "sunrise"] else [(text,) for text in texts]


def _time(automation: Automation, fields: UnreadFields) -> list[Condition]:
    days, after, before = fields.days(), *(_moments(automation, fields, key) for key in ("after", "before"))
    match after, before:
        case [begin], [end]:
            texts = [f"between {begin} and {end}"]
        case _:
            texts = [f"{word} {time}" for word, times in (("after", after), ("before", before)) for time in times]
    spans = [
        text for text in texts if "text of " in text or ((span := read_span(text)) and span.begin != span.end)
    ]  # others hold always
    return [(text,) for text in (*spans, days) if text]


def _moments(automation: Automation, fields: UnreadFields, key: str) -> list[str]:
    """Return the times of day of a field, of which one may be that of a helper."""
    node = fields.left.get(key)
    if node is None or not isinstance(node.value, str) or "." not in node.value:
        return fields.clock_times(key)
    return [helper_time(automation.entities, fields.text(key))]


def any_of(alternatives: Sequence[list[Condition]]) -> list[Condition]:
    """Return the conditions that hold if those of at least one of *alternatives* do."""
    if prod(map(len, alternatives)) > _MAX_CONDITIONS:
        raise NotCarriedError("condition: too many of them joined by `or` and `not`")
    conditions = [tuple(dict.fromkeys(chain.from_iterable(texts))) for texts in product(*alternatives)]
    conditions = [
        condition for condition in conditions if not any(_other_time(text) in condition for text in condition)
    ]
    return [condition for condition in conditions if not any({*other} < {*condition} for other in conditions)]


def _not_so(conditions: Sequence[Condition]) -> list[Condition]:
    """Return the conditions of ``not``, which hold also for unknown numbers."""
    texts = ((f"not {text}" if _LIMITS.search(text) else _opposite(text) for text in held) for held in conditions)
    return any_of([[(text,) for text in alternatives] for alternatives in texts])


def denied(conditions: Sequence[Condition]) -> list[Condition]:
    """Return the conditions that hold if at least one of *conditions* is known not to."""
    return any_of([[(_opposite(text),) for text in condition] for condition in conditions])


def _opposite(text: str) -> str:
    if text.endswith(" is home") and not text.startswith("not "):
        return _HOUSEHOLD.get(text) or f"{text.removesuffix(' is home')} is away"
    if text.endswith(" is away"):
        raise NotCarriedError("condition not: where somebody is may be unknown; ask for `not_home`")
    if text.endswith(")") and _LASTING.search(text):
        raise NotCarriedError("condition not: with `for`; ask for the other state")
    if (limit := _LIMIT.fullmatch(text)) is not None:  # unlike `not`, a limit holds for no unknown number
        return f"{limit['value']}{'<=' if limit['sign'] == '>' else '>='}{limit['number']}"
    if _LIMITS.search(text):
        raise NotCarriedError("condition not: both `above` and `below`; write two conditions")
    return _other_time(text) or (text.removeprefix("not ") if text.startswith("not ") else f"not {text}")


def _other_time(text: str) -> str:
    """Return the opposite of a condition of time; empty for any other."""
    side, _, moment = text.partition(" ")
    if text.startswith(("sun elevation ", "sun azimuth ")):
        return text.replace(" above ", " below ") if " above " in text else text.replace(" below ", " above ")
    if text.startswith("last run "):
        return text.replace(" over ", " under ") if " over " in text else text.replace(" under ", " over ")
    return f"{_OTHER_SIDE[side]} {moment}" if side in _OTHER_SIDE else _OPPOSITES.get(text, "")
