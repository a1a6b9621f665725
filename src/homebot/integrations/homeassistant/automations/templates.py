"""Templates of automations as conditions and messages of routines, as far as these say the same. Pure.

Source: Home Assistant core 2026.11, ``helpers/template``; of a number ``float(0)`` the 0 counts while it is unknown.
"""

import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import date, timedelta
from itertools import pairwise
from typing import Any, Final, NamedTuple, Self, TypeAlias, TypeVar, cast

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import Automation, StartTrigger, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import (
    UNKNOWN,
    attribute_of,
    elevation_text,
    known_texts,
    limits_text,
    number_of,
    state_texts,
    value_name,
    values_text,
)
from homebot.integrations.homeassistant.automations.variables import BoundTemplate, is_constant
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
_TIME_FORM: Final = re.compile(r"%-?[HI]:%M(:%S)?( ?%p)?|%[TRX]")
"""A time of day, however it is written."""

_MAX_SHOWN: Final = 60
_LIMITS: Final = (("trigger", "above"), ("trigger", "below"))
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

_FORMS: Final = frozenset({"float", "int", "round", "title", "lower", "upper", "string", "default", "d"})
"""Filters that only shape a value of a message."""

_SECONDS: Final = {"hours": 3600.0, "minutes": 60.0, "seconds": 1.0}
_CLOCK_OF_ONE: Final = re.compile(r"(?:00?:)*(\{\{[^{}]*\}\})(?P<after>(?::00)*)")
"""A length of time such as ``00:{{ … }}:00``."""
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
        return self._read(self._of_its_state(self._inlined(expression)))

    def passed(self, text: str, entity: str, side: str, limit: float) -> str:
        """Return the trigger that the difference in *text*, with the state of *entity*, is above or below *limit*."""

        def put(node: nodes.Node) -> nodes.Node:
            if _path_of(node) == ("state", "state"):
                return nodes.Call(nodes.Name("states", "load"), [nodes.Const(entity)], [], None, None)
            return _rebuilt(node, put)

        difference = cast("nodes.Expr", put(self._inlined(expression_of(text))))
        return self._of_two_values(difference, "gt" if side == "above" else "lt", nodes.Const(limit))

    def _of_its_state(self, node: nodes.Expr) -> nodes.Expr:
        """Return *node* with the state of the only entity that starts the automation."""
        triggers = self._automation.triggers
        entities = {trigger.entity for trigger in triggers}
        if len(entities) != 1 or "" in entities or any(trigger.state for trigger in triggers):
            return node
        return cast("nodes.Expr", _of_trigger(node, triggers[0], is_state=not self._automation.has_waited))

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
            if isinstance(inlined := getattr(node, key), nodes.Node) and inlined is not value:
                self._inlined(inlined)
        return node

    def message(self, text: str) -> str:
        """Return the text of a message with the values of its template in braces."""
        if "{" not in text:
            return text.strip()
        pieces: list[str] = []
        unit = ""
        for node in self._parts_of(text):
            if isinstance(node, nodes.If):
                raise _refused(text, "it has statements")
            if isinstance(node, nodes.TemplateData | nodes.Const):
                piece = str(node.data if isinstance(node, nodes.TemplateData) else node.value)
                if "{" in piece or "}" in piece:
                    raise _refused(text, "braces in a message mean a value")
                pieces.append(_without_unit(piece, unit))
                unit = ""
            else:
                value, unit = self._value(node)
                pieces.append(value)
        return "".join(pieces).strip()

    def ways(self, call: Located) -> list[tuple[list[Condition], Located]]:
        """Return the calls that *call* becomes by the first choice in its templates, each with its conditions.

        The last call has none, or that of the last trigger; empty without a choice.
        """
        for path, text in _texts_in(call):
            try:
                parts = self._parts_of(text)
            except NotCarriedError:
                continue
            is_message = path[-1] in {"message", "title"}
            for place, node in enumerate(parts):
                if ways := self._ways_of(node, text, is_message=is_message):
                    return [
                        (held, _with_text(call, path, _text_of_parts(text, parts[:place] + way + parts[place + 1 :])))
                        for held, way in ways
                    ]
        return []

    def _parts_of(self, text: str) -> list[nodes.Node]:
        """Return the texts, values and choices of the template *text*, with those of variables."""
        if isinstance(text, _LeftTemplate):
            return text.parts
        parts: list[nodes.Node] = []
        for part in _parts_of(_without_sets(_tree_of(text).body), text):
            if isinstance(part, nodes.Name) and part.name in self._automation.expressions:
                parts += map(self._inlined, self._parts_of(self._automation.expressions[part.name]))
            else:
                parts += _pieces(part) if isinstance(part, nodes.Concat) else [self._inlined(part)]
        return parts

    def _ways_of(
        self, node: nodes.Node, text: str, *, is_message: bool
    ) -> list[tuple[list[Condition], list[nodes.Node]]]:
        """Return the choices of *node*, each with its conditions; empty for none."""
        match node:
            case nodes.CondExpr():
                no: list[nodes.Node] = [] if node.expr2 is None else _pieces(node.expr2)
                return [(self._read(self._of_its_state(node.test)), _pieces(node.expr1)), ([], no)]
            case nodes.Filter(name="int" | "float" | "round", node=nodes.CondExpr() as choice) if (
                choice.expr2 is not None
            ):
                yes, no_value = (_filtered(node, value) for value in (choice.expr1, choice.expr2))
                return [(self._read(self._of_its_state(choice.test)), [yes]), ([], [no_value])]
            case nodes.If():
                rest: Sequence[nodes.Node] = node.else_
                for other in node.elif_[:1]:
                    rest = [nodes.If(other.test, other.body, node.elif_[1:], node.else_)]
                held = self._read(self._of_its_state(cast("nodes.Expr", node.test)))
                return [(held, _parts_of(node.body, text)), ([], _parts_of(rest, text))]
            case nodes.TemplateData() | nodes.Const():
                return []
        paths = {
            path for inner in (node, *node.find_all(nodes.Getattr)) if (path := _path_of(inner))[:1] == ("trigger",)
        }
        is_state = is_message and ("trigger", "to_state", "state") in paths
        triggers = self._automation.triggers
        paths = {path for path in paths if any(trigger.value(path) is not None for trigger in triggers)}
        paths |= {("trigger", "entity_id")} if is_state and all(trigger.entity for trigger in triggers) else set()
        if not paths or (is_message and self._is_value(node)):
            return []
        groups: dict[tuple[str | None, ...], list[StartTrigger]] = {}
        for trigger in triggers:
            groups.setdefault(tuple(trigger.value(path) for path in sorted(paths)), []).append(trigger)
        if any(None in key for key in groups):
            raise _refused(text, "not each trigger has this value; write it as `choose`")
        return [
            (self.started_by(group), [_folded(_of_trigger(node, group[0], is_state=is_state))])
            for group in groups.values()
        ]

    def _is_value(self, node: nodes.Node) -> bool:
        noted = len(self._automation.notes)
        try:
            self._value(node)
        except NotCarriedError:
            return False
        finally:
            del self._automation.notes[noted:]
        return True

    def _value(self, node: nodes.Node) -> tuple[str, str]:
        """Return a value for a message, and its unit, which homebot writes itself."""
        while isinstance(node, nodes.Filter) and node.name in _FORMS:
            assert node.node is not None  # noqa: S101 - only the filter of a block has none
            node = node.node
        if (named := _NAMED.get(path := _path_of(node), "")) != "":
            return named, ""
        match path:
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
            case nodes.Call(node=nodes.Name(name="state_attr"), args=[inner, nodes.Const(value="friendly_name")]) if (
                _path_of(inner) == ("trigger", "entity_id")
            ):
                return "{name}", ""
            case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]) if (
                _TIME_FORM.fullmatch(form) and _is_now(inner)
            ):
                return "{time}", ""
            case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]) if (
                _TIME_FORM.fullmatch(form)
                and _path_of(inner) in {("trigger", "to_state", last) for last in ("last_changed", "last_updated")}
                and not self._automation.has_waited
            ):
                self._automation.notes.append("the time in a message is that of the home's zone")
                return "{time}", ""
            case nodes.Or(left=left, right=right) if (
                _path_of(right)[:1] == ("trigger",) and self._value(left)[0] == "{room}"
            ):
                starting = [self._automation.entities.find(trigger.entity) for trigger in self._automation.triggers]
                if all(entity.device.area for entity in starting):
                    return "{room}", ""
            case nodes.Getattr(attr="state") if entity := _states_path(node.node):
                return self._state_value(entity, "")
        raise _refused(_text_of(node), "a message has states, {name}, {room}, {routine} and {time}")

    def number(self, text: str) -> tuple[str, float]:
        """Return the number of an entity for a step, and the factor with which the template *text* takes it."""
        node, factor = expression_of(text), 1.0
        while True:
            match node:
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
        number = _number_of(node)
        entity, capability, own = number_of(self._automation.entities, number.entity, number.attribute)
        if number.offset or entity.unit or not capability:
            raise _refused(text, "a step takes a number of the house as it is")
        self._automation.notes.append(
            "a number of the house is taken as it is, and the step left out while it is unknown"
        )
        return f"{{{capability} of name={text_value(entity.name)}}}", factor / own

    def length(self, node: Located) -> str:
        """Return a length of time that a number of the house tells, such as ``{number of pause}m``; else empty."""
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
        value, factor = self.number(text)
        letter = next((name[0] for name, length in _SECONDS.items() if math.isclose(length, factor * seconds)), "")
        if not letter:
            raise _refused(text, "a length of time is a number of seconds, minutes or hours of the house")
        return f"{value}{letter}"

    def _state_value(self, entity_id: str, attribute: str) -> tuple[str, str]:
        name, capability = value_name(self._automation.entities, entity_id, attribute)
        self._automation.notes.append(f"{entity_id} is written in the words of homebot, with its unit")
        return f"{{{capability} of {name}}}", CAPABILITIES.get(capability, OWN).unit

    def _read(self, node: nodes.Expr) -> list[Condition]:
        for read in (days_of, self._known, self._tested, _any_light):
            if (special := read(node)) is not None:
                return special
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
            case nodes.Getattr() if _path_of(node) in {("wait", "completed"), ("wait", "trigger")}:
                return [("not wait timed out",)]
            case nodes.Filter(name="bool", node=inner) if inner is not None:
                return self._read(inner)
        raise _refused(_text_of(node))

    def _tested(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the conditions of ``is none`` and ``is defined``; None for another expression."""
        match node:
            case nodes.Test(name="defined" | "none" as test, node=inner) if _path_of(inner) in _LIMITS:
                path = _path_of(inner)  # a limit that a trigger lacks is none, and one of another kind is undefined
                return self.started_by(
                    [
                        trigger
                        for trigger in self._automation.triggers
                        if any(trigger.value(limit) is not None for limit in _LIMITS)
                        and (test == "defined" or trigger.value(path) is None)
                    ]
                )
            case nodes.Test(name="none", node=inner) if _path_of(inner) == ("wait", "trigger"):
                return [("wait timed out",)]
            case nodes.Test(name="none", node=inner) if self._is_last_run(inner):
                return [NEVER]  # one that never ran is over any time ago
        return None

    def _known(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the conditions of a guard against unknown states; None for another expression.

        A routine starts by no unknown state.
        """
        match node:
            case nodes.Compare(expr=left, ops=[nodes.Operand(op="notin" | "ne", expr=right)]):
                if isinstance(right, nodes.Const | nodes.List | nodes.Tuple):
                    states = {str(value) for value in _values_of(right)}
                    if states <= UNKNOWN and _path_of(left) == ("trigger", "to_state", "state"):
                        return self._by_a_state()
                    if states <= UNKNOWN and _path_of(left) == ("trigger", "from_state", "state"):
                        self._automation.notes.append("a state that differs from that before it was unknown starts it")
                        return self._by_a_state()
                    if entity := _state_of(left) if states <= UNKNOWN and states - {""} else "":
                        return [known_texts(self._automation.entities, entity)]
                paths = {_path_of(left), _path_of(right)}
                if paths == {("trigger", "to_state", "state"), ("trigger", "from_state", "state")}:
                    return self._by_a_state()
            case nodes.Compare(expr=left, ops=[nodes.Operand(op="in", expr=right)]) if _path_of(left) == (
                "trigger",
                "from_state",
                "state",
            ) and {*_values_of(right)} == {"home", "not_home"}:
                people = [trigger for trigger in self._automation.triggers if trigger.entity]
                if all(trigger.entity.startswith("group.") for trigger in people):
                    return self._by_a_state()
            case nodes.Call(node=nodes.Name(name="has_value"), args=[nodes.Const(value=str(entity))]):
                return [known_texts(self._automation.entities, entity)]
            case nodes.Call(node=nodes.Name(name="is_number"), args=[inner]) if entity := _state_of(inner):
                return [known_texts(self._automation.entities, entity)]
        return None

    def _by_a_state(self) -> list[Condition]:
        """Return the condition that a state started it: any other trigger has none, and ends with an error."""
        return self.started_by([trigger for trigger in self._automation.triggers if trigger.entity])

    def _state(self, entity: str, state: str) -> Condition:
        (text,) = state_texts(self._automation.entities, entity, [state])
        return (bracketed(text),)

    def _compared(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition]:
        if sign in {"in", "notin"}:
            states = self._any_of([self._equal(left, value) for value in _values_of(right)])
            return states if sign == "in" else self._denied(states)
        if isinstance(left, nodes.Const) and not isinstance(right, nodes.Const):
            left, right, sign = right, left, _SWAPPED[sign]
        if isinstance(right, nodes.CondExpr) and right.expr2 is not None:
            held = self._read(right.test)
            ways = (
                [*held, *self._compared(left, sign, right.expr1)],
                [*self._denied(held), *self._compared(left, sign, right.expr2)],
            )
            return self._any_of(ways)
        if _is_now(left) and (clock := _clock_of_today(right)) and sign in _SIGNS:
            return _of_time("clock", _SIGNS[sign], clock)
        if not isinstance(right, nodes.Const | nodes.Neg) or (
            _is_of_two(left) and not self._since_last_run(left) and not _last_changed(left)
        ):
            return [(self._of_two_values(left, sign, right),)]
        (value,) = _values_of(right)
        if sign == "eq":
            return self._equal(left, value)
        if sign == "ne":
            return self._denied(self._equal(left, value))
        return self._limited(left, _SIGNS[sign], value)

    def _of_two_values(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> str:
        """Return the condition that one value is above or below another."""
        if sign not in _SIGNS:
            raise _refused(_text_of(left), "two values are compared by < and >")
        numbers = [*_summands(left, 1.0), *_summands(right, -1.0)]
        offset = sum(number.offset for number in numbers)
        numbers = sorted((number for number in numbers if number.entity), key=lambda number: -number.factor)
        if [number.factor for number in numbers] != [1.0, -1.0]:
            raise _refused(_text_of(left), "it calculates with two values; only their difference is compared")
        if any(number.default is not None for number in numbers):
            self._automation.notes.append("a comparison does not hold while one of its values is unknown")
        if any(number.is_whole for number in numbers):
            self._automation.notes.append("two values are compared as they are, without cutting their fractions off")
        first, second = numbers
        equal = _EQUAL if sign in {"gteq", "lteq"} else 0.0
        return values_text(
            self._automation.entities,
            (first.entity, first.attribute),
            _SIGNS[sign][0],
            (second.entity, second.attribute),
            -offset + (equal if sign == "lteq" else -equal),
        )

    def _equal(self, left: nodes.Expr, value: object) -> list[Condition]:
        path = _path_of(left)
        match path:
            case ("trigger", "id") | ("trigger", "payload") | ("trigger", "event", "data", _):
                return self.started_by(
                    [trigger for trigger in self._automation.triggers if trigger.value(path) == str(value)]
                )
            case ("trigger", "entity_id") | ("trigger", "to_state", "entity_id"):
                return self._started_where(lambda trigger: trigger.value(path) == value)
            case ("trigger", "to_state", "state"):
                if any(trigger.entity and not trigger.state for trigger in self._automation.triggers):
                    raise _refused(_text_of(left), "not each trigger names its state; ask for the state of the entity")
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
        if (changed := _last_changed(left)) and sign[0] == ">" and type(value) in (int, float):
            texts = known_texts(self._automation.entities, changed)
            if len(texts) > 1:
                return [tuple(f"{text[:-1]} for {value}s)" for text in texts)]
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


def keeps_state(text: str) -> bool:
    """Return whether the template *text* is only whether an entity is in a state."""
    match expression_of(text):
        case nodes.Call(node=nodes.Name(name="is_state"), args=[nodes.Const(), nodes.Const()]):
            return True
    return False


_ANY_OR_NONE: Final = {"gt": "", "ne": "", "eq": "not "}


def _any_light(node: nodes.Expr) -> list[Condition] | None:
    """Return the condition that some light is on, or none; None for another expression."""
    match node:
        case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=nodes.Const(value=0))]) if (
            sign in _ANY_OR_NONE and _is_count_of_lights(left)
        ):
            return [(f"{_ANY_OR_NONE[sign]}(light on)",)]
    return None


