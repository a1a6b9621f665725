"""Templates of automations as conditions and messages of routines, as far as these say the same. Pure.

Source: Home Assistant core 2026.11, ``helpers/template``; of a number ``float(0)`` the 0 counts while it is unknown.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final, NamedTuple, Self, TypeAlias, TypeVar

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import Automation, StartTrigger
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import (
    attribute_of,
    elevation_text,
    limits_text,
    number_of,
    state_texts,
    value_name,
    values_text,
)
from homebot.integrations.homeassistant.automations.variables import is_constant
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes, parse, tree_of
from homebot.integrations.homeassistant.formats.jinja.values import TemplateError
from homebot.support.located import Located
from homebot.words.times import read_span

Condition: TypeAlias = tuple[str, ...]
"""Texts of which at least one must hold. A query is in brackets."""

NEVER: Final[Condition] = ()
"""It does not hold."""

AnyOf: TypeAlias = Callable[[Sequence[list[Condition]]], list[Condition]]
"""Returns the conditions that hold if those of at least one of several do."""

_SWAPPED: Final = {"gt": "lt", "lt": "gt", "gteq": "lteq", "lteq": "gteq", "eq": "eq", "ne": "ne"}
_SIGNS: Final[Mapping[str, Operator]] = {"gt": ">", "lt": "<", "gteq": ">=", "lteq": "<="}
_DENIED: Final[Mapping[str, Operator]] = {">": "<=", "<": ">=", ">=": "<", "<=": ">"}
_TURNED: Final[Mapping[str, Operator]] = {">": "<", "<": ">", ">=": "<=", "<=": ">="}
_DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_MONTHS: Final = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_CLOCK: Final = re.compile(r"([01]\d|2[0-3]):[0-5]\d(:[0-5]\d)?")
_MAX_SHOWN: Final = 60
_NodeT = TypeVar("_NodeT", bound=nodes.Node)


class _Number(NamedTuple):
    """A number in a template: the state of an entity, or its attribute, times *factor* plus *offset*."""

    entity: str
    attribute: str = ""
    default: float | None = None
    is_whole: bool = False
    factor: float = 1.0
    offset: float = 0.0


class Templates:
    """Reader of the templates of one automation.

    Args:
        any_of: Joins conditions by ``or``.
        denied: Denies conditions.
    """

    def __init__(
        self, automation: Automation, any_of: AnyOf, denied: Callable[[Sequence[Condition]], list[Condition]]
    ) -> None:
        self._automation = automation
        self._any_of = any_of
        self._denied = denied

    def conditions(self, text: str) -> list[Condition]:
        """Return the conditions that hold if the template *text* is true."""
        expression = expression_of(text)
        if isinstance(expression, nodes.Name) and expression.name in self._automation.expressions:
            expression = expression_of(self._automation.expressions[expression.name])
        return self._read(self._inlined(expression))

    def _inlined(self, node: _NodeT) -> _NodeT:
        """Put the templates of variables into *node*."""
        for key, value in node.iter_fields():
            if isinstance(value, nodes.Name) and value.name in self._automation.expressions:
                setattr(node, key, expression_of(self._automation.expressions[value.name]))
            elif isinstance(value, nodes.Node):
                self._inlined(value)
            elif isinstance(value, list):
                for inner in value:
                    if isinstance(inner, nodes.Node):
                        self._inlined(inner)
        return node

    def message(self, text: str) -> str:
        """Return the text of a message with the values of its template in braces."""
        if "{" not in text:
            return text
        pieces: list[str] = []
        unit = ""
        for part in _output_of(text):
            for node in part.nodes:
                if isinstance(node, nodes.TemplateData):
                    if "{" in node.data or "}" in node.data:
                        raise _refused(text, "braces in a message mean a value")
                    pieces.append(_without_unit(node.data, unit))
                    unit = ""
                else:
                    value, unit = self._value(node)
                    pieces.append(value)
        return "".join(pieces)

    def ways(self, call: Located) -> list[tuple[list[Condition], Located]]:
        """Return the calls that *call* becomes by the first choice in its templates, each with its conditions.

        The last one has none, or that of the last trigger; empty if nothing is to be chosen.
        """
        for path, text in _texts_in(call):
            try:
                parts = [node for part in _output_of(text) for node in part.nodes]
            except NotCarriedError:
                continue
            for place, node in enumerate(parts):
                given = [other.data if isinstance(other, nodes.TemplateData) else "" for other in parts]
                if any(not isinstance(other, nodes.TemplateData) for other in parts[:place] + parts[place + 1 :]):
                    continue
                if isinstance(node, nodes.CondExpr) and node.expr2 is not None:
                    if not isinstance(node.expr1, nodes.Const) or not isinstance(node.expr2, nodes.Const):
                        raise _refused(text, "it chooses between more than two values; write it as `choose`")
                    values = [(self._read(node.test), node.expr1.value), ([], node.expr2.value)]
                elif _path_of(node) == ("trigger", "to_state", "state") and path[-1] not in {"message", "title"}:
                    states = dict.fromkeys(trigger.state for trigger in self._automation.triggers)
                    if "" in states:
                        raise _refused(text, "not each trigger names a state")
                    values = [
                        (self.started_by([one for one in self._automation.triggers if one.state == state]), state)
                        for state in states
                    ]
                else:
                    continue
                return [
                    (held, _with_text(call, path, "".join((*given[:place], str(value), *given[place + 1 :]))))
                    for held, value in values
                ]
        return []

    def _value(self, node: nodes.Expr) -> tuple[str, str]:
        """Return a value for a message, and its unit, which homebot writes itself."""
        if isinstance(node, nodes.Const):
            return str(node.value), ""
        while isinstance(node, nodes.Filter) and node.name in {"float", "int", "round", "title", "lower", "upper"}:
            assert node.node is not None  # noqa: S101 - only the filter of a block has none
            node = node.node
        match _path_of(node):
            case ("trigger", "to_state", "name") | ("trigger", "to_state", "attributes", "friendly_name"):
                return "{name}", ""
            case ("trigger", "from_state", "name") | ("trigger", "entity_id") | ("trigger", "to_state", "entity_id"):
                return "{name}", ""
            case ("this", "attributes", "friendly_name") | ("this", "name"):
                return "{routine}", ""
            case ("trigger", "to_state", "state"):
                entities = {trigger.entity for trigger in self._automation.triggers}
                if len(entities) == 1 and "" not in entities:
                    return self._state_value(entities.pop(), "")
        match node:
            case nodes.Call(node=nodes.Name(name="states"), args=[nodes.Const(value=str(entity))]):
                return self._state_value(entity, "")
            case nodes.Call(
                node=nodes.Name(name="state_attr"), args=[nodes.Const(value=str(entity)), nodes.Const(value=attribute)]
            ) if attribute != "friendly_name":
                return self._state_value(entity, str(attribute))
            case nodes.Call(node=nodes.Name(name="area_name"), args=[inner]) if _path_of(inner)[:1] == ("trigger",):
                return "{room}", ""
            case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value="%H:%M")]) if (
                _is_now(inner)
            ):
                return "{time}", ""
            case nodes.Getattr(attr="state") if entity := _states_path(node.node):
                return self._state_value(entity, "")
        raise _refused(_text_of(node), "a message has states, {name}, {room}, {routine} and {time}")

    def _state_value(self, entity_id: str, attribute: str) -> tuple[str, str]:
        name, capability = value_name(self._automation.entities, entity_id, attribute)
        self._automation.notes.append(f"{entity_id} is written in the words of homebot, with its unit")
        return f"{{{capability} of {name}}}", CAPABILITIES.get(capability, OWN).unit

    def _read(self, node: nodes.Expr) -> list[Condition]:
        match node:
            case nodes.And():
                return [*self._read(node.left), *self._read(node.right)]
            case nodes.Or():
                return self._any_of([self._read(node.left), self._read(node.right)])
            case nodes.Not():
                return self._denied(self._read(node.node))
            case nodes.Const(value=bool(value)):
                return [] if value else [NEVER]
            case nodes.Compare(expr=left, ops=ops):
                conditions: list[Condition] = []
                for operand in ops:
                    conditions += self._compared(left, operand.op, operand.expr)
                    left = operand.expr
                return conditions
            case nodes.Call(node=nodes.Name(name="is_state"), args=[nodes.Const(value=str(entity)), wanted]):
                return self._any_of([[self._state(entity, str(state))] for state in _values_of(wanted)])
            case nodes.Call(
                node=nodes.Name(name="is_state_attr"),
                args=[nodes.Const(value=str(entity)), nodes.Const(value=attribute), nodes.Const(value=value)],
            ):
                return [(attribute_of(self._automation.entities, entity, str(attribute), value),)]
            case nodes.Getattr() if _path_of(node) == ("wait", "completed"):
                return [("not wait timed out",)]
            case nodes.Test(name="none", node=inner) if _path_of(inner) == ("wait", "trigger"):
                return [("wait timed out",)]
            case nodes.Filter(name="bool", node=inner) if inner is not None:
                return self._read(inner)
        raise _refused(_text_of(node))

    def _state(self, entity: str, state: str) -> Condition:
        (text,) = state_texts(self._automation.entities, entity, [state])
        return (bracketed(text),)

    def _compared(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition]:
        if sign in {"in", "notin"}:
            states = self._any_of([self._equal(left, value) for value in _values_of(right)])
            return states if sign == "in" else self._denied(states)
        if isinstance(left, nodes.Const) and not isinstance(right, nodes.Const):
            left, right, sign = right, left, _SWAPPED[sign]
        if not isinstance(right, nodes.Const | nodes.Neg):
            return [(self._of_two_values(left, sign, right),)]
        (value,) = _values_of(right)
        if sign == "eq":
            return self._equal(left, value)
        if sign == "ne":
            return self._denied(self._equal(left, value))
        return self._limited(left, _SIGNS[sign], value)

    def _of_two_values(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> str:
        """Return the condition that one value is above or below another."""
        if sign not in {"gt", "lt"}:
            raise _refused(_text_of(left), "two values are compared by < and >")
        numbers = _number_of(left), _number_of(right)
        if any(number.factor != 1.0 or number.is_whole for number in numbers):
            raise _refused(_text_of(left), "it calculates with two values")
        if any(number.default is not None for number in numbers):
            self._automation.notes.append("a comparison does not hold while one of its values is unknown")
        first, second = numbers
        return values_text(
            self._automation.entities,
            (first.entity, first.attribute),
            _SIGNS[sign],
            (second.entity, second.attribute),
            second.offset - first.offset,
        )

    def _equal(self, left: nodes.Expr, value: object) -> list[Condition]:
        path = _path_of(left)
        match path:
            case ("trigger", "id"):
                return self.started_by([trigger for trigger in self._automation.triggers if trigger.id == str(value)])
            case ("trigger", "entity_id") | ("trigger", "to_state", "entity_id"):
                return self._started_where(lambda trigger: trigger.entity == value)
            case ("trigger", "to_state", "state"):
                return self._started_where(lambda trigger: trigger.state == value)
            case ("wait", "trigger") if value is None:
                return [("wait timed out",)]
        if (unit := _unit_of_now(left)) and type(value) is int:
            return _of_time(unit, "==", value)
        if entity := _state_of(left):
            return [self._state(entity, str(value))]
        match left:
            case nodes.Call(
                node=nodes.Name(name="state_attr"), args=[nodes.Const(value=str(entity)), nodes.Const(value=attribute)]
            ):
                return [(attribute_of(self._automation.entities, entity, str(attribute), value),)]
        raise _refused(_text_of(left))

    def _started_where(self, holds: Callable[[StartTrigger], bool]) -> list[Condition]:
        if any(not trigger.entity for trigger in self._automation.triggers):
            raise NotCarriedError(
                "template: not each trigger is about a state; give the triggers an `id`, and ask for it"
            )
        return self.started_by([trigger for trigger in self._automation.triggers if holds(trigger)])

    def started_by(self, triggers: Sequence[StartTrigger]) -> list[Condition]:
        """Return the condition that one of *triggers*, which are some of its own, started the automation."""
        known = self._automation.triggers
        texts = dict.fromkeys(trigger.text for trigger in known if trigger in triggers)
        if not texts:
            return [NEVER]
        others = {trigger.text for trigger in known if trigger not in triggers}
        if twice := others & texts.keys():
            raise NotCarriedError(f"two triggers are the same for a routine: {min(twice)}")
        return [tuple(f"started by {text}" for text in texts)] if others else []

    def _limited(self, left: nodes.Expr, sign: Operator, value: object) -> list[Condition]:
        if unit := _unit_of_now(left):
            return _of_time(unit, sign, value)
        if self._since_last_run(left) and type(value) in (int, float):
            return [(f"last run {'over' if sign[0] == '>' else 'under'} {value}s ago",)]
        if type(value) not in (int, float):
            raise _refused(_text_of(left), "it compares a text")
        number = _number_of(left)
        limit = (float(str(value)) - number.offset) / number.factor
        sign = sign if number.factor > 0 else _TURNED[sign]
        if number.is_whole:
            sign, limit = _whole(sign, limit)
        if (number.entity, number.attribute) == ("sun.sun", "elevation"):
            return [(elevation_text(sign, limit),)]
        if number.entity == "zone.home" and not number.attribute:
            return [(_people(self._automation, sign, limit),)]
        entity, capability, factor = number_of(self._automation.entities, number.entity, number.attribute)
        limit *= factor
        if number.default is not None and _holds(number.default * factor, sign, limit):
            return [(f"not ({limits_text(entity, capability, [(_DENIED[sign], limit)])})",)]
        return [(f"({limits_text(entity, capability, [(sign, limit)])})",)]

    def _since_last_run(self, node: nodes.Node | None) -> bool:
        """Return whether *node* is the time in seconds since this automation ran."""
        while isinstance(node, nodes.Filter) and node.name in {"int", "float"}:
            node = node.node
        match node:
            case nodes.Call(node=nodes.Getattr(node=nodes.Sub(left=now, right=last), attr="total_seconds"), args=[]):
                return _is_now(now) and self._is_last_run(last)
            case nodes.Sub(
                left=nodes.Call(node=nodes.Name(name="as_timestamp"), args=[now]),
                right=nodes.Call(node=nodes.Name(name="as_timestamp"), args=[last, *_]),
            ):
                return _is_now(now) and self._is_last_run(last)
        return False

    def _is_last_run(self, node: nodes.Node | None) -> bool:
        while isinstance(node, nodes.Filter) and node.name in {"default", "d", "as_timestamp"}:
            node = node.node
        match node:
            case nodes.Call(
                node=nodes.Name(name="state_attr"),
                args=[nodes.Const(value=entity), nodes.Const(value="last_triggered")],
            ):
                return str(entity).removeprefix("automation.") in self._automation.own_ids
            case nodes.Getattr(node=nodes.Getattr(attr="attributes") as inner, attr="last_triggered"):
                path = _path_of(inner)[:-1]
                return path == ("this",) or (
                    path[:2] == ("states", "automation") and path[2] in self._automation.own_ids
                )
        return False


def expression_of(text: str) -> nodes.Expr:
    """Return the only expression of the template *text*."""
    if isinstance(text, _Expression):
        return text.tree
    parts = [node for part in _output_of(text) for node in part.nodes]
    parts = [node for node in parts if not (isinstance(node, nodes.TemplateData) and not node.data.strip())]
    if len(parts) == 1 and not isinstance(parts[0], nodes.TemplateData):
        return parts[0]
    plain = text.strip().casefold()
    if plain in {"true", "false"}:
        return nodes.Const(plain == "true")
    raise _refused(text)


def bracketed(text: str) -> str:
    """Return a state in brackets if it is a query, which others may be joined to."""
    return f"({text})" if "name=" in text and " of name=" not in text else text


def _output_of(text: str) -> list[nodes.Output]:
    try:
        body = tree_of(text).body
    except TemplateError as exc:
        raise _refused(text, f"it {exc.problem}") from exc
    outputs = [node for node in body if isinstance(node, nodes.Output)]
    if len(outputs) == len(body):
        return outputs
    match body:
        case [nodes.If(test=test, body=[nodes.Output(nodes=[nodes.TemplateData(data=yes)])], elif_=[], else_=others)]:
            no = "".join(
                part.data
                for output in others
                if isinstance(output, nodes.Output)
                for part in output.nodes
                if isinstance(part, nodes.TemplateData)
            )
            if (yes.strip().casefold(), no.strip().casefold()) in {("true", "false"), ("true", "")}:
                return [nodes.Output([test])]
    raise _refused(text, "it has statements")


def _refused(text: str, reason: str = "routines have no words for it") -> NotCarriedError:
    shown = " ".join(text.split())
    shown = shown if len(shown) <= _MAX_SHOWN else f"{shown[:_MAX_SHOWN]}…"
    return NotCarriedError(
        f"template {shown!r}: {reason}; carried over are states, numbers against limits, now() and the trigger"
    )


def _path_of(node: nodes.Node | None) -> tuple[str, ...]:
    """Return the names of ``trigger.to_state.state``; empty for another expression."""
    names: list[str] = []
    while isinstance(node, nodes.Getattr):
        names.append(node.attr)
        node = node.node
    return (node.name, *reversed(names)) if isinstance(node, nodes.Name) else ()


def _states_path(node: nodes.Node) -> str:
    """Return the entity of ``states.sensor.x``; empty for another expression."""
    path = _path_of(node)
    return ".".join(path[1:]) if len(path) == 3 and path[0] == "states" else ""


def _state_of(node: nodes.Node) -> str:
    """Return the entity of which *node* is the state; empty for another expression."""
    match node:
        case nodes.Call(node=nodes.Name(name="states"), args=[nodes.Const(value=str(entity))]):
            return entity
        case nodes.Getattr(attr="state"):
            return _states_path(node.node)
    return ""


def _number_of(node: nodes.Expr) -> _Number:
    match node:
        case nodes.Filter(name="float" | "int" as name, node=inner, args=args) if inner is not None:
            number = _number_of(inner)
            given = [
                _constant(value) for value in (*args[:1], *(one.value for one in node.kwargs if one.key == "default"))
            ]
            default = given[0] if given else None
            if number.factor != 1.0 or number.offset or (number.is_whole and name == "float"):
                raise _refused(_text_of(node))
            return number._replace(default=default, is_whole=name == "int" or number.is_whole)
        case nodes.Filter(name="default" | "d", node=inner, args=[value, *_]) if inner is not None:
            return _number_of(inner)._replace(default=_constant(value))
        case nodes.Call(node=nodes.Name(name="float" | "int" as name), args=[inner, *args]):
            number = _number_of(inner)
            return number._replace(default=_constant(args[0]) if args else None, is_whole=name == "int")
        case nodes.Mul(left=inner, right=nodes.Const(value=int() | float() as value)) if value:
            number = _number_of(inner)
            return _scaled(number, float(value), 0.0)
        case nodes.Div(left=inner, right=nodes.Const(value=int() | float() as value)) if value:
            return _scaled(_number_of(inner), 1 / float(value), 0.0)
        case nodes.Add(left=inner, right=nodes.Const(value=int() | float() as value)):
            return _scaled(_number_of(inner), 1.0, float(value))
        case nodes.Sub(left=inner, right=nodes.Const(value=int() | float() as value)):
            return _scaled(_number_of(inner), 1.0, -float(value))
        case nodes.Call(
            node=nodes.Name(name="state_attr"), args=[nodes.Const(value=str(entity)), nodes.Const(value=attribute)]
        ):
            return _Number(entity, str(attribute))
    if entity := _state_of(node):
        return _Number(entity)
    if len(path := _path_of(node)) == 5 and path[0] == "states" and path[3] == "attributes":
        return _Number(f"{path[1]}.{path[2]}", path[4])
    raise _refused(_text_of(node))


def _scaled(number: _Number, factor: float, offset: float) -> _Number:
    if number.is_whole:
        raise NotCarriedError("template: it calculates with `int`; use `float`")
    default = None if number.default is None else number.default
    return number._replace(factor=number.factor * factor, offset=number.offset * factor + offset, default=default)


def _whole(sign: Operator, limit: float) -> tuple[Operator, float]:
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


def _holds(number: float, sign: str, limit: float) -> bool:
    return {">": number > limit, "<": number < limit, ">=": number >= limit, "<=": number <= limit}[sign]


def _people(automation: Automation, sign: str, limit: float) -> str:
    """Return the state of the household for a limit of the number of people at home."""
    if not automation.entities.knows_people:
        raise NotCarriedError("zone.home: nobody is known; write the persons in the table [people]")
    if (sign, limit) in {(">", 0.0), (">=", 1.0)}:
        return "somebody is home"
    if (sign, limit) in {("<", 1.0), ("<=", 0.0)}:
        return "nobody is home"
    raise NotCarriedError("zone.home: homebot does not count people; ask for 0 or for any")


def _is_now(node: nodes.Node) -> bool:
    return isinstance(node, nodes.Call) and node.node == nodes.Name("now", "load") and not node.args


def _unit_of_now(node: nodes.Node) -> str:
    """Return the unit of the time that *node* is, such as ``hour``; empty for another expression."""
    match node:
        case nodes.Getattr(node=inner, attr="hour" | "month" as unit) if _is_now(inner):
            return unit
        case nodes.Call(node=nodes.Getattr(node=inner, attr="weekday" | "isoweekday" as unit), args=[]) if _is_now(
            inner
        ):
            return unit
        case nodes.Call(
            node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value="%H:%M" | "%H:%M:%S" | "%T")]
        ) if _is_now(inner):
            return "clock"
        case nodes.Filter(
            name="int", node=nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value="%H")])
        ) if _is_now(inner):
            return "hour"
    return ""


def _of_time(unit: str, sign: str, value: object) -> list[Condition]:
    """Return the conditions that a time of now is so."""
    match unit, value:
        case "clock", str(text) if _CLOCK.fullmatch(text) and sign in {">", ">=", "<", "<="}:
            side = "after" if sign[0] == ">" else "before"
            span = read_span(f"{side} {text}")
            return [(f"{side} {text}",)] if span is not None and span.begin != span.end else []
        case "hour", int(hour):
            held = [number for number in range(24) if _holds_whole(number, sign, hour)]
            if len(held) in {0, 24}:
                return [] if held else [NEVER]
            begin, end = held[0], held[-1] + 1
            texts = ([f"after {begin}:00"] if begin else []) + ([f"before {end}:00"] if end < 24 else [])
            return [(f"between {begin}:00 and {end}:00",)] if len(texts) > 1 else [(text,) for text in texts]
        case (("weekday" | "isoweekday"), int(day)):
            first = int(unit == "isoweekday")
            days = [name for number, name in enumerate(_DAYS, first) if _holds_whole(number, sign, day)]
            return [(f"on {','.join(days)}",)] if 0 < len(days) < len(_DAYS) else [] if days else [NEVER]
        case "month", int(month):
            months = [name for number, name in enumerate(_MONTHS, 1) if _holds_whole(number, sign, month)]
            if not 0 < len(months) < len(_MONTHS):
                return [] if months else [NEVER]
            return [(f"in {months[0]}" + (f"-{months[-1]}" if len(months) > 1 else ""),)]
    raise NotCarriedError(f"template: now() against {value!r}")


def _holds_whole(number: int, sign: str, value: int) -> bool:
    return number == value if sign == "==" else _holds(number, sign, value)


def _values_of(node: nodes.Expr) -> list[object]:
    if isinstance(node, nodes.List | nodes.Tuple):
        return [value for item in node.items for value in _values_of(item)]
    if isinstance(node, nodes.Neg):
        return [-_constant(node.node)]
    if isinstance(node, nodes.Const):
        return [node.value]
    raise _refused(_text_of(node), "it compares two values; routines compare a value with a number or a text")


def _constant(node: nodes.Expr) -> float:
    match node:
        case nodes.Const(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case nodes.Neg(node=inner):
            return -_constant(inner)
    raise _refused(_text_of(node))


def _without_unit(text: str, unit: str) -> str:
    """Return *text* after a value without its unit, which homebot writes itself."""
    names = {"%": ("%", "percent"), "°C": ("°C", "°", "C", "degrees", "ºC"), "W": ("W", "watts", "Watt")}.get(
        unit, (unit,)
    )
    for name in filter(None, names):
        rest = text.lstrip(" ")
        if rest.startswith(name) and not rest[len(name) : len(name) + 1].isalnum():
            return rest[len(name) :]
    return text


def _text_of(node: nodes.Node) -> str:
    """Return *node* as people write it."""
    match node:
        case nodes.Name(name=name):
            return str(name)
        case nodes.Const(value=value):
            return repr(value)
        case nodes.Getattr(node=inner, attr=attribute):
            return f"{_text_of(inner)}.{attribute}"
        case nodes.Call(node=inner, args=args):
            return f"{_text_of(inner)}({', '.join(map(_text_of, args))})"
        case nodes.Filter(node=inner, name=name, args=args) if inner is not None:
            given = f"({', '.join(map(_text_of, args))})" if args else ""
            return f"{_text_of(inner)} | {name}{given}"
        case nodes.Sub(left=left, right=right):
            return f"{_text_of(left)} - {_text_of(right)}"
        case nodes.Compare(expr=left, ops=ops):
            return f"{_text_of(left)} {' '.join(f'{one.op} {_text_of(one.expr)}' for one in ops)}"
        case nodes.BinExpr(left=left, right=right):
            return f"{_text_of(left)} {node.operator} {_text_of(right)}"
    return type(node).__name__.lower()


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


def _texts_in(node: Located, path: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Yield the templates in *node*, with their places."""
    if isinstance(node.value, str) and "{" in node.value and not node.tag:
        yield path, node.value
    items = enumerate(node.value) if isinstance(node.value, list) else ()
    for key, value in node.value.items() if isinstance(node.value, dict) else items:
        yield from _texts_in(value, (*path, key))


