"""Numbers in the templates of automations: those of entities, their limits and differences. Pure."""

import math
from collections.abc import Callable, Mapping
from typing import Final, NamedTuple

from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import Automation
from homebot.integrations.homeassistant.automations.expressions import (
    constant_number,
    entity_value,
    expression_of,
    path_of,
    refused_template,
    shown_tree,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import number_of, values_text
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes

SIGNS: Final[Mapping[str, Operator]] = {"gt": ">", "lt": "<", "gteq": ">=", "lteq": "<="}


class EntityNumber(NamedTuple):
    """A number in a template: the state of an entity, or its attribute, times *factor* plus *offset*."""

    entity: str
    attribute: str = ""
    default: float | None = None
    is_whole: bool = False
    factor: float = 1.0
    offset: float = 0.0


_SCALES: Final[Mapping[type[nodes.Expr], Callable[[float], tuple[float, float]]]] = {
    nodes.Mul: lambda value: (value, 0.0),
    nodes.Div: lambda value: (1 / value, 0.0),
    nodes.Add: lambda value: (1.0, value),
    nodes.Sub: lambda value: (1.0, -value),
}
"""The factor and the offset of a calculation with a constant."""


def number_of_tree(node: nodes.Expr) -> EntityNumber:
    """Return the number that *node* is."""
    match node:
        case nodes.Filter(name="float" | "int" as name, node=inner, args=args) if inner is not None:
            number = number_of_tree(inner)
            given = [*args[:1], *(one.value for one in node.kwargs if one.key == "default")]
            default = next(map(constant_number, given), None)
            if number.factor != 1.0 or number.offset or (number.is_whole and name == "float"):
                raise refused_template(shown_tree(node))
            return number._replace(default=default, is_whole=name == "int" or number.is_whole)
        case nodes.Filter(name="default" | "d", node=inner, args=[value, *_]) if inner is not None:
            return number_of_tree(inner)._replace(default=constant_number(value))
        case nodes.Call(node=nodes.Name(name="float" | "int" as name), args=[inner, *args]):
            number = number_of_tree(inner)
            return number._replace(default=next(map(constant_number, args), None), is_whole=name == "int")
        case nodes.BinExpr(left=inner, right=nodes.Const(value=int() | float() as value)) if type(node) in _SCALES:
            if value or isinstance(node, nodes.Add | nodes.Sub):
                number, (factor, offset) = number_of_tree(inner), _SCALES[type(node)](float(value))
                if number.is_whole:
                    raise NotCarriedError("template: it calculates with `int`; use `float`")
                return number._replace(factor=number.factor * factor, offset=number.offset * factor + offset)
    return _of_entity(node)


def _of_entity(node: nodes.Expr) -> EntityNumber:
    """Return the state, or the attribute, that *node* is."""
    entity, attribute = entity_value(node)
    if entity:
        return EntityNumber(entity, attribute)
    if len(path := path_of(node)) == 5 and path[0] == "states" and path[3] == "attributes":
        return EntityNumber(f"{path[1]}.{path[2]}", path[4])
    raise refused_template(shown_tree(node))


EQUAL: Final = 0.0001
"""The difference up to which two values count as one."""


def extreme_of(node: nodes.Expr) -> tuple[str, list[nodes.Expr]] | None:
    """Return ``min`` or ``max``, and the values of which *node* is the least or the greatest; None for another one.

    Raises:
        NotCarriedError: A value may be unknown, which ends the whole template.
    """
    match node:
        case nodes.Filter(name="float", node=inner, args=[]) if inner is not None:
            return extreme_of(inner)
        case nodes.Filter(name="min" | "max" as name, node=nodes.List(items=[_, *_] as items), args=[]):
            for item in items:
                if not isinstance(item, nodes.Const) and number_of_tree(item).default is None:
                    raise refused_template(shown_tree(item), "it may be unknown; write `float(0)`, or the value then")
            return name, items
    return None


def is_of_two(node: nodes.Expr) -> bool:
    """Return whether *node* is a sum or difference of two values."""
    while isinstance(node, nodes.Filter) and node.name in {"float", "round", "int"} and node.node is not None:
        node = node.node
    if not isinstance(node, nodes.Add | nodes.Sub):
        return False
    return not any(isinstance(side, nodes.Const | nodes.Neg) for side in (node.left, node.right))


def summands(node: nodes.Expr, sign: float) -> list[EntityNumber]:
    """Return the numbers whose sum *node* is, times *sign*; one without an entity is only an offset."""
    match node:
        case nodes.Const() | nodes.Neg(node=nodes.Const()):
            return [EntityNumber("", offset=sign * constant_number(node))]
        case nodes.Neg(node=inner):
            return summands(inner, -sign)
        case nodes.Add(left=left, right=right):
            return [*summands(left, sign), *summands(right, sign)]
        case nodes.Sub(left=left, right=right):
            return [*summands(left, sign), *summands(right, -sign)]
        case nodes.Filter(name="float" | "round", node=nodes.Add() | nodes.Sub() as inner):
            return summands(inner, sign)
    number = number_of_tree(node)
    return [number._replace(factor=sign * number.factor, offset=sign * number.offset)]


def whole_limit(sign: Operator, limit: float) -> tuple[Operator, float]:
    """Return the limit of a number for that of its whole part, which is cut towards 0."""
    at = math.floor(limit)
    if limit != at or at < 0 or (at == 0 and sign in {"<", ">="}):
        raise NotCarriedError("template: `int` cuts a number off; compare with `float`")
    match sign:
        case ">":
            return ">=", at + 1
        case "<=":
            return "<", at + 1
    return sign, limit


def holds(number: float, sign: str, limit: float) -> bool:
    """Return whether *number* is on the side *sign* of *limit*, or at it."""
    sides = {">": number > limit, "<": number < limit, ">=": number >= limit, "<=": number <= limit}
    return number == limit if sign == "==" else sides[sign]


def people_text(automation: Automation, sign: str, limit: float) -> str:
    """Return the state of the household for a limit of the number of people at home."""
    if not automation.entities.knows_people:
        raise NotCarriedError("zone.home: nobody is known; write the persons in the table [people]")
    if (sign, limit) in {(">", 0.0), (">=", 1.0)}:
        return "somebody is home"
    if (sign, limit) in {("<", 1.0), ("<=", 0.0)}:
        return "nobody is home"
    all_of_them = float(automation.entities.people)
    sides = {
        (">", all_of_them - 1): "",
        (">=", all_of_them): "",
        ("<", all_of_them): "not ",
        ("<=", all_of_them - 1): "not ",
    }
    if all_of_them > 1 and (sign, limit) in sides:
        automation.notes.append("zone.home is taken as all of [people]")
        return f"{sides[sign, limit]}everybody is home"
    raise NotCarriedError("zone.home: homebot does not count people; ask for none, any or all")


def step_number(automation: Automation, text: str) -> tuple[str, float]:
    """Return the number of an entity for a step, and the factor with which the template *text* takes it."""
    node, factor = expression_of(text), 1.0
    while True:
        match node:
            case nodes.Name(name=name) if name in automation.expressions:
                node = expression_of(automation.expressions[name])
            case nodes.Filter(name="float" | "int" | "round", node=inner) if inner is not None:
                node = inner
            case nodes.Mul(left=inner, right=nodes.Const(value=int() | float() as times)) if times:
                node, factor = inner, factor * times
            case nodes.Div(left=inner, right=nodes.Const(value=int() | float() as parts)) if parts:
                node, factor = inner, factor / parts
            case nodes.Call(node=nodes.Name(name="float" | "int"), args=[inner, *_]):
                node = inner
            case _:
                break
    number = number_of_tree(node)
    entity, capability, own = number_of(automation.entities, number.entity, number.attribute)
    if number.offset or entity.unit or not capability:
        raise refused_template(text, "a step takes a number of the house as it is")
    automation.notes.append("a number of the house is taken as it is, and the step left out while it is unknown")
    return f"{{{capability} of {entity.query}}}", factor / own


_ENDS: Final = {("min", 1.0), ("max", 0.0)}
"""The ends of a share, at which a change ends anyway."""


def changed_number(text: str) -> EntityNumber | None:
    """Return the number of an entity that *text* changes by an offset; None for another template."""
    try:
        node = expression_of(text)
        while isinstance(node, nodes.Filter):
            match node.name, node.node:
                case "min" | "max" as name, nodes.List(items=[new, nodes.Const(value=end)]) if (name, end) in _ENDS:
                    node = new
                case "round" | "float" | "int", nodes.Filter() | nodes.Add() | nodes.Sub() as new:
                    node = new
                case _:
                    return None
        if not isinstance(node, nodes.Add | nodes.Sub):
            return None
        offset = constant_number(node.right) * (1 if isinstance(node, nodes.Add) else -1)
        number = number_of_tree(node.left)
    except NotCarriedError:
        return None
    return number._replace(offset=offset) if number.factor == 1.0 and not number.offset and offset else None


def two_values_text(automation: Automation, left: nodes.Expr, sign: str, right: nodes.Expr) -> str:
    """Return the condition that one value is above or below another."""
    if sign not in SIGNS:
        raise refused_template(shown_tree(left), "two values are compared by < and >")
    numbers = [*summands(left, 1.0), *summands(right, -1.0)]
    offset = sum(number.offset for number in numbers)
    numbers = sorted((number for number in numbers if number.entity), key=lambda number: -number.factor)
    if [number.factor for number in numbers] != [1.0, -1.0]:
        raise refused_template(shown_tree(left), "it calculates with two values; only their difference is compared")
    if any(number.default is not None for number in numbers):
        automation.notes.append("a comparison does not hold while one of its values is unknown")
    if any(number.is_whole for number in numbers):
        automation.notes.append("two values are compared as they are, without cutting their fractions off")
    first, second = numbers
    equal = EQUAL if sign in {"gteq", "lteq"} else 0.0
    return values_text(
        automation.entities,
        (first.entity, first.attribute),
        SIGNS[sign][0],
        (second.entity, second.attribute),
        -offset + (equal if sign == "lteq" else -equal),
    )