def _is_count_of_lights(node: nodes.Node | None) -> bool:
    """Return whether *node* is the number of lights that are on."""
    names = []
    while isinstance(node, nodes.Filter):
        names.append((node.name, *(value.value for value in node.args if isinstance(value, nodes.Const))))
        node = node.node
    counts, chosen = (
        {("count",), ("length",)},
        {("selectattr", "state", sign, "on") for sign in ("eq", "==", "equalto")},
    )
    is_counted = len(names) > 1 and names[0] in counts and names[-1] in chosen
    return is_counted and {*names[1:-1]} <= {("list",)} and _path_of(node) == ("states", "light")


def _last_changed(node: nodes.Node | None) -> str:
    """Return the entity if *node* is the time in seconds since its last change; else empty."""
    while isinstance(node, nodes.Filter) and node.name in {"int", "float"}:
        node = node.node
    match node:
        case nodes.Call(node=nodes.Getattr(node=nodes.Sub(left=now, right=last), attr="total_seconds"), args=[]):
            pass
        case nodes.Sub(
            left=nodes.Call(node=nodes.Name(name="as_timestamp"), args=[now]),
            right=nodes.Call(node=nodes.Name(name="as_timestamp"), args=[last, *_]),
        ):
            pass
        case _:
            return ""
    if not _is_now(now) or not isinstance(last, nodes.Getattr) or last.attr != "last_changed":
        return ""
    return _states_path(last.node)


