"""Lists of entities in the templates of automations: how many are in a state, and their names. Pure.

Source: Jinja 3.1 documentation, List of Builtin Filters; Home Assistant core 2026.11, ``helpers/template``.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity, capability_of_class
from homebot.integrations.homeassistant.automations.expressions import (
    constant_number,
    constants_in,
    path_of,
    refused_template,
    shown_tree,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import UNKNOWN, limits_text, state_text
from homebot.integrations.homeassistant.automations.template_numbers import SIGNS
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes

_SAME: Final = frozenset({"list", "sort", "unique", "expand"})
"""Filters after which a list has the same entities."""

_EQUAL: Final = frozenset({"eq", "==", "equalto"})
_NAME: Final = frozenset({"name", "attributes.friendly_name"})


class EntityList(NamedTuple):
    """Entities in a state; those of a list that are in no such state are left out.

    Attributes:
        ids: Their ids; without any, all of *domain*.
        classes: The classes of devices that count; empty for all.
        states: The states that count; empty for any.
        limit: A limit of their number.
        is_named: Whether it is the list of their names.
    """

    ids: tuple[str, ...] = ()
    domain: str = ""
    classes: frozenset[str] = frozenset()
    states: tuple[str, ...] = ()
    limit: tuple[Operator, float] | None = None
    is_named: bool = False

    def texts(self, automation: Automation) -> list[str]:
        """Return for each entity that it is so.

        Raises:
            NotCarriedError: It asks for no state, or homebot knows none of the entities.
        """
        if not self.ids and (of_class := self._of_classes()):
            return of_class
        entities = [*map(automation.entities.find, automation.entities.expanded(self.ids))]
        if not self.ids:
            entities = automation.entities.of_class(self.domain, self.classes)
            automation.notes.append(f"states.{self.domain} means the devices that homebot knows now")
        if not entities or not (self.states or self.limit):
            raise NotCarriedError(f"template: no state of entities of {self.domain or 'the list'} that homebot knows")
        return [text for entity in entities for text in self._of(entity)]

    def _of_classes(self) -> list[str]:
        """Return the states of any device of the classes, also of later ones; none if only some of them count."""
        known = [capability_of_class(name) for name in self.classes]
        if self.domain not in {"sensor", "binary_sensor"} or not known or "" in known:
            return []
        if self.limit is not None:
            return [f"{name}{self.limit[0]}{self.limit[1]:.12g}" for name in known]
        flags = {"on": "true", "off": "false"}
        return [f"{name}={flags[state]}" for name in known for state in self.states if state in flags]

    def _of(self, entity: KnownEntity) -> list[str]:
        if self.limit is not None:
            return [limits_text(entity, entity.capability, [self.limit])]
        return [state_text(entity, state, "state") for state in self.states]


def entity_list(node: nodes.Node | None) -> EntityList | None:
    """Return the entities that *node* lists; None for another expression."""
    match node:
        case nodes.Getattr() if len(path := path_of(node)) == 2 and path[0] == "states":
            return EntityList(domain=path[1])
        case nodes.Call(node=nodes.Name(name="expand"), args=args):
            lists = [_group(arg) or entity_list(arg) for arg in args]
            ids = [known.ids for known in lists if known is not None]
            return EntityList(sum(ids, ())) if lists and None not in lists and all(ids) else None
        case nodes.Const(value=str(entity)) if "." in entity and not entity.startswith("group."):
            return EntityList((entity,))
        case nodes.List() | nodes.Tuple() if node.items:
            lists = [*map(entity_list, node.items)]
            ids = [known.ids for known in lists if known is not None]
            return EntityList(sum(ids, ())) if None not in lists and all(ids) else None
        case nodes.Filter(node=inner) if (known := entity_list(inner)) is not None:
            return _filtered(known, node)
    return None


def _group(node: nodes.Node) -> EntityList | None:
    """Return the members of the group that *node* names, as ``expand`` takes them; None for another expression."""
    match node:
        case nodes.Const(value=str(entity)) if entity.startswith("group."):
            return EntityList((entity,))
    return None


def _filtered(known: EntityList, node: nodes.Filter) -> EntityList | None:
    values = [value for arg in node.args for value in [constants_in(arg)]] if node.name != "sort" else []
    words = [value[0] if len(value) == 1 else "" for value in values]
    match node.name, words[:2]:
        case name, _ if name in _SAME:
            return known
        case "selectattr" | "select", ["state" | "is_state", *_]:
            tested = values[1:] if words[0] == "is_state" else values[2:] if _is_test(words[1:2], {"in"}) else []
            return known._replace(states=tuple(map(str, tested[0]))) if tested else None
        case "rejectattr" | "selectattr", ["state", "in" | "eq" | "ne" | "==" | "!="] if {
            *map(str, values[2])
        } <= UNKNOWN:
            return known
        case "rejectattr" | "reject", ["state" | "is_state", *_]:
            denied = values[1:] if words[0] == "is_state" else values[2:] if _is_test(words[1:2], set()) else []
            others = {"on": "off", "off": "on"}
            state = others.get(str(denied[0][0]), "") if denied else ""
            return known._replace(states=(state,)) if state else None
        case "selectattr", ["attributes.device_class", "defined"]:
            return known
        case "selectattr", ["attributes.device_class", test] if _is_test([test], {"in"}):
            return known._replace(classes=frozenset(map(str, values[2])))
        case "selectattr", ["entity_id", "in"]:
            return known._replace(ids=tuple(map(str, values[2])))
        case "map", []:
            attributes = {str(one.value.value) for one in node.kwargs if isinstance(one.value, nodes.Const)}
            return known._replace(is_named=attributes <= _NAME) if attributes <= _NAME | {"entity_id"} else None
        case "map", ["state_attr", "friendly_name"]:
            return known._replace(is_named=True)
    return None


def _is_test(words: Sequence[object], others: set[str]) -> bool:
    return bool(words) and words[0] in _EQUAL | others


def counted_list(node: nodes.Node | None) -> EntityList | None:
    """Return the entities whose number *node* is; None for another expression."""
    while isinstance(node, nodes.Filter) and node.name == "int":
        node = node.node
    if not isinstance(node, nodes.Filter) or node.name not in {"count", "length"}:
        return None
    return entity_list(node.node)


def list_of_loop(node: nodes.For) -> tuple[EntityList, bool]:
    """Return the entities that a loop in a message names, and whether it tells their states too.

    Raises:
        NotCarriedError: It does something else.
    """
    known, name = entity_list(node.iter), getattr(node.target, "name", "")
    body = node.body
    tests = [node.test] if node.test is not None else []
    inner = [part for part in body if not _is_space(part)]
    if len(inner) == 1 and isinstance(inner[0], nodes.If) and not inner[0].else_ and not inner[0].elif_:
        tests, body = [*tests, inner[0].test], inner[0].body
    for test in tests:
        known = None if known is None else _tested(known, test, name)
    values = {
        path for part in body for inner in part.find_all(nodes.Getattr) if (path := path_of(inner))[:1] == (name,)
    }
    names = {(name, "name"), (name, "attributes", "friendly_name"), (name, "attributes")}
    others = [part for part in body if not isinstance(part, nodes.Output | nodes.If)]
    if known is None or others or not values & names or values - names - {(name, "state")}:
        raise refused_template(shown_tree(node.iter), "a list in a message has the names of entities in a state")
    return known, (name, "state") in values


def _is_space(node: nodes.Node) -> bool:
    return isinstance(node, nodes.Output) and all(
        isinstance(part, nodes.TemplateData) and not part.data.strip() for part in node.nodes
    )


def _tested(known: EntityList, node: nodes.Node, name: str) -> EntityList | None:
    """Return those of *known* for which the test *node* of a loop over *name* holds; None for another test."""
    match node:
        case nodes.And(left=left, right=right):
            first = _tested(known, left, name)
            return None if first is None else _tested(first, right, name)
        case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=right)]):
            is_number = False
            while isinstance(left, nodes.Filter) and left.name in {"float", "int"} and left.node is not None:
                left, is_number = left.node, True
            path = path_of(left)
            if path == (name, "state") and is_number and sign in SIGNS:
                return known._replace(limit=(SIGNS[sign], constant_number(right)))
            if path == (name, "state") and sign in {"eq", "in"}:
                return known._replace(states=tuple(map(str, constants_in(right))))
            if path == (name, "state") and sign in {"ne", "notin"} and {*map(str, constants_in(right))} <= UNKNOWN:
                return known
            if path == (name, "attributes", "device_class") and sign in {"eq", "in"}:
                return known._replace(classes=frozenset(map(str, constants_in(right))))
        case nodes.Test(name="defined"):
            return known
        case nodes.Call(node=nodes.Name(name="is_state"), args=[entity, nodes.Const(value=str(state))]) if path_of(
            entity
        ) in {(name, "entity_id"), (name,)}:
            return known._replace(states=(state,))
    return None


def names_text(automation: Automation, known: EntityList, *, with_states: bool = False) -> str:
    """Return the value of a message with the names of the entities of *known*."""
    automation.notes.append("a list of names is written with commas, and `none` without any")
    texts = [*dict.fromkeys(known.texts(automation))]
    of_class = [*filter(None, map(capability_of_class, known.classes))]
    query = texts[0] if len(texts) == 1 else f"({' or '.join(texts)})"
    if not with_states:
        return f"{{names of {query}}}"
    ids = automation.entities.expanded(known.ids)
    entities = [*map(automation.entities.find, ids)] or automation.entities.of_class(known.domain, known.classes)
    capabilities = {*of_class} or {entity.capability for entity in entities}
    if len(capabilities) != 1 or "" in capabilities:
        raise NotCarriedError("template: a list of entities with their states, which are of several kinds")
    return f"{{names with {capabilities.pop().replace('_', ' ')} of {query}}}"
