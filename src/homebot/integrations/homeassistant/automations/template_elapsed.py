"""Times since the last change of an entity, or since the last run, in the templates of automations. Pure."""

import math
from typing import Final, NamedTuple

from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import Automation
from homebot.integrations.homeassistant.automations.expressions import (
    constant_number,
    entity_value,
    path_of,
    state_entity,
)
from homebot.integrations.homeassistant.automations.template_numbers import SIGNS
from homebot.integrations.homeassistant.automations.template_times import is_now, is_today
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes

_SAME_TIME: Final = frozenset({"as_timestamp", "as_datetime", "as_local", "float", "default", "d", "strptime"})
"""Functions and filters after which a time is the same."""

_UNITS: Final = {"weeks": 604_800.0, "days": 86_400.0, "hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
_ROUNDED: Final = {">": 0.5, "<=": 0.5, ">=": -0.5, "<": -0.5}
_TURNED: Final[dict[str, Operator]] = {">": "<", "<": ">", ">=": "<=", "<=": ">="}


class Elapsed(NamedTuple):
    """A limit of the seconds since the time *last*."""

    last: nodes.Node
    sign: Operator
    seconds: float


def elapsed_limit(left: nodes.Expr, sign: str, right: nodes.Expr) -> Elapsed | None:
    """Return the limit of the time since another one that ``left sign right`` is; None for another comparison."""
    if sign not in SIGNS:
        return None
    left, shift = _unrounded(left, SIGNS[sign])
    now, seconds, others = 0.0, 0.0, []
    for factor, node in [*_terms(left, 1.0), *((-factor, node) for factor, node in _terms(right, 1.0))]:
        if node is None:
            seconds += factor
        elif is_now(node) or (isinstance(node, nodes.Call) and node.node == nodes.Name("utcnow", "load")):
            now += factor
        else:
            others.append((factor, node))
    if not now or len(others) != 1 or not math.isclose(now, -others[0][0]):
        return None
    return Elapsed(others[0][1], SIGNS[sign] if now > 0 else _TURNED[SIGNS[sign]], (shift - seconds) / now)


def _unrounded(node: nodes.Expr, sign: Operator) -> tuple[nodes.Expr, float]:
    """Return *node* without its rounding, and by how much its limit is another one then."""
    rounding = ""
    while isinstance(node, nodes.Filter) and node.name in {"int", "float", "round"} and node.node is not None:
        rounding = node.name if node.name != "float" and not rounding else rounding
        node = node.node
    match node:
        case nodes.Getattr(node=nodes.Sub() as inner, attr="days"):
            return nodes.Div(inner, nodes.Const(_UNITS["days"])), 1.0 if sign in {">", "<="} else 0.0
    if rounding == "int":  # the whole part is above 10 from 11 on
        return node, 1.0 if sign in {">", "<="} else 0.0
    return node, _ROUNDED[sign] if rounding else 0.0


def _terms(node: nodes.Node, factor: float) -> list[tuple[float, nodes.Node | None]]:
    """Return the times whose sum *node* is, with their factors; a number of seconds has no node."""
    match node:
        case nodes.Const(value=int() | float() as value) if not isinstance(value, bool):
            return [(factor * value, None)]
        case nodes.Call(node=nodes.Name(name="timedelta"), args=[], kwargs=given):
            return [(factor * _UNITS[one.key] * constant_number(one.value), None) for one in given if one.key in _UNITS]
        case nodes.Call(node=nodes.Name(name=name), args=[inner, *_]) if name in _SAME_TIME:
            return _terms(inner, factor)
        case nodes.Filter(name=name, node=inner) if inner is not None and name in {*_SAME_TIME, "int"}:
            return _terms(inner, factor)
        case nodes.Call(node=nodes.Getattr(node=inner, attr="total_seconds" | "timestamp"), args=[]):
            return _terms(inner, factor)
        case nodes.Getattr(node=nodes.Sub() as inner, attr="seconds"):
            return _terms(inner, factor)
        case nodes.Add(left=left, right=right):
            return [*_terms(left, factor), *_terms(right, factor)]
        case nodes.Sub(left=left, right=right):
            return [*_terms(left, factor), *_terms(right, -factor)]
        case nodes.Mul(left=inner, right=nodes.Const(value=int() | float() as value)):
            return _terms(inner, factor * value)
        case nodes.Div(left=inner, right=nodes.Const(value=int() | float() as value)) if value:
            return _terms(inner, factor / value)
    return [(factor, node)]


def moment_entity(node: nodes.Node) -> str:
    """Return the entity with the state that is the moment *node*; empty for another expression."""
    ((_, moment), *others) = _terms(node, 1.0)
    match moment:
        case nodes.Call(node=nodes.Name(name="today_at"), args=[inner]):
            moment = inner
    return state_entity(moment) if moment is not None and not others else ""


def clock_helper(node: nodes.Node) -> tuple[str, float]:
    """Return the helper of whose time of day *node* is the text, and the seconds after it; else an empty id."""
    match node:
        case nodes.Getitem(node=inner, arg=nodes.Slice(start=None | nodes.Const(value=0), stop=nodes.Const(value=5))):
            return helper_of(inner), 0.0
        case nodes.Filter(
            name="timestamp_custom",
            node=nodes.Node() as inner,
            args=[nodes.Const(value="%H:%M" | "%H:%M:%S"), nodes.Const(value=False)],
        ):
            terms = _terms(inner, 1.0)
            moments = [(factor, term) for factor, term in terms if term is not None]
            if len(moments) == 1 and moments[0][0] == 1.0:
                return helper_of(moments[0][1]), sum(factor for factor, term in terms if term is None)
    return helper_of(node) if state_entity(node) else "", 0.0


def helper_of(node: nodes.Node) -> str:
    """Return the helper of the moment *node*; empty for another expression."""
    entity, attribute = entity_value(node)
    return entity if entity.startswith("input_datetime.") and attribute in {"", "timestamp"} else ""


def is_run_today(automation: Automation, node: nodes.Expr) -> bool | None:
    """Return whether *node* asks that *automation* ran today, or that it did not; None for another expression."""
    match node:
        case nodes.Compare(expr=left, ops=[nodes.Operand(op="eq" | "ne" as sign, expr=right)]) if (
            is_today(left) and _is_day_of_run(automation, right)
        ) or (is_today(right) and _is_day_of_run(automation, left)):
            return sign == "eq"
    return None


def _is_day_of_run(automation: Automation, node: nodes.Node) -> bool:
    """Return whether *node* is the date of the last run."""
    match node:
        case nodes.Getitem(node=inner, arg=nodes.Slice(start=None | nodes.Const(value=0), stop=nodes.Const(value=10))):
            return state_entity(inner) in automation.entities.marks
    return automation.entities.marks.get(state_entity(node)) is False


def is_last_run(automation: Automation, node: nodes.Node | None) -> bool:
    """Return whether *node* is the time of the last run of *automation*."""
    while isinstance(node, nodes.Filter | nodes.Or):
        node = node.left if isinstance(node, nodes.Or) else node.node
    match node:
        case nodes.Call(
            node=nodes.Name(name="state_attr"),
            args=[nodes.Const(value=entity), nodes.Const(value="last_triggered")],
        ):
            return str(entity).removeprefix("automation.") in automation.own_ids
        case nodes.Call(node=nodes.Name(name="states"), args=[nodes.Const(value=entity)]):
            return automation.entities.marks.get(str(entity), False)
        case nodes.Call(
            node=nodes.Name(name="state_attr"), args=[nodes.Const(value=entity), nodes.Const(value="timestamp")]
        ):
            return automation.entities.marks.get(str(entity), False)
        case nodes.Call(node=nodes.Name(name="state_attr"), args=[inner, nodes.Const(value="last_triggered")]):
            return path_of(inner) == ("this", "entity_id")
        case nodes.Getattr(node=nodes.Getattr(attr="attributes") as inner, attr="last_triggered"):
            path = path_of(inner)[:-1]
            return path == ("this",) or (path[:2] == ("states", "automation") and path[2] in automation.own_ids)
    return False