def expression_of(text: str) -> nodes.Expr:
    """Return the only expression of the template *text*."""
    if isinstance(text, _Expression):
        return text.tree
    parts = text.parts if isinstance(text, _LeftTemplate) else _parts_of(_output_of(text), text)
    parts = [node for node in parts if not (isinstance(node, nodes.TemplateData) and not node.data.strip())]
    if len(parts) == 1 and not isinstance(parts[0], nodes.TemplateData):
        return cast("nodes.Expr", parts[0])
    plain = text.strip().casefold()
    if plain in {"true", "false"}:
        return nodes.Const(plain == "true")
    raise _refused(text)


def bracketed(text: str) -> str:
    """Return a state in brackets if it is a query, which others may be joined to."""
    return f"({text})" if "name=" in text and " of name=" not in text else text


def _tree_of(text: str) -> nodes.Template:
    try:
        tree = tree_of(text.strip())
    except TemplateError as exc:
        raise _refused(text, f"it {exc.problem}") from exc
    return cast("nodes.Template", _with_values(tree, text.values)) if isinstance(text, BoundTemplate) else tree


def _with_values(node: nodes.Node, values: Mapping[str, object]) -> nodes.Node:
    """Return *node* with *values* in place of the variables of these names, and their fields and elements."""
    node = _rebuilt(node, lambda inner: _with_values(inner, values))
    match node:
        case nodes.Name(name=name, ctx="load") if name in values:
            return nodes.Const(values[name])
        case nodes.Getattr(node=nodes.Const(value=dict(fields)), attr=key) if key in fields:
            return nodes.Const(fields[key])
        case nodes.Filter():
            return _plain_filter(node)
        case nodes.Getitem(node=nodes.Const(value=dict(fields)), arg=nodes.Const(value=key)) if key in fields:
            return nodes.Const(fields[key])
    return node


