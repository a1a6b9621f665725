"""Times in the templates of automations: of now, of the last run and of last changes. Pure."""

import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import date, datetime, timedelta
from itertools import pairwise
from typing import Any, Final

from homebot.integrations.homeassistant.automations.entities import NEVER, Condition
from homebot.integrations.homeassistant.automations.expressions import refused_template, shown_tree
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.template_numbers import holds
from homebot.integrations.homeassistant.automations.variables import is_constant
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes, parse
from homebot.integrations.homeassistant.formats.jinja.values import TemplateError
from homebot.support.located import Located
from homebot.words.times import read_span

_DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_MONTHS: Final = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_CLOCK: Final = re.compile(r"([01]\d|2[0-3]):[0-5]\d(:[0-5]\d)?")


def is_now(node: nodes.Node) -> bool:
    """Return whether *node* is ``now()``."""
    return isinstance(node, nodes.Call) and node.node == nodes.Name("now", "load") and not node.args


def is_today(node: nodes.Node) -> bool:
    """Return whether *node* is the date of today as text."""
    match node:
        case nodes.Call(node=nodes.Name(name="states"), args=[nodes.Const(value="sensor.date")]):
            return True
        case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value="%Y-%m-%d")]):
            return is_now(inner)
        case (
            nodes.Filter(name="string", node=nodes.Call(node=nodes.Getattr(node=inner, attr="date")))
            | nodes.Call(
                node=nodes.Getattr(node=nodes.Call(node=nodes.Getattr(node=inner, attr="date")), attr="isoformat")
            )
        ):
            return is_now(inner)
    return False


def _is_timestamp(node: nodes.Node | None) -> bool:
    match node:
        case nodes.Call(node=nodes.Getattr(node=inner, attr="timestamp"), args=[]):
            return is_now(inner)
        case (
            nodes.Call(node=nodes.Name(name="as_timestamp"), args=[inner])
            | nodes.Filter(name="as_timestamp", node=inner)
        ):
            return inner is not None and is_now(inner)
    return False


def clock_of_today(node: nodes.Node) -> str:
    """Return the time of day of ``today_at('07:00')``; empty for another expression."""
    match node:
        case nodes.Call(node=nodes.Name(name="today_at"), args=[nodes.Const(value=str(clock))]):
            return clock
    return ""


_UNITS: Final = {**dict.fromkeys(("%H:%M", "%H:%M:%S", "%T"), "clock"), **dict.fromkeys(("%a", "%A"), "day")}
"""The units of times in a form."""


def unit_of_now(node: nodes.Node) -> str:
    """Return the unit of the time that *node* is, such as ``hour``; empty for another expression."""
    match node:
        case nodes.Call(node=nodes.Name(name="states"), args=[nodes.Const(value="sensor.time")]):
            return "clock"
        case nodes.Filter(name="timestamp_custom", node=inner, args=[nodes.Const(value="%H:%M" | "%H:%M:%S")]) if (
            _is_timestamp(inner)
        ):
            return "clock"
        case nodes.Getattr(node=inner, attr="hour" | "month" as unit) if is_now(inner):
            return unit
        case nodes.Call(node=nodes.Getattr(node=inner, attr="weekday" | "isoweekday" as unit), args=[]) if is_now(
            inner
        ):
            return unit
        case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]) if is_now(
            inner
        ):
            return _UNITS.get(form, "")
        case nodes.Filter(
            name="int", node=nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value="%H")])
        ) if is_now(inner):
            return "hour"
    return ""


_ORDER: Final[Mapping[str, Callable[[Any, Any], bool]]] = {
    **{name: getattr(operator, short) for name, short in (("gt", "gt"), ("lt", "lt"), ("gteq", "ge"), ("lteq", "le"))},
    "eq": operator.eq,
    "ne": operator.ne,
    "in": lambda value, several: value in several,
    "notin": lambda value, several: value not in several,
}

_LEAP_YEAR: Final = 2024
_OF_DAY: Final = re.compile(r"(?:%-?[dmbB]|[^%])*")


def days_of(node: nodes.Expr) -> list[Condition] | None:
    """Return the days of the year on which *node* holds; None for another expression, or one of whole months."""
    has_day = any(inner.attr == "day" and is_now(inner.node) for inner in node.find_all(nodes.Getattr))
    has_day = has_day or any(re.search("%-?d", str(inner.value)) for inner in node.find_all(nodes.Const))
    if not has_day:
        return None
    first = date(_LEAP_YEAR, 1, 1)
    days = [first + timedelta(days=number) for number in range(366)]
    try:
        held = [bool(_on_day(node, day)) for day in days]
    except (NotCarriedError, TypeError, ValueError):
        return None
    if all(held) or not any(held):
        return [] if held[0] else [NEVER]
    return [(f"on {','.join(_spans(days, held))}",)]


def _spans(days: Sequence[date], held: Sequence[bool]) -> Iterator[str]:
    """Yield the spans of the *days* of a year that are *held*, of which one may go on in the next year."""
    for start in range(366):
        if held[start] and not held[start - 1]:
            end = next(number for number in range(start + 1, start + 367) if not held[number % 366]) - 1
            ends = (days[number % 366] for number in (start, end))
            yield "-".join(dict.fromkeys(f"{day.day} {_MONTHS[day.month - 1]}" for day in ends))


def weeks_of(node: nodes.Expr) -> list[Condition] | None:
    """Return that the week of now, as ISO 8601 counts, is even or odd; None for another expression."""
    match node:
        case nodes.Compare(
            expr=nodes.Mod(left=week, right=nodes.Const(value=2)),
            ops=[nodes.Operand(op="eq" | "ne" as sign, expr=nodes.Const(value=0 | 1 as rest))],
        ) if _is_week(week):
            return [("in even weeks" if (rest == 0) is (sign == "eq") else "in odd weeks",)]
        case nodes.Test(name="even" | "odd" as kind, node=week) if _is_week(week):
            return [(f"in {kind} weeks",)]
    return None


