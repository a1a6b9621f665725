"""Trees of the templates of automations, with the values that are known of their variables. Pure.

Source: Jinja 3.1 documentation, The Abstract Syntax Tree.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Final, Self, cast

from homebot.integrations.homeassistant.automations.entities import StartTrigger
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.variables import BoundTemplate
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes, tree_of
from homebot.integrations.homeassistant.formats.jinja.values import TemplateError
from homebot.support.located import Located


def expression_of(text: str) -> nodes.Expr:
    """Return the only expression of the template *text*."""
    if isinstance(text, _Expression):
        return text.tree
    parts = text.parts if isinstance(text, LeftTemplate) else parts_of_body(_output_of(text), text)
    parts = [node for node in parts if not (isinstance(node, nodes.TemplateData) and not node.data.strip())]
    if len(parts) == 1 and not isinstance(parts[0], nodes.TemplateData):
        return cast("nodes.Expr", parts[0])
    plain = text.strip().casefold()
    if plain in {"true", "false"}:
        return nodes.Const(plain == "true")
    raise refused_template(text)


def constant_of_template(text: str) -> float | None:
    """Return the number that the template *text* is by itself; None for any other."""
    try:
        value = folded(expression_of(text)) if "{{" in text else None
    except NotCarriedError:
        return None
    number = value.value if isinstance(value, nodes.Const) else None
    return float(number) if isinstance(number, int | float) and not isinstance(number, bool) else None


def template_tree(text: str) -> nodes.Template:
    """Return the tree of the template *text*, with the values that it is given."""
    try:
        tree = cast("nodes.Template", _with_choices(tree_of(text.strip())))
    except TemplateError as exc:
        raise refused_template(text, f"it {exc.problem}") from exc
    return cast("nodes.Template", _with_values(tree, text.values)) if isinstance(text, BoundTemplate) else tree


def _with_choices(node: nodes.Node) -> nodes.Node:
    """Return *node* with ``iif(a, b, c)`` as ``b if a else c``."""
    node = rebuilt(node, _with_choices)
    match node:
        case (
            nodes.Call(node=nodes.Name(name="iif"), args=[test, yes, no])
            | nodes.Filter(name="iif", node=test, args=[yes, no])
        ) if test is not None:
            return nodes.CondExpr(test, yes, no)
    return node


def _with_values(node: nodes.Node, values: Mapping[str, object]) -> nodes.Node:
    """Return *node* with *values* in place of the variables of these names, and their fields and elements."""
    node = rebuilt(node, lambda inner: _with_values(inner, values))
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


def parts_of_body(body: Sequence[nodes.Node], text: str) -> list[nodes.Node]:
    """Return the nodes of *body*, of which statements are choices alone."""
    parts: list[nodes.Node] = []
    for node in body:
        if not isinstance(node, nodes.Output | nodes.If | nodes.For):
            raise refused_template(text, f"it has statements; {_WAYS}")
        parts += node.nodes if isinstance(node, nodes.Output) else [node]
    return parts


_TRUTHS: Final = {("true", "false"), ("true", ""), ("false", "true")}


def _output_of(text: str) -> list[nodes.Output]:
    body = without_sets(template_tree(text).body)
    outputs = [node for node in body if isinstance(node, nodes.Output)]
    if len(outputs) == len(body):
        return outputs
    body = [node for node in body if not is_space(node)]
    match body:
        case [nodes.If(test=test, body=yes, elif_=[], else_=no)] if (
            words := tuple(_words_of(branch).casefold() for branch in (yes, no))
        ) in _TRUTHS:
            return [nodes.Output([test if words[0] == "true" else nodes.Not(test)])]
        case [nodes.If() as choice] if choice.else_:
            return [nodes.Output([_as_expression(choice, text)])]
    raise refused_template(text, f"it has statements; {_WAYS}")


def is_space(node: nodes.Node) -> bool:
    """Return whether *node* is only white space of a template."""
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
        match [node for node in body if not is_space(node)]:
            case [nodes.If() as inner]:
                values.append(_as_expression(inner, text))
            case [nodes.Output(nodes=parts)]:
                parts = [part for part in parts if not (isinstance(part, nodes.TemplateData) and not part.data.strip())]
                if len(parts) != 1:
                    raise refused_template(text, f"it has statements; {_WAYS}")
                value = parts[0]
                values.append(nodes.Const(value.data.strip()) if isinstance(value, nodes.TemplateData) else value)
            case _:
                raise refused_template(text, f"it has statements; {_WAYS}")
    return nodes.CondExpr(cast("nodes.Expr", choice.test), values[0], values[1])


def _words_of(body: Sequence[nodes.Node]) -> str:
    """Return the text of a branch, also if it is written as ``{{ true }}``."""
    parts = [part for node in body if isinstance(node, nodes.Output) for part in node.nodes]
    return "".join(str(getattr(part, "data", getattr(part, "value", "?"))) for part in parts).strip()


_NUMBERS: Final = re.compile(r"\[[-\d., ]*\]")
"""A list of numbers, such as those of a colour."""


class LeftTemplate(str):
    """A template after a choice in it, with its remaining parts."""

    parts: list[nodes.Node]
    __slots__ = ("parts",)


def text_of_parts(text: str, parts: list[nodes.Node]) -> str:
    """Return the remaining *parts* of the template *text*: plain text if possible."""
    texts = [
        str(part.data if isinstance(part, nodes.TemplateData) else part.value)
        for part in parts
        if isinstance(part, nodes.TemplateData | nodes.Const)
    ]
    if len(texts) == len(parts):
        plain = "".join(texts).strip()
        is_list = len(parts) == 1 and isinstance(getattr(parts[0], "value", None), list)
        return f"{{{{ {plain} }}}}" if is_list or _NUMBERS.fullmatch(plain) else plain
    left = LeftTemplate(text)
    left.parts = parts
    return left


def with_trigger(node: nodes.Node, triggers: Sequence[StartTrigger], *, is_state: bool) -> nodes.Node:
    """Return *node* with the values that all *triggers* have in common; their state, if that counts, is asked anew."""
    path, entities = path_of(node), {trigger.entity for trigger in triggers}
    if is_state and path == ("trigger", "to_state", "state") and len(entities) == 1 and "" not in entities:
        return nodes.Call(nodes.Name("states", "load"), [nodes.Const(min(entities))], [], None, None)
    match node:
        case (
            nodes.Call(node=nodes.Getattr(node=length, attr="total_seconds"), args=[])
            | nodes.Getattr(node=length, attr="seconds")
        ) if (
            path_of(length) == ("trigger", "for")
            and len(given := {one.value(("trigger", "for")) for one in triggers}) == 1
        ):
            if (text := given.pop()) is not None:
                return nodes.Const(sum(60**place * int(part) for place, part in enumerate(reversed(text.split(":")))))
    if len(values := {trigger.value(path) for trigger in triggers}) == 1 and (value := values.pop()) is not None:
        return nodes.Const(value)
    return rebuilt(node, lambda inner: with_trigger(inner, triggers, is_state=is_state))


def rebuilt(node: nodes.Node, change: Callable[[nodes.Node], nodes.Node]) -> nodes.Node:
    """Return *node* with its changed parts."""

    def of(field: object) -> object:
        if isinstance(field, nodes.Node):
            return change(field)
        return [*map(of, field)] if isinstance(field, list) else field

    return type(node)(*(of(field) for _, field in node.iter_fields()), environment=node.environment)


def without_sets(body: Sequence[nodes.Node]) -> list[nodes.Node]:
    """Return *body* with the expressions of its ``{% set … %}`` where they are used.

    A field of a ``namespace`` that a loop adds to is the loop itself, which writes the added values, or its count.
    """
    known: dict[tuple[str, ...], nodes.Node] = {}
    drawn: set[tuple[str, ...]] = set()

    def put(node: nodes.Node) -> nodes.Node:
        if known and (path := path_of(node)) in known:
            if path in drawn:
                raise refused_template(path[0], "it is drawn by chance and used twice; draw it in a variable")
            drawn.update([path] if is_drawn(known[path]) else [])
            return known[path]
        return rebuilt(node, put)

    rest: list[nodes.Node] = []
    for node in body:
        match node:
            case nodes.Assign(
                target=nodes.Name(name=name), node=nodes.Call(node=nodes.Name(name="namespace"), kwargs=fields)
            ):
                known |= {(name, field.key): put(field.value) for field in fields}
            case nodes.Assign(target=nodes.Name(name=name)):
                known[name,] = put(node.node)
            case nodes.For() if (added := _added_by(node)) is not None:
                path, loop = added
                is_first = known.get(path) in (nodes.List([]), nodes.Const(0))
                if not is_first:
                    raise refused_template(".".join(path), "it collects in several loops; write one list for each")
                known[path] = put(loop)
            case _:
                rest.append(put(node) if known else node)
    return rest


def _added_by(node: nodes.For) -> tuple[tuple[str, ...], nodes.Node] | None:
    """Return the field of a namespace to which a loop only adds, and its new value; None for another loop."""
    body, tests = [part for part in node.body if not is_space(part)], []
    while len(body) == 1 and isinstance(body[0], nodes.If) and not body[0].elif_ and not body[0].else_:
        tests.append(body[0].test)
        body = [part for part in body[0].body if not is_space(part)]
    match body:
        case [nodes.Assign(target=nodes.NSRef(name=name, attr=field), node=nodes.Add(left=left, right=right))]:
            pass
        case _:
            return None
    for test in tests:
        node = nodes.For(
            node.target, node.iter, [], [], nodes.And(node.test, test) if node.test else test, node.recursive
        )
    path = name, field
    match right:
        case nodes.List(items=[item]) if path_of(left) == path:
            return path, nodes.For(node.target, node.iter, [nodes.Output([item])], [], node.test, node.recursive)
        case nodes.Const(value=1) if path_of(left) == path:
            named = nodes.Getattr(nodes.Name(getattr(node.target, "name", ""), "load"), "name", "load")
            loop = nodes.For(node.target, node.iter, [nodes.Output([named])], [], node.test, node.recursive)
            return path, nodes.Filter(cast("nodes.Expr", loop), "count", [], [], None, None)
    return None


def is_drawn(node: nodes.Node) -> bool:
    """Return whether *node* is drawn by chance."""
    return any(
        inner.name == "random" for inner in (node, *node.find_all(nodes.Filter)) if isinstance(inner, nodes.Filter)
    )


def joined_pieces(node: nodes.Expr) -> list[nodes.Node]:
    """Return the values that *node* joins by ``~``."""
    if isinstance(node, nodes.Concat):
        return [piece for inner in node.nodes for piece in joined_pieces(inner)]
    return [folded(node)]


def with_value(node: nodes.Node, choice: nodes.Node, value: nodes.Node) -> nodes.Node:
    """Return *node* with *value* in the place of *choice*, and the results of calculations with constants alone."""
    if node == choice:
        return value
    new = rebuilt(node, lambda inner: with_value(inner, choice, value))
    is_number = isinstance(new, nodes.Filter) and isinstance(new.node, nodes.Const) and new.name in _OF_NUMBERS
    return _number_of(cast("nodes.Filter", new)) if is_number else folded(new)


_OF_NUMBERS: Final = frozenset({"int", "float", "round"})


def _number_of(chosen: nodes.Filter) -> nodes.Const:
    """Return the number of a constant, of which *chosen* is the filter."""
    constant = cast("nodes.Const", chosen.node)
    try:
        number = float(str(constant.value))
    except ValueError:
        raise refused_template(shown_tree(chosen), "it is no number") from None
    digits = int(constant_number(chosen.args[0])) if chosen.name == "round" and chosen.args else 0
    return nodes.Const(
        int(number) if chosen.name == "int" else round(number, digits) if chosen.name == "round" else number
    )


def folded(node: nodes.Node) -> nodes.Node:
    """Return the value of *node* if it is a constant; not of one that may grow beyond its text, or of a loop."""
    if isinstance(node, nodes.For) or node.find(nodes.For) is not None:
        return node
    if any(True for _ in node.find_all((nodes.Pow, nodes.Mul))) and any(
        isinstance(inner.value, str | list) for inner in node.find_all(nodes.Const)
    ):
        return node
    try:
        return nodes.Const(node.as_const()) if isinstance(node, nodes.Expr) else node
    except (nodes.Impossible, RuntimeError):
        return node


_INSTEAD: Final = (
    (("namespace", "{% for"), "write a list of names, such as `{names with battery of battery below 20}`"),
    (("| min", "| max", "| round", " * ", " / "), "write each range as a way of `choose`, with the number of that"),
    (("trigger.event.data.args", "args["), "write a trigger for each press, or bind the button by `homebot bind`"),
    (("payload_json",), "compare it with a text, such as `trigger.payload_json.action == 'left'`"),
    (("wait.trigger",), "ask for the state that was waited for, or for `wait.trigger is none`"),
    (("trigger.",), "give each trigger an `id`, and ask for that"),
    (("state_attr(",), "ask for a sensor with this value"),
    (("now()", "as_timestamp", "strptime"), "write the time as a condition, or `last_changed` of an entity"),
    (("range(", "random"), "write each value as a way of `choose`"),
    (("[",), "write each way as one of `choose`"),
)
"""The text to write instead of a template, by a word of the template."""

_WAYS: Final = "write each value as a way of `choose`, or a list as `{names of window open}`"
_STATES_INSTEAD: Final = "write the value itself, or each way as one of `choose` that asks for a state"


def refused_template(text: str, reason: str = "") -> NotCarriedError:
    """Return the error for the template *text*: the reason, else that it has no counterpart, and what to write."""
    shown = " ".join(text.split())
    if not reason:
        advice = next((advice for marks, advice in _INSTEAD if any(mark in shown for mark in marks)), _STATES_INSTEAD)
        reason = f"routines have no words for it; {advice}"
    shown = shown if len(shown) <= _MAX_SHOWN else f"{shown[:_MAX_SHOWN]}…"
    return NotCarriedError(
        f"template {shown!r}: {reason}; carried over are states, numbers against limits, now() and the trigger"
    )


def path_of(node: nodes.Node | None) -> tuple[str, ...]:
    """Return the names of ``trigger.to_state.state``; empty for another expression."""
    names: list[str] = []
    while True:
        match node:
            case nodes.Getattr(node=inner, attr=name):
                pass
            case nodes.Getitem(node=inner, arg=nodes.Const(value=str(name))) if name.isidentifier():
                pass
            case _:
                break
        names.append(name)
        node = inner
    return (node.name, *reversed(names)) if isinstance(node, nodes.Name) else ()


def states_path(node: nodes.Node) -> str:
    """Return the entity of ``states.sensor.x``; empty for another expression."""
    path = path_of(node)
    return ".".join(path[1:]) if len(path) == 3 and path[0] == "states" else ""


def state_entity(node: nodes.Node) -> str:
    """Return the entity of which *node* is the state; empty for another expression."""
    match node:
        case nodes.Call(node=nodes.Name(name="states"), args=[nodes.Const(value=str(entity))]):
            return entity
        case nodes.Getattr(attr="state"):
            return states_path(node.node)
    return ""


def entity_value(node: nodes.Node) -> tuple[str, str]:
    """Return the entity, and its attribute or else an empty text, that *node* is; empty for another expression."""
    match node:
        case nodes.Call(
            node=nodes.Name(name="state_attr"), args=[nodes.Const(value=str(entity)), nodes.Const(value=attribute)]
        ):
            return entity, str(attribute)
    return state_entity(node), ""


def constants_in(node: nodes.Expr) -> list[object]:
    """Return the constants that *node* is, or lists."""
    if isinstance(node, nodes.List | nodes.Tuple):
        return [value for item in node.items for value in constants_in(item)]
    if isinstance(node, nodes.Neg):
        return [-constant_number(node.node)]
    if isinstance(node, nodes.Call) and node.node == nodes.Name("range", "load") and 0 < len(node.args) < 3:
        ends = [int(constant_number(end)) for end in node.args]
        numbers = range(*ends)
        if len(numbers) <= _MAX_RANGE:
            return [*numbers]
    if isinstance(node, nodes.Const):
        return [node.value]
    raise refused_template(shown_tree(node), "it compares two values; routines compare a value with a number or a text")


def constant_number(node: nodes.Expr) -> float:
    """Return the number that *node* is by itself."""
    match node:
        case nodes.Const(value=int() | float() as value) if not isinstance(value, bool):
            return float(value)
        case nodes.Neg(node=inner):
            return -constant_number(inner)
    raise refused_template(shown_tree(node))


def _plain_filter(node: nodes.Filter) -> nodes.Node:
    """Return the number of a constant, of which *node* is the filter."""
    if not isinstance(node.node, nodes.Const) or node.name not in {"int", "float", "string"}:
        return node
    try:
        number = float(str(node.node.value))
    except ValueError:
        return node
    return nodes.Const(int(number) if node.name == "int" else number if node.name == "float" else str(node.node.value))


def shown_tree(node: nodes.Node) -> str:
    """Return *node* as people write it."""
    match node:
        case nodes.Name(name=name):
            return str(name)
        case nodes.Const(value=value):
            return repr(value)
        case nodes.Getattr(node=inner, attr=attribute):
            return f"{shown_tree(inner)}.{attribute}"
        case nodes.Call(node=inner, args=args):
            return f"{shown_tree(inner)}({', '.join(map(shown_tree, args))})"
        case nodes.Filter(node=inner, name=name, args=args) if inner is not None:
            given = f"({', '.join(map(shown_tree, args))})" if args else ""
            return f"{shown_tree(inner)} | {name}{given}"
        case nodes.Sub(left=left, right=right):
            return f"{shown_tree(left)} - {shown_tree(right)}"
        case nodes.Compare(expr=left, ops=ops):
            return f"{shown_tree(left)} {' '.join(f'{one.op} {shown_tree(one.expr)}' for one in ops)}"
        case nodes.Getitem(node=inner, arg=arg):
            return f"{shown_tree(inner)}[{shown_tree(arg)}]"
        case nodes.List(items=items):
            return f"[{', '.join(map(shown_tree, items))}]"
        case nodes.BinExpr(left=left, right=right):
            return f"{shown_tree(left)} {node.operator} {shown_tree(right)}"
    return type(node).__name__.lower()


def texts_in(node: Located, path: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Yield the templates in *node*, with their places."""
    if isinstance(node.value, str) and "{" in node.value and not node.tag:
        yield path, node.value
    items = enumerate(node.value) if isinstance(node.value, list) else ()
    for key, value in node.value.items() if isinstance(node.value, dict) else items:
        yield from texts_in(value, (*path, key))


