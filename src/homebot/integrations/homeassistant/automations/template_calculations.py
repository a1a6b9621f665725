"""Calculations in the templates of automations, in the words of homebot. Pure.

Source: Jinja 3.1 documentation, Expressions and List of Builtin Filters; Home Assistant core 2026.11,
``helpers/template``: of ``float(0)`` the 0 counts while a state is no number.
"""

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.integrations.homeassistant.automations.entities import Automation
from homebot.integrations.homeassistant.automations.expressions import (
    constant_number,
    entity_value,
    expression_of,
    path_of,
    refused_template,
    shown_tree,
    state_entity,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import SUN_ANGLES, number_of
from homebot.integrations.homeassistant.automations.template_lists import count_text, counted_list, listed_numbers
from homebot.integrations.homeassistant.automations.template_numbers import step_number
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes
from homebot.support.located import Located

_MAX_DEPTH: Final = 20
_RANKS: Final[Mapping[type[nodes.Expr], int]] = {nodes.Add: 1, nodes.Sub: 1, nodes.Mul: 2, nodes.Div: 2}
"""How much operations bind."""


def is_calculated(node: nodes.Node) -> bool:
    """Return whether *node* calculates with values."""
    kinds = (nodes.BinExpr, nodes.Filter, nodes.Call)
    return any(map(_calculates, (node, *node.find_all(kinds))))


def _calculates(node: nodes.Node) -> bool:
    match node:
        case nodes.BinExpr() | nodes.Filter(name="abs" | "round" | "min" | "max" | "sum" | "average"):
            return True
        case nodes.Call(node=nodes.Name(name="min" | "max" | "average")):
            return True
    return False


def calculation_text(automation: Automation, node: nodes.Expr, *, may_be_unknown: bool = True) -> str:
    """Return the number *node* as a calculation of homebot.

    Args:
        may_be_unknown: Whether a value without a default may be in it: a step is left out while it is unknown.

    Raises:
        NotCarriedError: It is no number, or one of its values is not known to homebot as one.
    """
    calculation = _Calculation(automation, may_be_unknown=may_be_unknown)
    text = calculation.text(node)
    if not calculation.has_values:
        raise refused_template(shown_tree(node))
    if calculation.has_unknown:
        automation.notes.append("what is calculated with a number of the house is left out while that is unknown")
    return _without_brackets(text)


_SECONDS: Final = {"hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
_CLOCK_OF_ONE: Final = re.compile(r"(?:00?:)*(\{\{[^{}]*\}\})(?P<after>(?::00)*)")
"""A length of time such as ``00:{{ … }}:00``."""


def step_length(automation: Automation, node: Located) -> str:
    """Return a length of time that a number of the house tells, such as ``{number of pause}m``; empty for another."""
    text, seconds = node.value, 1.0
    if isinstance(text, dict):
        given = {unit: inner for unit, inner in text.items() if str(inner.value) not in {"0", "00"}}
        unit = next(iter(given), "")
        if len(given) != 1 or unit not in _SECONDS:
            return ""
        text, seconds = given[unit].value, _SECONDS[unit]
    elif isinstance(text, str) and (clock := _CLOCK_OF_ONE.fullmatch(text)):
        text, seconds = clock[1], 60.0 ** clock["after"].count(":")
    if not isinstance(text, str) or "{{" not in text:
        return ""
    with suppress(NotCarriedError):
        value, factor = step_number(automation, text)
        letter = next((name[0] for name, length in _SECONDS.items() if math.isclose(length, factor * seconds)), "")
        if letter:
            return f"{value}{letter}"
    number = calculation_text(automation, expression_of(text))
    return f"{{{number}}}s" if seconds == 1.0 else f"{{({number}) * {seconds:.12g}}}s"


def _without_brackets(text: str) -> str:
    """Return *text* without the brackets around all of it."""
    depth = 0
    for place, character in enumerate(text if text[:1] == "(" else ""):
        depth += (character == "(") - (character == ")")
        if not depth:
            return text[1:-1] if place == len(text) - 1 else text
    return text


def _given(node: nodes.Expr | None) -> nodes.Expr:
    assert node is not None  # noqa: S101 - only the filter of a block has none
    return node


class _Calculation:
    """A calculation while it is read.

    Attributes:
        has_values: Whether it has a value that is no constant.
        has_unknown: Whether one of these has no default.
    """

    def __init__(self, automation: Automation, *, may_be_unknown: bool) -> None:
        self._automation = automation
        self._may_be_unknown = may_be_unknown
        self._depth = 0
        self.has_values = False
        self.has_unknown = False

    def text(self, node: nodes.Expr | None) -> str:
        """Return the text of *node*; a sum or product is in brackets."""
        self._depth += 1
        if self._depth > _MAX_DEPTH:
            raise NotCarriedError("template: it calculates with too many values in others")
        text = self._text(_given(node))
        self._depth -= 1
        return text

    def _text(self, node: nodes.Expr) -> str:
        match node:
            case nodes.Name(name=name) if name in self._automation.expressions:
                return self.text(expression_of(self._automation.expressions[name]))
            case nodes.Const() | nodes.Neg(node=nodes.Const()):
                return f"{constant_number(node):.12g}"
            case nodes.Neg(node=inner):
                return f"(0 - {self.text(inner)})"
            case nodes.Pos(node=inner):
                return self.text(inner)
            case nodes.Add() | nodes.Sub() | nodes.Mul() | nodes.Div():
                rank = _RANKS[type(node)]
                return f"({self._side(node.left, rank)} {node.operator} {self._side(node.right, rank + 1)})"
            case (
                nodes.Filter(name="min" | "max" | "sum" | "average" as name, node=inner, args=[])
                | nodes.Call(node=nodes.Name(name="min" | "max" | "average" as name), args=[inner])
            ) if items := listed_numbers(inner):
                return self._of_several(name, items)
            case nodes.Call(node=nodes.Name(name="min" | "max" | "average" as name), args=[_, _, *_] as items):
                return self._of_several(name, items)
            case nodes.Filter(name="abs" as name, node=inner):
                return self._function(name, [inner])
            case nodes.Filter(name="round", node=inner, args=[] | [_]) if not node.kwargs:
                return self._function("round", [inner, *(digits for digits in node.args if digits != nodes.Const(0))])
            case nodes.Filter(name="default" | "d", node=inner, args=[default, *_]):
                return self._with_default(_given(inner), default)
            case (
                nodes.Filter(name="float" | "int" as name, node=inner)
                | nodes.Call(node=nodes.Name(name="float" | "int" as name), args=[inner, *_])
            ):
                given = node.args if isinstance(node, nodes.Filter) else node.args[1:]
                text = self._number(node, _given(inner), given)
                return f"int({_without_brackets(text)})" if name == "int" else text
        return self._value(node)

    def _number(self, node: nodes.Filter | nodes.Call, value: nodes.Expr, given: Sequence[nodes.Expr]) -> str:
        """Return the number of *value*, or else the default that *node*, with the arguments *given*, has for it."""
        defaults = [*given[:1], *(one.value for one in node.kwargs if one.key == "default")]
        return self._with_default(value, defaults[0]) if defaults else self._measured(value) or self.text(value)

    def _of_several(self, name: str, items: Sequence[nodes.Expr]) -> str:
        if name in {"min", "max"} and len(items) > 1:
            return self._function(name, items)
        total = " + ".join(self.text(item) for item in items)
        return f"(({total}) / {len(items)})" if name == "average" else f"({total})"

    def _function(self, name: str, items: Sequence[nodes.Expr | None]) -> str:
        return f"{name}({', '.join(_without_brackets(self.text(item)) for item in items)})"

    def _side(self, node: nodes.Expr, least: int) -> str:
        """Return a side of an operation, in brackets unless its own operation binds at least so much."""
        text = self.text(node)
        return _without_brackets(text) if _RANKS.get(type(node), 0) >= least else text

    def _with_default(self, node: nodes.Expr, default: nodes.Expr) -> str:
        """Return the value *node* with the number that counts while it is unknown; a calculated one is known."""
        value = self._measured(node, has_default=True)
        if not value:
            return self.text(node)
        if value.startswith("sun "):
            return value
        return f"default({_without_brackets(value)}, {constant_number(default):.12g})"

    def _value(self, node: nodes.Expr) -> str:
        if state_entity(node):
            raise refused_template(shown_tree(node), "a state is a text; write `float(0)` behind it")
        if value := self._measured(node):
            return value
        if (known := counted_list(node)) is not None:
            self.has_values = True
            return count_text(self._automation, known)
        raise refused_template(shown_tree(node))

    def _measured(self, node: nodes.Expr, *, has_default: bool = False) -> str:
        """Return the state or attribute of an entity, in the unit of Home Assistant; empty for another value."""
        entity_id, attribute = entity_value(node)
        match node:
            case nodes.Getattr() if len(path := path_of(node)) == 5 and path[0] == "states":
                entity_id, attribute = f"{path[1]}.{path[2]}", path[4]
        if not entity_id:
            return ""
        self.has_values = True
        if entity_id == "sun.sun" and attribute in SUN_ANGLES:
            return f"sun {attribute}"
        entity, capability, factor = number_of(self._automation.entities, entity_id, attribute)
        if CAPABILITIES.get(capability, OWN).kind != "number" or entity.unit:
            raise NotCarriedError(f"{entity_id} has no number in the unit of homebot with which it can calculate")
        if not has_default and not self._may_be_unknown:
            raise refused_template(shown_tree(node), "it may be unknown; write `float(0)`, or the value then")
        self.has_unknown |= not has_default
        value = f"{capability} of {entity.query}"
        return value if factor == 1.0 else f"({value} / {factor:.12g})"