def _parts_of(body: Sequence[nodes.Node], text: str) -> list[nodes.Node]:
    """Return the nodes of *body*, of which statements are choices alone."""
    parts: list[nodes.Node] = []
    for node in body:
        if not isinstance(node, nodes.Output | nodes.If):
            raise _refused(text, "it has statements")
        parts += [node] if isinstance(node, nodes.If) else node.nodes
    return parts


def _output_of(text: str) -> list[nodes.Output]:
    body = _without_sets(_tree_of(text).body)
    outputs = [node for node in body if isinstance(node, nodes.Output)]
    if len(outputs) == len(body):
        return outputs
    body = [node for node in body if not _is_space(node)]
    match body:
        case [nodes.If(test=test, body=yes, elif_=[], else_=no)]:
            words = tuple(_words_of(branch).casefold() for branch in (yes, no))
            if words in {("true", "false"), ("true", "")}:
                return [nodes.Output([test])]
            if words == ("false", "true"):
                return [nodes.Output([nodes.Not(test)])]
        case [nodes.If() as choice] if choice.else_:
            return [nodes.Output([_as_expression(choice, text)])]
    raise _refused(text, "it has statements")


def _is_space(node: nodes.Node) -> bool:
    return isinstance(node, nodes.Output) and all(
        isinstance(part, nodes.TemplateData) and not part.data.strip() for part in node.nodes
    )


