"""Triggers of automations as triggers of routines. Pure.

Source: Home Assistant core 2026.11, ``components/homeassistant/triggers``, ``components/sun/trigger.py``,
``components/zone/trigger.py``.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Final

from homebot.integrations.homeassistant.automations.conditions import denied, template_text, templates_of
from homebot.integrations.homeassistant.automations.entities import Automation, Condition, StartTrigger, is_of_device
from homebot.integrations.homeassistant.automations.event_triggers import (
    ADVICE,
    device_press,
    event_triggers,
    message_triggers,
    tag_triggers,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.state_triggers import (
    lasting_text,
    length_facts,
    moved,
    state_triggers,
)
from homebot.integrations.homeassistant.automations.states import STATES, helper_time, sun_moment
from homebot.integrations.homeassistant.automations.templates import bracketed
from homebot.support.located import Located
from homebot.words.steps import MAX_LINES


def read_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers of *fields*, each of which starts the routine."""
    if (node := fields.left.get("for")) is not None and (ways := templates_of(automation).ways(node)):
        return [*_by_length(automation, fields, ways)]
    if fields.texts_of("entity_id") == ["sun.sun"] and {"above", "below"} <= fields.left.keys():
        return [*_by_side(automation, fields)]
    kind = fields.text("trigger", "") or fields.text("platform", "")
    fields.take("id")
    if kind == "device" and "entity_id" not in fields:
        return [StartTrigger(device_press(automation, fields))]
    if (read := _READERS.get(kind)) is not None:
        return read(automation, fields)
    if not kind:
        fields.end()
    raise NotCarriedError(f"trigger: {kind!r} has no counterpart in routines{ADVICE.get(kind, '')}")