def with_text(node: Located, path: tuple[str | int, ...], text: str) -> Located:
    """Return *node* with another text in the place *path*."""
    if not path:
        return node._replace(value=text)
    key, *rest = path
    if isinstance(node.value, dict):
        return node._replace(value={**node.value, key: with_text(node.value[key], tuple(rest), text)})
    assert isinstance(node.value, list)  # noqa: S101 - for the type checker: the path is that of the text
    values = list(node.value)
    values[int(key)] = with_text(values[int(key)], tuple(rest), text)
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
    match node.value:
        case list() as parts if joint == "and" or len(parts) == 1:
            pass
        case {"condition": Located(value=kind), "conditions": Located(value=value) as listed} if kind == joint:
            parts = value if isinstance(value, list) else [listed]
        case {"condition": Located(value="template"), "value_template": template}:
            parts = [template]
        case str() as text if "repeat.index" in text and isinstance(
            tree := expression_of(text), nodes.Or if joint == "or" else nodes.And
        ):
            parts = [Located(_Expression(text, side), node.line) for side in (tree.left, tree.right)]
        case _:
            return [node]
    return [part for inner in parts for part in _joined_by(joint, inner)]


def _most_rounds(node: Located, *, is_until: bool) -> int:
    """Return the number of rounds that the condition *node* allows; 0 for another condition."""
    if not isinstance(node.value, str) or "repeat.index" not in node.value:
        return 0
    match expression_of(node.value):
        case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=nodes.Const(value=int(most)))]) if path_of(
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


_MAX_RANGE: Final = 100

_MAX_SHOWN: Final = 60