def _as_expression(choice: nodes.If, text: str) -> nodes.CondExpr:
    """Return a choice between single values, as people write them with statements, as an expression."""
    rest: Sequence[nodes.Node] = choice.else_
    for other in choice.elif_[:1]:
        rest = [nodes.If(other.test, other.body, choice.elif_[1:], choice.else_)]
    values: list[nodes.Expr] = []
    for body in (choice.body, rest):
        match [node for node in body if not _is_space(node)]:
            case [nodes.If() as inner]:
                values.append(_as_expression(inner, text))
            case [nodes.Output(nodes=parts)]:
                parts = [part for part in parts if not (isinstance(part, nodes.TemplateData) and not part.data.strip())]
                if len(parts) != 1:
                    raise _refused(text, "it has statements")
                value = parts[0]
                values.append(nodes.Const(value.data.strip()) if isinstance(value, nodes.TemplateData) else value)
            case _:
                raise _refused(text, "it has statements")
    return nodes.CondExpr(cast("nodes.Expr", choice.test), values[0], values[1])


def _words_of(body: Sequence[nodes.Node]) -> str:
    """Return the text of a branch, also if it is written as ``{{ true }}``."""
    parts = [part for node in body if isinstance(node, nodes.Output) for part in node.nodes]
    return "".join(str(getattr(part, "data", getattr(part, "value", "?"))) for part in parts).strip()