def _start(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    if (event := fields.text("event")) not in {"start", "started"}:
        raise NotCarriedError(f"trigger homeassistant: {event!r}; a routine knows only its start")
    automation.notes.append("the start is that of homebot")
    return [StartTrigger("homebot starts")]


def _states(kind: str, automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers of the states, or the limits, of entities."""
    is_leave = kind == "zone" and fields.text("event", "enter") == "leave"
    lasting = lasting_text(automation, fields)
    ids = fields.texts_of("entity_id")
    limits = tuple((side, str(fields.left[side].value)) for side in ("above", "below") if side in fields)
    data = (*limits, *length_facts(lasting))
    if kind == "numeric_state" and (calculated := _calculated(automation, fields)):
        return [
            StartTrigger(f"{text}{lasting}", entity=entity, data=data)
            for entity, text in zip(ids, calculated, strict=True)
        ]
    return [
        StartTrigger(moved(text, lasting, is_leave=is_leave), entity=entity, data=data)
        for entity, texts in zip(ids, STATES[kind](automation.entities, fields, "to"), strict=True)
        for text in texts
    ]


def _by_length(
    automation: Automation, fields: UnreadFields, ways: Sequence[tuple[list[Condition], Located]]
) -> Iterator[StartTrigger]:
    """Yield the triggers for each length between which a template chooses, with the conditions of that."""
    automation.notes.append("which length counts is asked at its end")
    known, before = dict(fields.left), list[Condition]()
    for held, length in ways:
        way = UnreadFields(Located({**known, "for": length}, 0), "trigger")
        needs = (*before, *held)
        yield from (trigger._replace(needs=(*trigger.needs, *needs)) for trigger in read_triggers(automation, way))
        way.end()
        before += denied(held)
    fields.left.clear()


def _by_side(automation: Automation, fields: UnreadFields) -> Iterator[StartTrigger]:
    """Yield the triggers of a number between two limits: it passes either of them, on the right side of the other."""
    known = dict(fields.left)
    ways = []
    for side in ("above", "below"):
        way = UnreadFields(Located({key: node for key, node in known.items() if key != side}, 0), "trigger")
        ways += read_triggers(automation, way)
        way.end()
    for trigger, other in (ways, ways[::-1]):
        yield trigger._replace(needs=(*trigger.needs, (other.text,)), data=(*other.data, *trigger.data))
    fields.left.clear()


def _calculated(automation: Automation, fields: UnreadFields) -> list[str]:
    """Return the difference of two values of each entity, as it passes a limit; none for another value."""
    node = fields.left.get("value_template")
    sides = [side for side in ("above", "below") if side in fields]
    if node is None or "states(" not in str(node.value) or len(sides) != 1:
        return []
    fields.take("value_template")
    (limit,) = fields.numbers(sides[0])
    return [
        templates_of(automation).passed(template_text(node), entity, sides[0], limit)
        for entity in fields.texts("entity_id")
    ]


def _times(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers at the times of day of ``at``, of which some may be those of helpers."""
    days = fields.days()
    nodes = fields.items("at")
    entities = [node for node in nodes if isinstance(node.value, dict) or "." in str(node.value)]
    given = UnreadFields(Located({"at": Located([node for node in nodes if node not in entities], 0)}, 0), "trigger")
    times = [f"{time} {days}".rstrip() for time in given.clock_times("at")]
    for node in entities:
        at = UnreadFields(node if isinstance(node.value, dict) else Located({"entity_id": node}, node.line), "at")
        entity_id, offset = at.text("entity_id"), at.duration("offset")
        at.end()
        if days:
            raise NotCarriedError("trigger time: `weekday` with the time of a helper; ask for the days in a condition")
        time = f"at {helper_time(automation.entities, entity_id, 'value')}"
        times.append(f"{time} {'-' if offset[0] == '-' else '+'} {offset.lstrip('-')}" if offset else time)
        automation.notes.append(f"{entity_id} starts it at its time: each day, or on its date")
    if not times:
        raise NotCarriedError("trigger time: `at` is missing; write each time as a trigger")
    return [*map(StartTrigger, times)]


_MAX_MINUTES: Final = 20
"""Minutes of an hour that are written, each as a trigger."""


def _pattern(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers of ``time_pattern``: units below the given one are 0, and those above it any."""
    given = {unit: fields.text(unit, "") for unit in ("hours", "minutes", "seconds")}
    hours, minutes, seconds = given.values()
    if not any(given.values()):
        raise NotCarriedError("trigger time_pattern: `hours`, `minutes` or `seconds` is missing")
    every = (hours or "*", minutes or ("0" if hours else "*"), seconds or "0")
    if every[:2] == ("*", "*") and every[2].startswith("/"):
        automation.notes.append("its seconds are counted from the start of homebot")
        return [StartTrigger(f"every {int(every[2][1:])}s")]
    if every[2] not in {"0", "00"}:
        raise NotCarriedError("trigger time_pattern: seconds beside minutes or hours")
    in_hour, in_day = _numbers(every[1], 60), _numbers(every[0], 24)
    if len(in_day) == 24:
        if len(in_hour) <= _MAX_MINUTES:
            return [StartTrigger(f"at :{minute:02} every hour") for minute in in_hour]
        automation.notes.append("its minutes are counted from the start of homebot")
        return [StartTrigger(f"every {60 // len(in_hour)}m")]
    if len(in_day) * len(in_hour) > MAX_LINES:
        raise NotCarriedError(
            f"trigger time_pattern: more than {MAX_LINES} times a day; ask for the hours in a condition"
        )
    return [StartTrigger(f"{hour}:{minute:02}") for hour in in_day for minute in in_hour]


def _numbers(text: str, most: int) -> list[int]:
    """Return the numbers below *most* that ``*``, ``/5`` or ``5`` means."""
    step = text[1:] if text.startswith("/") else "1" if text == "*" else ""
    number = step or text
    if not number.isdecimal() or not int(number) < most or (step and int(number) == 0):
        raise NotCarriedError(f"trigger time_pattern: {text!r}")
    return [*range(0, most, int(step))] if step else [int(number)]


def _template(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the states that must all be for the template to be true, each as a trigger; the others are conditions."""
    node = fields.take("value_template")
    lasting = lasting_text(automation, fields)
    entity, seconds = ("", 0.0) if lasting else templates_of(automation).moment(template_text(node))
    if entity:
        at = {"entity_id": Located(entity, 0), "offset": Located(seconds, 0)}
        automation.notes.append(f"a moment of {entity} that is over when it is told starts nothing")
        return _times(automation, UnreadFields(Located({"at": Located(at, 0)}, 0), "trigger"))
    conditions = templates_of(automation).conditions(template_text(node))
    texts = [_positive(text) for condition in conditions for text in condition]
    if (household := _household(automation, texts, is_any=len(conditions) == 1)) != "":
        texts, conditions = [household], [(household,)]
    if len(conditions) == 1 and len(texts) > 1:
        return [*_any_state(automation, texts, lasting)]
    if any(len(condition) != 1 for condition in conditions) or not texts:
        raise NotCarriedError("trigger template: `or` of several, or with `for`; write each as a trigger")
    raw = [text for condition in conditions for text in condition]  # an unknown place is none
    return [*_all_states(texts, raw, lasting)]


def _all_states(texts: Sequence[str], raw: Sequence[str], lasting: str) -> Iterator[StartTrigger]:
    """Yield the triggers of states of which one begins while the others hold, or all have lasted."""
    begins = [_begin_of(text) for text in texts]
    if lasting:
        _check_lasting(texts)
    held = [bracketed(f"{text}{lasting}") for text in texts] if lasting else raw
    for begin, text in zip(begins, texts, strict=True):
        others = [need for need, other in zip(held, texts, strict=False) if not lasting or other != text]
        yield StartTrigger(f"{begin}{lasting}", needs=tuple((need,) for need in others if len(texts) > 1))


def _any_state(automation: Automation, texts: Sequence[str], lasting: str) -> Iterator[StartTrigger]:
    """Yield the triggers of states of which one begins, or has lasted, while none of the others does."""
    if lasting:
        _check_lasting(texts)
        automation.notes.append("each of its states lasts for itself")
    shorter = f" for less than{lasting.removeprefix(' for')}"
    for text in texts:
        needs = tuple(
            (*not_so, *([bracketed(f"{other}{shorter}")] if lasting else []))
            for other in texts
            if other != text
            for not_so in denied([(bracketed(other),)])
        )
        yield StartTrigger(f"{_begin_of(text)}{lasting}", needs=needs)


def _check_lasting(texts: Sequence[str]) -> None:
    if any(" for " in text or text in _SUN_BEGINS or _SPAN.match(text) for text in texts):
        raise NotCarriedError("trigger template: `for` of the sun, or of what lasts already; write it without")


def _positive(text: str) -> str:
    """Return a state without brackets; that a person is not in a place as that of being in another one."""
    if (elsewhere := _ELSEWHERE.fullmatch(text)) is not None:
        return f"{elsewhere['who']} place!={elsewhere['place']}"
    return text[1:-1] if text[:1] == "(" else text


_ELSEWHERE: Final = re.compile(r"not \((?P<who>[^()]*) place=(?P<place>'[^'()]*')\)")


def _household(automation: Automation, texts: Sequence[str], *, is_any: bool) -> str:
    """Return the state of all persons in the place of that of each of them; empty unless *texts* name all."""
    ends = {text.rpartition(" is ")[2] for text in texts if text.endswith((" is home", " is away"))}
    if len(texts) < 2 or len(ends) != 1 or len({*texts}) != automation.entities.people:
        return ""
    return {
        ("home", True): "somebody is home",
        ("home", False): "everybody is home",
        ("away", False): "nobody is home",
    }.get((ends.pop(), is_any), "")


def _begin_of(text: str) -> str:
    """Return the trigger of a state that begins."""
    if (begin := _SPAN.match(text)) is not None:
        return begin["time"]
    is_of_sun = text in _SUN_BEGINS or text.startswith(("sun elevation ", "sun azimuth "))
    is_state = is_of_device(text) and not text.startswith(("not ", "{"))
    if not (is_of_sun or is_state or text.endswith((" is home", " is away"))):
        raise NotCarriedError("trigger template: only states start a routine; write the times as triggers")
    return _SUN_BEGINS.get(text, text)


_SPAN: Final = re.compile(r"(?:between|after) (?P<time>\d\d?:\d\d)(?: |$)")
"""A span of each day, which begins at a time."""

_READERS: Final[Mapping[str, Callable[[Automation, UnreadFields], list[StartTrigger]]]] = {
    **{kind: partial(_states, kind) for kind in STATES},
    "time": _times,
    "time_pattern": _pattern,
    "homeassistant": _start,
    "sun": lambda _, fields: [StartTrigger(sun_moment(fields, fields.text("event"), "offset"))],
    "mqtt": message_triggers,
    "event": event_triggers,
    "tag": tag_triggers,
    "template": _template,
    "state": state_triggers,
}
_SUN_BEGINS: Final = {"sun is up": "sunrise", "sun is down": "sunset"}
"""The triggers with which these conditions begin to hold."""