def _is_week(node: nodes.Node) -> bool:
    while isinstance(node, nodes.Filter) and node.name == "int" and node.node is not None:
        node = node.node
    match node:
        case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value="%V")]):
            return is_now(inner)
        case (
            nodes.Getitem(node=nodes.Call(node=nodes.Getattr(node=inner, attr="isocalendar")), arg=nodes.Const(value=1))
            | nodes.Getattr(node=nodes.Call(node=nodes.Getattr(node=inner, attr="isocalendar")), attr="week")
        ):
            return is_now(inner)
    return False


def _on_day(node: nodes.Node, day: date) -> object:
    """Return the value of *node* on *day*."""
    match node:
        case nodes.Const(value=value):
            return value
        case nodes.And():
            return _on_day(node.left, day) and _on_day(node.right, day)
        case nodes.Or():
            return _on_day(node.left, day) or _on_day(node.right, day)
        case nodes.Not():
            return not _on_day(node.node, day)
        case nodes.List() | nodes.Tuple():
            return [_on_day(item, day) for item in node.items]
        case nodes.Compare():
            values = [_on_day(one, day) for one in (node.expr, *(operand.expr for operand in node.ops))]
            signs = [_ORDER[operand.op] for operand in node.ops]
            return all(sign(*two) for sign, two in zip(signs, pairwise(values), strict=True))
        case nodes.Getattr(node=inner, attr="month" | "day" as unit) if is_now(inner):
            return getattr(day, unit)
        case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]) if is_now(
            inner
        ) and _OF_DAY.fullmatch(form):
            return day.strftime(form)
        case nodes.Filter(name="int", node=inner, args=[]) if inner is not None:
            return int(str(_on_day(inner, day)))
    raise refused_template(shown_tree(node))


def _of_hours(hours: Sequence[int]) -> list[Condition]:
    begin, end = hours[0], hours[-1] + 1
    if begin and end < 24:
        return [(f"between {begin}:00 and {end}:00",)]
    return [(f"after {begin}:00" if begin else f"before {end}:00",)]


def _of_months(months: Sequence[int]) -> list[Condition]:
    return [("in " + "-".join(dict.fromkeys(_MONTHS[month - 1] for month in (months[0], months[-1]))),)]


_NUMBERED: Final[Mapping[str, tuple[range, Callable[[Sequence[int]], list[Condition]]]]] = {
    "hour": (range(24), _of_hours),
    "weekday": (range(7), lambda days: [(f"on {','.join(_DAYS[day] for day in days)}",)]),
    "isoweekday": (range(1, 8), lambda days: [(f"on {','.join(_DAYS[day - 1] for day in days)}",)]),
    "month": (range(1, 13), _of_months),
}
"""The numbers of a unit, and the conditions that it is now one of some of these."""


def of_time(unit: str, sign: str, value: object) -> list[Condition]:
    """Return the conditions that a time of now is so."""
    match value:
        case str(text) if unit == "clock" and _CLOCK.fullmatch(text):
            if sign != "==":
                side = "after" if sign[0] == ">" else "before"
                span = read_span(f"{side} {text}")
                return [(f"{side} {text}",)] if span is not None and span.begin != span.end else []
            if text.count(":") == 1:
                minute = datetime.strptime(text, "%H:%M") + timedelta(minutes=1)  # noqa: DTZ007 - of any day
                return [(f"between {text} and {minute:%H:%M}",)]
        case str(name) if unit == "day" and sign == "==" and name[:3].lower() in _DAYS:
            return [(f"on {name[:3].lower()}",)]
        case int(number) if unit in _NUMBERED:
            numbers, conditions_of = _NUMBERED[unit]
            held = [now for now in numbers if holds(now, sign, number)]
            if len(held) in {0, len(numbers)}:
                return [] if held else [NEVER]
            return conditions_of(held)
    raise NotCarriedError(f"template: now() against {value!r}")


def hours_of(hours: Sequence[object]) -> list[Condition]:
    """Return the conditions that it is one of *hours*, each of which follows on the one before; none for others."""
    first, last = hours[0], hours[-1]
    if not isinstance(first, int) or not isinstance(last, int) or [*hours] != [*range(first, last + 1)]:
        return []
    return [*of_time("hour", ">=", first), *of_time("hour", "<=", last)] if len(hours) > 1 else []


def random_ends(node: Located) -> tuple[Located, Located] | None:
    """Return a length with the least and the most of the only ``range(1, 30) | random`` in it; None for another."""
    if isinstance(node.value, dict):
        found = [(key, ends) for key, inner in node.value.items() if (ends := random_ends(inner))]
        if len(found) != 1:
            return None
        ((key, ends),) = found
        return node._replace(value={**node.value, key: ends[0]}), node._replace(value={**node.value, key: ends[1]})
    found_ends = [*_RANDOM.finditer(node.value)] if isinstance(node.value, str) else []
    if len(found_ends) != 1:
        return None
    least, most = int(found_ends[0]["least"] or 0), int(found_ends[0]["most"]) - 1
    texts = [_RANDOM.sub(str(number), str(node.value)) for number in (least, most)]
    try:
        first, last = (node._replace(value=parse(text).render({}).strip()) for text in texts)
    except TemplateError:
        return None
    return (first, last) if least < most and is_constant(first) else None


_RANDOM: Final = re.compile(r"\brange\( *(?:(?P<least>\d+) *, *)?(?P<most>\d+) *\) *\| *random\b")