class _LeftTemplate(str):
    """A template after a choice in it, with its remaining parts."""

    parts: list[nodes.Node]
    __slots__ = ("parts",)


def _text_of_parts(text: str, parts: list[nodes.Node]) -> str:
    """Return the remaining *parts* of the template *text*: plain text if possible."""
    texts = [
        str(part.data if isinstance(part, nodes.TemplateData) else part.value)
        for part in parts
        if isinstance(part, nodes.TemplateData | nodes.Const)
    ]
    if len(texts) == len(parts):
        return "".join(texts).strip()
    left = _LeftTemplate(text)
    left.parts = parts
    return left


def _of_trigger(node: nodes.Node, trigger: StartTrigger, *, is_state: bool) -> nodes.Node:
    """Return *node* with the values of *trigger*; its state, if that counts, is asked anew."""
    path = _path_of(node)
    if is_state and path == ("trigger", "to_state", "state") and trigger.entity:
        return nodes.Call(nodes.Name("states", "load"), [nodes.Const(trigger.entity)], [], None, None)
    if (value := trigger.value(path)) is not None:
        return nodes.Const(value)

    return _rebuilt(node, lambda inner: _of_trigger(inner, trigger, is_state=is_state))


def _rebuilt(node: nodes.Node, change: Callable[[nodes.Node], nodes.Node]) -> nodes.Node:
    """Return *node* with its changed parts."""

    def of(field: object) -> object:
        if isinstance(field, nodes.Node):
            return change(field)
        return [*map(of, field)] if isinstance(field, list) else field

    return type(node)(*(of(field) for _, field in node.iter_fields()), environment=node.environment)


