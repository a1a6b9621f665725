"""Templates of automations as conditions and messages of routines, as far as these say the same. Pure.

Source: Home Assistant core 2026.11, ``helpers/template``; of a number ``float(0)`` the 0 counts while it is unknown.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from math import prod
from typing import Final, TypeAlias, TypeVar, cast

from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import (
    NEVER,
    Automation,
    Condition,
    StartTrigger,
    is_of_device,
    is_of_two_values,
)
from homebot.integrations.homeassistant.automations.event_triggers import asked_message, asked_press
from homebot.integrations.homeassistant.automations.expressions import (
    LeftTemplate,
    constant_number,
    constants_in,
    entity_value,
    expression_of,
    folded,
    joined_pieces,
    parts_of_body,
    path_of,
    rebuilt,
    refused_template,
    shown_tree,
    state_entity,
    states_path,
    template_tree,
    text_of_parts,
    texts_in,
    with_text,
    with_trigger,
    with_value,
    without_sets,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.messages import (
    NAME_PATHS,
    is_value,
    note_length,
    value_text,
    without_unit,
)
from homebot.integrations.homeassistant.automations.states import (
    SUN_ANGLES,
    UNKNOWN,
    attribute_of,
    each_state,
    helper_time,
    known_texts,
    limits_text,
    number_of,
    state_texts,
    sun_angle_text,
)
from homebot.integrations.homeassistant.automations.template_calculations import calculation_text, is_calculated
from homebot.integrations.homeassistant.automations.template_elapsed import (
    clock_helper,
    elapsed_limit,
    helper_of,
    is_last_run,
    is_run_today,
    moment_entity,
)
from homebot.integrations.homeassistant.automations.template_lists import (
    NEGATED,
    count_text,
    counted_list,
    entity_list,
    list_of_loop,
    names_text,
)
from homebot.integrations.homeassistant.automations.template_numbers import (
    EQUAL,
    SIGNS,
    extreme_of,
    holds,
    is_of_two,
    number_of_tree,
    people_text,
    two_values_text,
    whole_limit,
)
from homebot.integrations.homeassistant.automations.template_times import (
    clock_of_today,
    days_of,
    hours_of,
    is_now,
    of_time,
    unit_of_now,
    weeks_of,
)
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes
from homebot.support.located import Located

AnyOf: TypeAlias = Callable[[Sequence[list[Condition]]], list[Condition]]
"""Returns the conditions that hold if those of at least one of several do."""

_SWAPPED: Final = {"gt": "lt", "lt": "gt", "gteq": "lteq", "lteq": "gteq", "eq": "eq", "ne": "ne"}
_DENIED: Final[Mapping[str, Operator]] = {">": "<=", "<": ">=", ">=": "<", "<=": ">"}
_TURNED: Final[Mapping[str, Operator]] = {">": "<", "<": ">", ">=": "<=", "<=": ">="}
_LIMITS: Final = (("trigger", "above"), ("trigger", "below"))
_STATE: Final = ("trigger", "to_state", "state")
_BEFORE: Final = ("trigger", "from_state", "state")
_PLATFORM: Final = ("trigger", "platform")
_Ways: TypeAlias = list[tuple[list[Condition], list[nodes.Node]]]
_NodeT = TypeVar("_NodeT", bound=nodes.Node)
_KeyT = TypeVar("_KeyT")


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
        expression = self._of_its_state(self._inlined(expression))
        if isinstance(expression, nodes.Filter) and entity_list(expression) is not None:
            raise refused_template(text, "a list itself is neither true nor false; write `| count > 0` behind it")
        if isinstance(expression, nodes.Const):  # a template is rendered to a text, which is true or not
            return [] if str(expression.value).strip().casefold() in _TRUE else [NEVER]
        return self._read(expression)

    def passed(self, text: str, entity: str, side: str, limit: float) -> str:
        """Return the trigger that the difference in *text*, with the state of *entity*, is above or below *limit*."""

        def put(node: nodes.Node) -> nodes.Node:
            if path_of(node) == ("state", "state"):
                return nodes.Call(nodes.Name("states", "load"), [nodes.Const(entity)], [], None, None)
            return rebuilt(node, put)

        difference = cast("nodes.Expr", put(self._inlined(expression_of(text))))
        return two_values_text(self._automation, difference, "gt" if side == "above" else "lt", nodes.Const(limit))

    def _of_its_state(self, node: nodes.Expr) -> nodes.Expr:
        """Return *node* with the state of the only entity that starts the automation."""
        triggers = self._automation.triggers
        entities = {trigger.entity for trigger in triggers}
        is_press = any(entity.startswith("input_button.") for entity in entities)  # its state is a time
        if len(entities) != 1 or "" in entities or is_press or any(trigger.state for trigger in triggers):
            return node
        return cast("nodes.Expr", with_trigger(node, triggers, is_state=not self._automation.has_waited))

    def _inlined(self, node: _NodeT) -> _NodeT:
        """Put the templates of variables into *node*."""
        for key, value in node.iter_fields():
            if isinstance(value, nodes.Sub) and self._is_since_start(value):
                setattr(node, key, nodes.Getattr(nodes.Name("trigger", "load"), "for", "load"))
            elif isinstance(value, nodes.Name) and value.name in self._automation.expressions:
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

    def _is_since_start(self, node: nodes.Sub) -> bool:
        """Return whether *node* is the time since the change that started it, which is the length of its state."""
        since = {("trigger", "to_state", last) for last in ("last_changed", "last_updated")}
        lengths = {trigger.value(("trigger", "for")) for trigger in self._automation.triggers}
        is_since = is_now(node.left) and path_of(node.right) in since
        return is_since and None not in lengths and not self._automation.has_waited

    def message(self, text: str, *, has_units: bool = True) -> str:
        """Return the text of a message with the values of its template in braces, with their units or without them."""
        if "{" not in text:
            return text.strip()
        pieces: list[str] = []
        unit = ""
        for node in map(folded, self._parts_of(text)):
            if isinstance(node, nodes.If):
                raise refused_template(text, "it has statements")
            if isinstance(node, nodes.For):
                pieces.append(names_text(self._automation, list_of_loop(node)))
            elif isinstance(node, nodes.TemplateData | nodes.Const):
                piece = str(node.data if isinstance(node, nodes.TemplateData) else node.value)
                if "{" in piece or "}" in piece:
                    raise refused_template(text, "braces in a message mean a value")
                pieces.append(without_unit(piece, unit) if has_units else piece)
                unit = ""
            elif not _is_unit(node):
                value, unit = value_text(self._automation, node)
                pieces.append(value)
        return "".join(pieces).strip()

    def moment(self, text: str) -> tuple[str, float]:
        """Return the entity with the moment that a template waits for, and the seconds after it; else an empty id.

        It is true from then on, perhaps until a later one.
        """
        begins: list[tuple[str, float]] = []
        ends: list[tuple[str, float]] = []
        parts = [self._inlined(expression_of(text))]
        while parts:
            match parts.pop():
                case nodes.And(left=left, right=right):
                    parts += [left, right]
                case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=right)]) if (
                    elapsed := elapsed_limit(left, sign, right)
                ) is not None and (entity := moment_entity(elapsed.last)):
                    (begins if elapsed.sign[0] == ">" else ends).append((entity, elapsed.seconds))
                case nodes.Compare(expr=left, ops=[nodes.Operand(op="eq", expr=right)]) if (
                    unit_of_now(left) == "clock" and (helper := clock_helper(right))[0]
                ) or (unit_of_now(right) == "clock" and (helper := clock_helper(left))[0]):
                    begins.append(helper)
                case nodes.Not(node=nodes.Test(name="none", node=inner)) if entity := moment_entity(inner):
                    ends.append((entity, math.inf))
                case _:
                    return "", 0.0
        if len(begins) != 1 or any(entity != begins[0][0] or end <= begins[0][1] for entity, end in ends):
            return "", 0.0
        return begins[0]

    def ways(self, call: Located) -> list[tuple[list[Condition], Located]]:
        """Return the calls that *call* becomes by the first choice in its templates, each with its conditions.

        The last call has none, or that of the last trigger; empty without a choice.
        """
        for path, text in texts_in(call):
            try:
                parts = self._parts_of(text)
            except NotCarriedError:
                continue
            is_message = path[-1:] in {("message",), ("title",)}
            for place, node in enumerate(parts):
                if ways := self._ways_of(node, text, is_message=is_message):
                    return [
                        (held, with_text(call, path, text_of_parts(text, parts[:place] + way + parts[place + 1 :])))
                        for held, way in ways
                    ]
        return []

    def _parts_of(self, text: str) -> list[nodes.Node]:
        """Return the texts, values and choices of the template *text*, with those of variables."""
        if isinstance(text, LeftTemplate):
            return text.parts
        parts: list[nodes.Node] = []
        for part in parts_of_body(without_sets(template_tree(text).body), text):
            if isinstance(part, nodes.Name) and part.name in self._automation.expressions:
                parts += map(self._inlined, self._parts_of(self._automation.expressions[part.name]))
            else:
                parts += joined_pieces(part) if isinstance(part, nodes.Concat) else [self._inlined(part)]
        return parts

    def _ways_of(self, node: nodes.Node, text: str, *, is_message: bool) -> _Ways:
        """Return the choices of *node*, each with its conditions; empty for none."""
        if isinstance(node, nodes.TemplateData | nodes.Const):
            return []
        if isinstance(node, nodes.If):
            return self._of_statement(node, text)
        for read in (self._of_choice, self._of_names, self._of_chance, self._of_table):
            if ways := read(node):
                return ways
        ways = self._of_trigger(node, text, is_message=is_message)
        return ways if ways or is_message else self._by_option(node)

    def _of_statement(self, node: nodes.If, text: str) -> _Ways:
        """Return the two ways of ``{% if … %}``, of which the other one may be a choice again."""
        rest: Sequence[nodes.Node] = node.else_
        for other in node.elif_[:1]:
            rest = [nodes.If(other.test, other.body, node.elif_[1:], node.else_)]
        held = self._read(self._of_its_state(cast("nodes.Expr", node.test)))
        return [(held, parts_of_body(node.body, text)), ([], parts_of_body(rest, text))]

    def _of_choice(self, node: nodes.Node) -> _Ways:
        """Return the two ways of ``a if b else c``, also of one in a calculation."""
        choice = node if isinstance(node, nodes.CondExpr) else node.find(nodes.CondExpr)
        if choice is None or (node is not choice and choice.expr2 is None):
            return []
        if _count_of_ways(node) > _MAX_WAYS:
            raise refused_template(shown_tree(node), f"its choices have more than {_MAX_WAYS} ways together")
        held = self._read(self._of_its_state(choice.test))
        values = [choice.expr1, choice.expr2]
        if node is choice:
            yes, no = ([] if value is None else joined_pieces(value) for value in values)
        else:
            yes, no = ([with_value(node, choice, value)] for value in values if value is not None)
        return [(held, yes), ([], no)]

    def _of_names(self, node: nodes.Node) -> _Ways:
        """Return the ways of a part of the name of the entity that started it, which each device has its own of."""
        triggers = self._automation.triggers
        match node:
            case nodes.Filter(
                name="replace", node=named, args=[nodes.Const(value=str(old)), nodes.Const(value=str(new))]
            ) if path_of(named) in NAME_PATHS and all(trigger.entity for trigger in triggers):
                devices = (self._automation.entities.find(trigger.entity).device for trigger in triggers)
                groups = _grouped(triggers, [(device.name or device.id).replace(old, new) for device in devices])
                return [(self.started_by(group), [nodes.Const(name)]) for name, group in groups.items()]
        return []

    def _of_chance(self, node: nodes.Node) -> _Ways:
        """Return the values of which one is drawn by chance; of a long range some."""
        drawn = _drawn(node.node) if isinstance(node, nodes.Filter) and node.name == "random" else []
        if len(drawn) > _MAX_DRAWN:
            drawn = [drawn[place * (len(drawn) - 1) // (_OF_RANGE - 1)] for place in range(_OF_RANGE)]
            self._automation.notes.append(
                f"of a long range one of {_OF_RANGE} numbers is drawn, from its least to its most"
            )
        return [
            ([(f"chance 1 in {len(drawn) - place}",)] if place < len(drawn) - 1 else [], joined_pieces(value))
            for place, value in enumerate(drawn)
        ]

    def _of_table(self, node: nodes.Node) -> _Ways:
        """Return the values of a table by the key that is looked up."""
        match node:
            case (
                nodes.Getitem(node=known, arg=asked)
                | nodes.Call(node=nodes.Getattr(node=known, attr="get"), args=[asked, *_])
            ) if table := _table_of(known):
                default = node.args[1:] if isinstance(node, nodes.Call) else []
                key_of = self._of_its_state(asked)
                by_key: _Ways = [(self._compared(key_of, "eq", key), [value]) for key, value in table]
                return [*by_key, ([], [*default])] if default else [*by_key, ([NEVER], [])]
        return []

    def _of_trigger(self, node: nodes.Node, text: str, *, is_message: bool) -> _Ways:
        """Return the values of *node* by the trigger; empty for one that names no value of it."""
        triggers, asked = self._automation.triggers, {path_of(inner) for inner in (node, *node.find_all(nodes.Getattr))}
        is_asked = not self._automation.has_waited and all(trigger.value(_STATE) is None for trigger in triggers)
        is_state = _STATE in asked and (is_message or is_asked)
        if is_state:
            note_length(self._automation)
        paths = {path for path in asked if any(trigger.value(path) is not None for trigger in triggers)}
        if is_state and all(trigger.entity for trigger in triggers):  # each state is asked anew
            paths = paths - {_STATE} | {("trigger", "entity_id")}
        if not paths or (is_message and is_value(self._automation, node)):
            return []
        groups = _grouped(triggers, [tuple(trigger.value(path) for path in sorted(paths)) for trigger in triggers])
        if any(None in key for key in groups):
            raise refused_template(text, "not each trigger has this value; write it as `choose`")
        return [
            (self.started_by(group), [folded(with_trigger(node, group, is_state=is_state))])
            for group in groups.values()
        ]

    def _by_option(self, node: nodes.Node) -> _Ways:
        """Return the texts that *node* is for each option of the only entity in it; none for another expression."""
        entities = {entity for inner in (node, *node.find_all(nodes.Call)) if (entity := state_entity(inner))}
        if len(entities) != 1 or (entity := min(entities)).partition(".")[0] not in {"input_select", "select"}:
            return []
        options = self._automation.entities.find(entity).options("option")

        def put(inner: nodes.Node, option: str) -> nodes.Node:
            if state_entity(inner) == entity:
                return nodes.Const(option)
            return rebuilt(inner, lambda other: put(other, option))

        return [(self._in_state(entity, option), [folded(put(node, option))]) for option in options]

    def _read(self, node: nodes.Expr) -> list[Condition]:
        node = cast("nodes.Expr", folded(node))
        for read in (
            *(self._known, self._of_change, self._of_entity, days_of, weeks_of),
            *(self._tested, self._of_listed_numbers, self._counted),
        ):
            if (special := read(node)) is not None:
                return special
        match node:
            case nodes.And():
                return [*self._read(node.left), *self._read(node.right)]
            case nodes.Or():
                return self._any_of([self._read(node.left), self._read(node.right)])
            case nodes.Not():
                return self._denied(self._read(node.node))
            case nodes.Const(value=value):
                return [] if value else [NEVER]
            case nodes.Compare(expr=left, ops=ops):
                conditions: list[Condition] = []
                for operand in ops:
                    conditions += self._compared(left, operand.op, operand.expr)
                    left = operand.expr
                return conditions
            case nodes.Call(node=nodes.Name(name="is_state"), args=[nodes.Const(value=str(entity)), wanted]):
                return self._any_of([self._in_state(entity, str(state)) for state in constants_in(wanted)])
            case nodes.Call(
                node=nodes.Name(name="is_state_attr"),
                args=[nodes.Const(value=str(entity)), nodes.Const(value=attribute), nodes.Const(value=value)],
            ):
                return [(attribute_of(self._automation.entities, entity, str(attribute), value),)]
            case nodes.Getattr() if path_of(node) in {("wait", "completed"), ("wait", "trigger")}:
                return [("not wait timed out",)]
            case nodes.Filter(name="bool", node=inner) if inner is not None:
                return self._read(inner)
        raise refused_template(shown_tree(node))

    def _of_entity(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the conditions of a test of the entity that started it: one for each; None for another expression."""
        calls = (node, *node.find_all(nodes.Call))
        is_asked = any(isinstance(call, nodes.Call) and _is_of_entity(call) for call in calls)
        is_state = self._is_new_state(node)
        if not (is_asked or is_state) or not isinstance(node, nodes.Call | nodes.Compare):
            return None
        triggers = self._automation.triggers
        groups = _grouped(triggers, [trigger.entity for trigger in triggers])
        if "" in groups:
            raise refused_template(shown_tree(node), "not each trigger has an entity; give each an `id`")
        conditions: list[Condition] = []
        for group in groups.values():
            held = self._read(cast("nodes.Expr", with_trigger(node, group, is_state=is_state)))
            conditions += self._any_of([self._denied(self.started_by(group)), held]) if len(groups) > 1 else held
        return conditions

    def _is_new_state(self, node: nodes.Expr) -> bool:
        """Return whether *node* asks for the state of which each trigger is any, and which is that of now."""
        is_any = all(trigger.entity and not trigger.state for trigger in self._automation.triggers)
        paths = map(path_of, node.find_all(nodes.Getattr))
        return is_any and not self._automation.has_waited and _STATE in paths

    def _tested(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the conditions of ``is none`` and ``is defined``; None for another expression."""
        match node:
            case nodes.Compare(expr=left, ops=[nodes.Operand(op="eq" | "lteq", expr=nodes.Const(value=0))]) if path_of(
                left
            ) == ("wait", "remaining"):
                return [("wait timed out",)]
            case nodes.Test(name="defined" | "none" as test, node=inner) if path_of(inner) in _LIMITS:
                path = path_of(inner)  # a limit that a trigger lacks is none, and one of another kind is undefined
                return self.started_by(
                    [
                        trigger
                        for trigger in self._automation.triggers
                        if any(trigger.value(limit) is not None for limit in _LIMITS)
                        and (test == "defined" or trigger.value(path) is None)
                    ]
                )
            case nodes.Test(name="none", node=inner) if path_of(inner) == ("wait", "trigger"):
                return [("wait timed out",)]
            case nodes.Compare() if (is_so := is_run_today(self._automation, node)) is not None:
                return [("run today" if is_so else "not run today",)]
            case nodes.Test(name="none", node=inner) if is_last_run(self._automation, inner):
                return [NEVER]  # one that never ran is over any time ago
        return None

    def _known(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the conditions of a guard against unknown states; None for another expression.

        A routine starts by no unknown state.
        """
        match node:
            case nodes.Compare(
                expr=left,
                ops=[nodes.Operand(op="notin" | "ne", expr=(nodes.Const() | nodes.List() | nodes.Tuple()) as listed)],
            ):
                states = {str(value) for value in constants_in(listed)}
                if not states <= UNKNOWN:
                    return None
                if (path := path_of(left)) == _BEFORE:
                    self._automation.notes.append("a state that differs from that before it was unknown starts it")
                if path in {_STATE, _BEFORE}:
                    return self._by_a_state()
                if (entity := state_entity(left)) and states - {""}:
                    return [known_texts(self._automation.entities, entity)]
            case nodes.Call(node=nodes.Name(name="has_value"), args=[nodes.Const(value=str(entity))]):
                return [known_texts(self._automation.entities, entity)]
            case nodes.Call(node=nodes.Name(name="is_number"), args=[inner]) if entity := state_entity(inner):
                return [known_texts(self._automation.entities, entity)]
        return None

    def _of_change(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the conditions that the state is another one than before; None for another expression."""
        match node:
            case nodes.Compare(expr=left, ops=[nodes.Operand(op="notin" | "ne", expr=right)]):
                paths, entities = {path_of(left), path_of(right)}, {state_entity(left), state_entity(right)} - {""}
                is_after = _STATE in paths or any(trigger.entity in entities for trigger in self._automation.triggers)
                if _BEFORE in paths and is_after:
                    return self._by_a_state()
            case nodes.Compare(expr=left, ops=[nodes.Operand(op="in", expr=right)]) if path_of(left) == _BEFORE and {
                *constants_in(right)
            } == {"home", "not_home"}:
                if all(trigger.entity[:6] in {"", "group."} for trigger in self._automation.triggers):
                    return self._by_a_state()
        return None

    def _of_listed_numbers(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the condition of a limit of the least, or the greatest, number of a list; None for another one."""
        match node:
            case nodes.Compare(
                expr=nodes.Filter(name="min" | "max" as end, node=numbers), ops=[nodes.Operand(op=sign, expr=limit)]
            ) if (known := entity_list(numbers)) is not None and sign in SIGNS:
                is_any = (end == "min") is (SIGNS[sign][0] == "<")
                limited = known.limited(sign if is_any else NEGATED[sign], constant_number(limit))
                if known.told != "number" or limited is None:
                    raise refused_template(
                        end, "a number of its list may be unknown; write `select('is_number')` before it"
                    )
                held = self._any_of([[(f"({text})",)] for text in limited.texts(self._automation)])
                return held if is_any else self._denied(held)
        return None

    def _counted(self, node: nodes.Expr) -> list[Condition] | None:
        """Return the condition that any, or none, of several entities is in a state; None for another expression."""
        sign, most = "gt", 0
        match node:
            case nodes.Compare(expr=counted, ops=[nodes.Operand(op=sign, expr=nodes.Const(value=int(most)))]):
                known = counted_list(counted)
            case nodes.Compare(
                expr=nodes.Filter() as listed,
                ops=[nodes.Operand(op="eq" | "ne" as sign, expr=nodes.Const(value=[] | "") | nodes.List(items=[]))],
            ):
                known = entity_list(listed.node if listed.name == "join" else listed)
            case nodes.Filter() | nodes.For():
                known = counted_list(node) or entity_list(node)
            case _:
                return None
        if known is None:
            return None
        if known.is_at_home and (sign in SIGNS or not most):
            number_sign = SIGNS.get(sign, "<=" if sign == "eq" else ">")
            return [(people_text(self._automation, number_sign, float(most)),)]
        any_of_them = self._any_of([[(f"({text})",)] for text in known.texts(self._automation)])
        match sign, most:
            case ("gt" | "ne", 0) | ("gteq", 1):
                return any_of_them
            case ("eq" | "lteq", 0) | ("lt", 1):
                return self._denied(any_of_them)
        return _limits_of(f"{{{count_text(self._automation, known)}}}", sign, most, 1)

    def _by_a_state(self) -> list[Condition]:
        """Return the condition that a state started it: any other trigger has none, and ends with an error."""
        return self.started_by([trigger for trigger in self._automation.triggers if trigger.entity])

    def _in_state(self, entity: str, state: str) -> list[Condition]:
        """Return the conditions that an entity is in a state: a group is on if any of its members is, else off."""
        entities = self._automation.entities
        members = entities.members(entity) if state in {"on", "off"} else []
        texts = [text for one in members or [entity] for text in state_texts(entities, one, [state])]
        held = [(bracketed(text),) for text in texts]
        return self._any_of([[condition] for condition in held]) if members and state == "on" else [*held]

    def _compared(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition]:
        """Return the condition that *left* is, or is not, so compared with *right*; calculations come last."""
        if sign in _SWAPPED:
            left, right = (cast("nodes.Expr", folded(side)) for side in (left, right))
        noted = len(self._automation.notes)
        try:
            return self._compared_by_words(left, sign, right)
        except NotCarriedError:
            del self._automation.notes[noted:]
            if sign not in _SWAPPED or not any(map(is_calculated, (left, right))):
                raise
            return self._calculated(left, sign, right)

    def _calculated(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition]:
        """Return the condition that a calculated number is above or below a limit, or near it."""
        limit = constant_number(right) if isinstance(right, nodes.Const | nodes.Neg) else None
        number = left if limit is not None else nodes.Sub(left, right)
        value = f"{{{calculation_text(self._automation, number, may_be_unknown=False)}}}"
        return _limits_of(value, sign, limit or 0.0, EQUAL)

    def _compared_by_words(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition]:
        if sign in {"in", "notin"}:
            values = constants_in(right)
            hours = hours_of(values) if unit_of_now(left) == "hour" else []
            held = hours or self._any_of([self._equal(left, value) for value in values])
            return held if sign == "in" else self._denied(held)
        if isinstance(left, nodes.Const) and not isinstance(right, nodes.Const):
            left, right, sign = right, left, _SWAPPED[sign]
        for read in (
            *(self._with_either, self._of_truths, self._of_extreme),
            *(self._of_clock, self._since, self._of_two_values),
        ):
            if (special := read(left, sign, right)) is not None:
                return special
        (value,) = constants_in(right)
        if sign == "eq":
            return self._equal(left, value)
        if sign == "ne" and path_of(left)[:1] == ("wait",):  # without a trigger it is an error
            raise refused_template(shown_tree(left), "ask for the trigger that ended it")
        if sign == "ne":
            return self._denied(self._equal(left, value))
        return self._limited(left, SIGNS[sign], value)

    def _with_either(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition] | None:
        """Return the condition of a comparison with ``a if b else c``; None for another one."""
        if not isinstance(right, nodes.CondExpr) or right.expr2 is None:
            return None
        held = self._read(right.test)
        yes, no = (self._compared(left, sign, value) for value in (right.expr1, right.expr2))
        return self._any_of([[*held, *yes], [*self._denied(held), *no]])

    def _of_truths(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition] | None:
        """Return the condition that two truth values are the same, or not; None for other values."""
        if sign not in {"eq", "ne"} or not (_is_truth(left) and _is_truth(right)):
            return None
        (yes, no), (also, neither) = ((held, self._denied(held)) for held in map(self._read, (left, right)))
        if sign == "ne":
            also, neither = neither, also
        return self._any_of([[*yes, *also], [*no, *neither]])

    def _of_two_values(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition] | None:
        """Return the condition that one value is above or below another; None for a limit of one alone."""
        is_limit = isinstance(right, nodes.Const | nodes.Neg)
        if is_limit and not is_of_two(left):
            return None
        ways = ("gt", "lt") if sign == "ne" and not is_limit else (sign,)
        return [tuple(two_values_text(self._automation, left, way, right) for way in ways)]

    def _of_clock(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition] | None:
        """Return the condition that a time of day, perhaps that of a helper, is past; None for another comparison."""
        if sign not in SIGNS:
            return None
        if clock_of_today(left) or clock_helper(left)[0]:
            left, right, sign = right, left, _SWAPPED[sign]
        if is_now(left) and (clock := clock_of_today(right)):
            return of_time("clock", SIGNS[sign], clock)
        helper, seconds = clock_helper(right) if unit_of_now(left) == "clock" else ("", 0.0)
        if not helper or seconds:
            return None
        side = "after" if SIGNS[sign][0] == ">" else "before"
        return [(f"{side} {helper_time(self._automation.entities, helper)}",)]

    def _of_extreme(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition] | None:
        """Return the condition of a limit of the least, or the greatest, of some values; None for another number."""
        if (several := extreme_of(left)) is None or sign not in SIGNS:
            return None
        kind, values = several
        ways = [self._read(nodes.Compare(value, [nodes.Operand(sign, right)])) for value in values]
        if (kind == "min") is (SIGNS[sign][0] == ">"):
            return [condition for way in ways for condition in way]
        return self._any_of(ways)

    def _equal(self, left: nodes.Expr, value: object) -> list[Condition]:
        path = path_of(left)
        match path:
            case ("wait", "trigger", "id" | "entity_id") | ("wait", "trigger", "event", "data", _):
                waited = self._automation.waited
                return self._ended_by([one for one in waited if one.value(path[1:]) == str(value)], left)
            case ("wait", "trigger") if value is None:
                return [("wait timed out",)]
        if (told := self._told_by_trigger(path, value, left)) is not None:
            return told
        if (unit := unit_of_now(left)) and type(value) is (str if unit in {"clock", "day"} else int):
            return of_time(unit, "==", value)
        entity, attribute = entity_value(left)
        if attribute:
            return [(attribute_of(self._automation.entities, entity, attribute, value),)]
        if entity:
            return self._in_state(entity, str(value))
        raise refused_template(shown_tree(left))

    def _told_by_trigger(self, path: tuple[str, ...], value: object, asked: nodes.Expr) -> list[Condition] | None:
        """Return the condition that the trigger has *value* at *path*; None for another path."""
        match path:
            case (
                ("trigger", "id" | "payload" | "platform" | "event")
                | ("trigger", "event", "data", _)
                | ("trigger", "to_state", "attributes", "event_type")
            ):
                return self._in_event(path, value, asked)
            case ("trigger", "payload_json", *places):
                return [tuple(asked_message(trigger, places, str(value)) for trigger in self._messages(asked))]
            case ("trigger", "from_state", "state") if any(
                trigger.value(path) is None for trigger in self._automation.triggers
            ):
                raise refused_template(shown_tree(asked), "not each trigger has one state before; write it as `from`")
            case ("trigger", "to_state", "state") if any(
                trigger.entity and not trigger.state for trigger in self._automation.triggers
            ):
                raise refused_template(
                    shown_tree(asked), "not each trigger names its state; ask for the state of the entity"
                )
            case (
                ("trigger", "entity_id")
                | ("trigger", "to_state", "entity_id")
                | ("trigger", "from_state" | "to_state", "state")
            ):
                if any(not trigger.entity for trigger in self._automation.triggers):
                    raise NotCarriedError(
                        "template: not each trigger is about a state; give the triggers an `id`, and ask for it"
                    )
                return self.started_by([one for one in self._automation.triggers if one.value(path) == value])
        return None

    def _in_event(self, path: Sequence[str], value: object, asked: nodes.Expr) -> list[Condition]:
        """Return the condition that the event, or the trigger, has *value* at *path*."""
        triggers = self._automation.triggers
        if not (open_ones := [trigger for trigger in triggers if trigger.asks == path[-1]]):
            if any(trigger.value(path) is None for trigger in triggers if trigger.value(_PLATFORM) == "event"):
                raise refused_template(shown_tree(asked), "homebot does not read this of the event")
            return self.started_by([trigger for trigger in triggers if trigger.value(path) == str(value)])
        if path[-1] == "payload":
            return [tuple(asked_message(trigger, (), str(value)) for trigger in self._messages(asked))]
        if len(open_ones) < len(triggers):
            raise refused_template(shown_tree(asked), "not each trigger has it; write it as `choose`")
        return [tuple(asked_press(trigger, str(value)) for trigger in open_ones)]

    def _messages(self, asked: nodes.Expr) -> list[StartTrigger]:
        """Return the triggers by any message on a topic, of which *asked* is a value."""
        triggers = self._automation.triggers
        if any(trigger.asks != "payload" for trigger in triggers):
            raise refused_template(shown_tree(asked), "not each trigger has it; write it as `choose`")
        return triggers

    def _since(self, left: nodes.Expr, sign: str, right: nodes.Expr) -> list[Condition] | None:
        """Return the condition that something is so long ago, or not; None for another comparison."""
        if (elapsed := elapsed_limit(left, sign, right)) is None:
            return None
        is_over, seconds = elapsed.sign[0] == ">", elapsed.seconds
        side = "over" if is_over else "under"
        if is_last_run(self._automation, elapsed.last):
            if seconds <= 0:
                return [] if is_over else [NEVER]
            return [(f"last run {side} {seconds:.12g}s ago",)]
        if seconds > 0 and (moment := helper_of(elapsed.last)):
            told = f"text of {self._automation.entities.find(moment).query}"
            return [(f"{told} {side} {seconds:.12g}s ago",)]
        entity = states_path(elapsed.last.node) if isinstance(elapsed.last, nodes.Getattr) else ""
        if not entity or path_of(elapsed.last)[-1] != "last_changed":
            raise refused_template(
                shown_tree(elapsed.last), "a routine knows how long a state lasts, and when it ran itself"
            )
        if seconds <= 0:
            return [] if is_over else [NEVER]
        lasting = f"{'' if is_over else 'less than '}{seconds:.12g}s"
        return [tuple(f"({text} for {lasting})" for text in each_state(self._automation.entities, entity))]

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

    def _ended_by(self, triggers: Sequence[StartTrigger], asked: nodes.Expr) -> list[Condition]:
        """Return the condition that one of *triggers* ended the last wait, which *asked* is about."""
        waited = self._automation.waited
        if not waited or len({trigger.text for trigger in waited}) < len(waited):
            raise refused_template(shown_tree(asked), "it is not known what was waited for")
        if len(triggers) == len(waited):
            return [("not wait timed out",)]
        return [tuple(f"wait ended by {trigger.text}" for trigger in triggers)] if triggers else [NEVER]

    def _limited(self, left: nodes.Expr, sign: Operator, value: object) -> list[Condition]:
        if unit := unit_of_now(left):
            return of_time(unit, sign, value)
        if type(value) not in (int, float):
            raise refused_template(shown_tree(left), "it compares a text")
        number = number_of_tree(left)
        limit = (float(str(value)) - number.offset) / number.factor
        sign = sign if number.factor > 0 else _TURNED[sign]
        if number.is_whole:
            sign, limit = whole_limit(sign, limit)
        if number.entity == "sun.sun" and number.attribute in SUN_ANGLES:
            return [(sun_angle_text(number.attribute, sign, limit),)]
        if number.entity == "zone.home" and not number.attribute:
            return [(people_text(self._automation, sign, limit),)]
        entity, capability, factor = number_of(self._automation.entities, number.entity, number.attribute)
        limit *= factor
        if number.default is not None and holds(number.default * factor, sign, limit):
            return [(f"not ({limits_text(entity, capability, [(_DENIED[sign], limit)])})",)]
        return [(f"({limits_text(entity, capability, [(sign, limit)])})",)]


def _grouped(triggers: Sequence[StartTrigger], keys: Sequence[_KeyT]) -> dict[_KeyT, list[StartTrigger]]:
    """Return the triggers with the same of *keys*, of which each has one."""
    groups: dict[_KeyT, list[StartTrigger]] = {}
    for trigger, key in zip(triggers, keys, strict=True):
        groups.setdefault(key, []).append(trigger)
    return groups


def _is_truth(node: nodes.Expr) -> bool:
    """Return whether *node* is true or false."""
    match node:
        case nodes.And() | nodes.Or() | nodes.Not() | nodes.Compare() | nodes.Test() | nodes.Const(value=bool()):
            return True
        case nodes.Call(node=nodes.Name(name="is_state" | "is_state_attr" | "has_value")):
            return True
    return False


def _is_of_entity(call: nodes.Call) -> bool:
    return bool(call.args) and path_of(call.args[0]) in {("trigger", "entity_id"), ("trigger", "to_state", "entity_id")}


def _is_unit(node: nodes.Node) -> bool:
    """Return whether *node* is the unit of a value, which homebot writes itself."""
    match node:
        case nodes.Call(node=nodes.Name(name="state_attr"), args=[_, nodes.Const(value="unit_of_measurement")]):
            return True
    return path_of(node)[-2:] == ("attributes", "unit_of_measurement")


_TRUE: Final = frozenset({"true", "yes", "on", "enable", "1"})

_MAX_WAYS: Final = 50


def _count_of_ways(node: nodes.Node) -> int:
    """Return the number of ways that the choices in *node* have together."""
    if isinstance(node, nodes.CondExpr):
        return sum(_count_of_ways(value) for value in (node.expr1, node.expr2) if value is not None)
    return prod(map(_count_of_ways, node.iter_child_nodes()))


_MAX_DRAWN: Final = 20
"""Values of which one is drawn, each of which is written."""

_MAX_RANGE: Final = 1000
_OF_RANGE: Final = 5
"""Numbers that are written of a longer range."""


def _table_of(node: nodes.Node) -> list[tuple[nodes.Expr, nodes.Expr]]:
    """Return the keys and values of a mapping that is written as it is; none for another expression."""
    if isinstance(node, nodes.Dict):
        return [(pair.key, pair.value) for pair in node.items]
    if isinstance(node, nodes.Const) and isinstance(node.value, dict):
        return [(nodes.Const(key), nodes.Const(value)) for key, value in node.value.items()]
    return []


def _drawn(node: nodes.Node | None) -> list[nodes.Expr]:
    """Return the values in *node*, of which one is drawn; none if they are not known, or too many."""
    match node:
        case nodes.List() | nodes.Tuple():
            return node.items[:_MAX_DRAWN] if len(node.items) <= _MAX_DRAWN else []
        case nodes.Const(value=list(values)) if len(values) <= _MAX_DRAWN:
            return [*map(nodes.Const, values)]
        case nodes.Call(node=nodes.Name(name="range"), args=args):
            numbers = [int(constant_number(value)) for value in args]
            span = range(*numbers[:3]) if numbers and 0 not in numbers[2:3] else range(0)
            return [*map(nodes.Const, span)] if len(span) <= _MAX_RANGE else []
    return []


def keeps_state(text: str) -> bool:
    """Return whether the template *text* is only whether something of the house is so."""
    try:
        expression = expression_of(text)
    except NotCarriedError:
        return False
    return _is_truth(expression) and not isinstance(expression, nodes.Const) and "state" in text


def _limits_of(value: str, sign: str, number: float, step: float) -> list[Condition]:
    """Return the conditions that *value* is so compared with *number*; within a *step* two numbers are the same."""
    above, below = f"{value} above {number:.12g}", f"{value} below {number:.12g}"
    from_it, up_to_it = f"{value} above {number - step:.12g}", f"{value} below {number + step:.12g}"
    limits: Mapping[str, list[Condition]] = {
        "eq": [(from_it,), (up_to_it,)],
        "ne": [(above, below)],
        "gt": [(above,)],
        "gteq": [(from_it,)],
        "lteq": [(up_to_it,)],
    }
    return limits.get(sign, [(below,)])


def bracketed(text: str) -> str:
    """Return a state in brackets if it is a query, which others may be joined to."""
    return f"({text})" if is_of_device(text) and not is_of_two_values(text) else text