def _with_text(node: Located, path: tuple[str | int, ...], text: str) -> Located:
    """Return *node* with another text in the place *path*."""
    if not path:
        return node._replace(value=text)
    key, *rest = path
    if isinstance(node.value, dict):
        return node._replace(value={**node.value, key: _with_text(node.value[key], tuple(rest), text)})
    assert isinstance(node.value, list)  # noqa: S101 - for the type checker: the path is that of the text
    values = list(node.value)
    values[int(key)] = _with_text(values[int(key)], tuple(rest), text)
    return node._replace(value=values)


def round_limit(node: Located, *, is_until: bool) -> tuple[int, Located] | None:
    """Return the greatest number of rounds in the condition of a loop, and the other condition; None for no number.

    That is ``… or repeat.index >= 5`` of a loop *is_until*, and ``… and repeat.index <= 5`` of another.
    """
    inner = node.value[0] if isinstance(node.value, list) and len(node.value) == 1 else node
    if not isinstance(inner.value, str) or "repeat.index" not in inner.value:
        return None
    joined = expression_of(inner.value)
    if not isinstance(joined, nodes.Or if is_until else nodes.And):
        return None
    for count, other in ((joined.right, joined.left), (joined.left, joined.right)):
        match count:
            case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=nodes.Const(value=int(most)))]) if _path_of(
                left
            ) == ("repeat", "index"):
                if (is_until, sign) in {(True, "gteq"), (True, "eq"), (False, "lteq")}:
                    return most, Located(_Expression(inner.value, other), inner.line)
                if (is_until, sign) in {(True, "gt"), (False, "lt")}:
                    return most + (1 if is_until else -1), Located(_Expression(inner.value, other), inner.line)
    return None


class _Expression(str):
    """A part of a template, with its tree."""

    tree: nodes.Expr
    __slots__ = ("tree",)

    def __new__(cls, text: str, tree: nodes.Expr) -> Self:
        """Return the part *tree* of the template *text*."""
        self = super().__new__(cls, text)
        self.tree = tree
        return self