def _without_sets(body: Sequence[nodes.Node]) -> list[nodes.Node]:
    """Return *body* with the expressions of its ``{% set … %}`` where they are used."""
    known: dict[str, nodes.Node] = {}

    def put(node: nodes.Node) -> nodes.Node:
        if isinstance(node, nodes.Name) and node.name in known:
            return known[node.name]
        return _rebuilt(node, put)

    rest: list[nodes.Node] = []
    for node in body:
        if isinstance(node, nodes.Assign) and isinstance(node.target, nodes.Name):
            known[node.target.name] = put(node.node)
        else:
            rest.append(put(node) if known else node)
    return rest


def _pieces(node: nodes.Expr) -> list[nodes.Node]:
    """Return the values that *node* joins by ``~``."""
    if isinstance(node, nodes.Concat):
        return [piece for inner in node.nodes for piece in _pieces(inner)]
    return [_folded(node)]


def _filtered(chosen: nodes.Filter, value: nodes.Expr) -> nodes.Node:
    """Return *value* with the filter of the choice that it is in."""
    if isinstance(value, nodes.Const):
        try:
            number = float(str(value.value))
        except ValueError:
            raise _refused(_text_of(chosen), "it is no number") from None
        return nodes.Const(int(number) if chosen.name == "int" else number)
    return nodes.Filter(value, chosen.name, chosen.args, chosen.kwargs, chosen.dyn_args, chosen.dyn_kwargs)


def _folded(node: nodes.Node) -> nodes.Node:
    """Return the value of *node* if it is a constant."""
    try:
        return nodes.Const(node.as_const()) if isinstance(node, nodes.Expr) else node
    except (nodes.Impossible, RuntimeError):
        return node


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


_EQUAL: Final = 0.0001
"""The difference up to which two values count as one."""


def _is_of_two(node: nodes.Expr) -> bool:
    """Return whether *node* is a sum or difference of two values."""
    while isinstance(node, nodes.Filter) and node.name in {"float", "round", "int"} and node.node is not None:
        node = node.node
    if not isinstance(node, nodes.Add | nodes.Sub):
        return False
    return not any(isinstance(side, nodes.Const | nodes.Neg) for side in (node.left, node.right))


def _summands(node: nodes.Expr, sign: float) -> list[_Number]:
    """Return the numbers whose sum *node* is, times *sign*; one without an entity is only an offset."""
    match node:
        case nodes.Const() | nodes.Neg(node=nodes.Const()):
            return [_Number("", offset=sign * _constant(node))]
        case nodes.Neg(node=inner):
            return _summands(inner, -sign)
        case nodes.Add(left=left, right=right):
            return [*_summands(left, sign), *_summands(right, sign)]
        case nodes.Sub(left=left, right=right):
            return [*_summands(left, sign), *_summands(right, -sign)]
        case nodes.Filter(name="float" | "round", node=nodes.Add() | nodes.Sub() as inner):
            return _summands(inner, sign)
    number = _number_of(node)
    return [number._replace(factor=sign * number.factor, offset=sign * number.offset)]


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
    most = float(automation.entities.people)
    if (sign, limit) in {(">", most - 1), (">=", most)}:
        return "everybody is home"
    if (sign, limit) in {("<", most), ("<=", most - 1)}:
        return "not everybody is home"
    raise NotCarriedError("zone.home: homebot does not count people; ask for none, any or all")


def _is_now(node: nodes.Node) -> bool:
    return isinstance(node, nodes.Call) and node.node == nodes.Name("now", "load") and not node.args


def _clock_of_today(node: nodes.Node) -> str:
    """Return the time of day of ``today_at('07:00')``; empty for another expression."""
    match node:
        case nodes.Call(node=nodes.Name(name="today_at"), args=[nodes.Const(value=str(clock))]):
            return clock
    return ""


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
    has_day = any(inner.attr == "day" and _is_now(inner.node) for inner in node.find_all(nodes.Getattr))
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
    starts = [number for number in range(366) if held[number] and not held[number - 1]]
    texts = []
    for start in starts:
        end = next(number for number in range(start + 1, start + 367) if not held[number % 366]) - 1
        ends = dict.fromkeys(
            f"{days[place % 366].day} {_MONTHS[days[place % 366].month - 1]}" for place in (start, end)
        )
        texts.append("-".join(ends))
    return [(f"on {','.join(texts)}",)]


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
        case nodes.Getattr(node=inner, attr="month" | "day" as unit) if _is_now(inner):
            return getattr(day, unit)
        case nodes.Call(node=nodes.Getattr(node=inner, attr="strftime"), args=[nodes.Const(value=str(form))]) if (
            _is_now(inner) and _OF_DAY.fullmatch(form)
        ):
            return day.strftime(form)
        case nodes.Filter(name="int", node=inner, args=[]) if inner is not None:
            return int(str(_on_day(inner, day)))
    raise _refused(_text_of(node))


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


def _plain_filter(node: nodes.Filter) -> nodes.Node:
    """Return the number of a constant, of which *node* is the filter."""
    if not isinstance(node.node, nodes.Const) or node.name not in {"int", "float", "string"}:
        return node
    try:
        number = float(str(node.node.value))
    except ValueError:
        return node
    return nodes.Const(int(number) if node.name == "int" else number if node.name == "float" else str(node.node.value))


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
    """Return the greatest number of rounds in the condition of a loop, and the other conditions; None for no number.

    That is ``… or repeat.index >= 5`` of a loop *is_until*, and ``… and repeat.index <= 5`` of another.
    """
    joint = "or" if is_until else "and"
    joined = _joined_by(joint, node)
    for number, part in enumerate(joined):
        if most := _most_rounds(part, is_until=is_until):
            others = joined[:number] + joined[number + 1 :]
            return most, Located({"condition": Located(joint, node.line), "conditions": Located(others, 0)}, node.line)
    return None


def _joined_by(joint: str, node: Located) -> list[Located]:
    """Return the conditions that *node* joins by *joint*; *node* itself if it joins none so."""
    value = node.value
    if isinstance(value, list) and (joint == "and" or len(value) == 1):
        return [part for inner in value for part in _joined_by(joint, inner)]
    if isinstance(value, dict):
        kind = value.get("condition")
        if kind is not None and kind.value == joint and "conditions" in value:
            listed = value["conditions"]
            inner_nodes = listed.value if isinstance(listed.value, list) else [listed]
            return [part for inner in inner_nodes for part in _joined_by(joint, inner)]
        if kind is not None and kind.value == "template" and "value_template" in value:
            return _joined_by(joint, value["value_template"])
    if isinstance(value, str) and "repeat.index" in value:
        tree = expression_of(value)
        if isinstance(tree, nodes.Or if joint == "or" else nodes.And):
            sides = (Located(_Expression(value, side), node.line) for side in (tree.left, tree.right))
            return [part for side in sides for part in _joined_by(joint, side)]
    return [node]


def _most_rounds(node: Located, *, is_until: bool) -> int:
    """Return the number of rounds that the condition *node* allows; 0 for another condition."""
    if not isinstance(node.value, str) or "repeat.index" not in node.value:
        return 0
    match expression_of(node.value):
        case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=nodes.Const(value=int(most)))]) if _path_of(
            left
        ) == ("repeat", "index"):
            if (is_until, sign) in {(True, "gteq"), (True, "eq"), (False, "lteq")}:
                return most
            if (is_until, sign) in {(True, "gt"), (False, "lt")}:
                return most + (1 if is_until else -1)
    return 0


class _Expression(str):
    """A part of a template, with its tree."""

    tree: nodes.Expr
    __slots__ = ("tree",)

    def __new__(cls, text: str, tree: nodes.Expr) -> Self:
        """Return the part *tree* of the template *text*."""
        self = super().__new__(cls, text)
        self.tree = tree
        return self
