"""Lists of entities in the templates of automations: how many are in a state, and their names. Pure.

Source: Jinja 3.1 documentation, List of Builtin Filters; Home Assistant core 2026.11, ``helpers/template``.
"""

from collections.abc import Callable, Mapping, Sequence
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

_NAME: Final = frozenset({"name", "attributes.friendly_name"})


class EntityList(NamedTuple):
    """Entities in a state; those of a list that are in no such state are left out.

    Attributes:
        ids: Their ids; without any, all of *domain*.
        classes: The classes of devices that count; empty for all.
        states: The states that count; empty for any.
        limit: A limit of their number.
        is_named: Whether it is the list of their names.
        with_states: Whether the states stand beside the names.
    """

    ids: tuple[str, ...] = ()
    domain: str = ""
    classes: frozenset[str] = frozenset()
    states: tuple[str, ...] = ()
    limit: tuple[Operator, float] | None = None
    is_named: bool = False
    with_states: bool = False

    def texts(self, automation: Automation) -> list[str]:
        """Return for each entity that it is so.

        Raises:
            NotCarriedError: It asks for no state, or homebot knows none of the entities.
        """
        if not self.ids and (of_class := self._of_classes()):
            return of_class
        entities = self.entities(automation)
        if not self.ids:
            automation.notes.append(f"states.{self.domain} means the devices that homebot knows now")
        if not entities or not (self.states or self.limit):
            raise NotCarriedError(f"template: no state of entities of {self.domain or 'the list'} that homebot knows")
        return [text for entity in entities for text in self._of(entity)]

    def entities(self, automation: Automation) -> list[KnownEntity]:
        """Return those that homebot knows now, in any state."""
        ids = automation.entities.expanded(self.ids)
        return [*map(automation.entities.find, ids)] or automation.entities.of_class(self.domain, self.classes)

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
            return _together([_group(arg) or entity_list(arg) for arg in args])
        case nodes.Const(value=str(entity)) if "." in entity and not entity.startswith("group."):
            return EntityList((entity,))
        case nodes.List() | nodes.Tuple():
            return _together([*map(entity_list, node.items)])
        case nodes.For():
            return list_of_loop(node)
        case nodes.Filter(node=inner) if (known := entity_list(inner)) is not None:
            return _filtered(known, node)
    return None


def _group(node: nodes.Node) -> EntityList | None:
    """Return the members of the group that *node* names, as ``expand`` takes them; None for another expression."""
    match node:
        case nodes.Const(value=str(entity)) if entity.startswith("group."):
            return EntityList((entity,))
    return None


def _together(lists: Sequence[EntityList | None]) -> EntityList | None:
    """Return the entities of all *lists*; None if one of them is none, or has no ids."""
    ids = [known.ids for known in lists if known is not None and known.ids]
    return EntityList(sum(ids, ())) if lists and len(ids) == len(lists) else None


def _filtered(known: EntityList, node: nodes.Filter) -> EntityList | None:
    """Return *known* after a filter; None for one that a list of homebot has no counterpart for."""
    if node.name in _SAME:
        return known
    if node.name == "map" and not node.args:
        attributes = {str(one.value.value) for one in node.kwargs if isinstance(one.value, nodes.Const)}
        return known._replace(is_named=attributes <= _NAME) if attributes <= _NAME | {"entity_id"} else None
    values = [[*map(str, constants_in(arg))] for arg in node.args]
    words = [*(value[0] for value in values if value), ""]
    chosen = _FILTERS.get((node.name, words[0]))
    return None if chosen is None else chosen(known, words[1], values[-1])


def _by_state(known: EntityList, test: str, states: Sequence[str]) -> EntityList | None:
    """Return those in one of *states*, or in any other state than unknown ones."""
    if test in _IN:
        return known._replace(states=tuple(states))
    return known if test in _NOT_IN and {*states} <= UNKNOWN else None


def _but_by_state(known: EntityList, test: str, states: Sequence[str]) -> EntityList | None:
    """Return those in none of *states*, which are unknown ones, or one of two."""
    if test not in _IN:
        return None
    others = {"on": "off", "off": "on"}
    return known if {*states} <= UNKNOWN else _by_state(known, "eq", [others[states[0]]]) if _is_flag(states) else None


def _by_class(known: EntityList, test: str, classes: Sequence[str]) -> EntityList | None:
    if test == "defined":
        return known
    return known._replace(classes=frozenset(classes)) if test in _IN else None


def _is_flag(states: Sequence[str]) -> bool:
    return [*states] in (["on"], ["off"])


_IN: Final = frozenset({"eq", "==", "equalto", "in"})
_NOT_IN: Final = frozenset({"ne", "!=", "notin"})
_FILTERS: Final[Mapping[tuple[str, str], Callable[[EntityList, str, Sequence[str]], EntityList | None]]] = {
    ("selectattr", "state"): _by_state,
    ("select", "is_state"): lambda known, _, states: _by_state(known, "eq", states),
    ("rejectattr", "state"): _but_by_state,
    ("reject", "is_state"): lambda known, _, states: _but_by_state(known, "eq", states),
    ("selectattr", "attributes.device_class"): _by_class,
    ("selectattr", "entity_id"): lambda known, test, ids: known._replace(ids=tuple(ids)) if test == "in" else None,
    ("map", "state_attr"): lambda known, test, _: known._replace(is_named=True) if test == "friendly_name" else None,
}
"""By its name and first word what a filter leaves of a list, by its test and the values of that."""


def counted_list(node: nodes.Node | None) -> EntityList | None:
    """Return the entities whose number *node* is; None for another expression."""
    while isinstance(node, nodes.Filter) and node.name == "int":
        node = node.node
    if not isinstance(node, nodes.Filter) or node.name not in {"count", "length"}:
        return None
    return entity_list(node.node)


def list_of_loop(node: nodes.For) -> EntityList:
    """Return the entities that a loop names, or counts.

    Raises:
        NotCarriedError: It does something else.
    """
    known, name = entity_list(node.iter), getattr(node.target, "name", "")
    tests, body = _tests_of(node)
    for test in tests:
        known = None if known is None else _tested(known, test, name)
    if known is not None and known.is_named and not tests and _names_in(body) == {(name,)}:
        return known  # each name once more
    values = _names_in(body)
    names = {(name, "name"), (name, "attributes", "friendly_name"), (name, "entity_id")}
    others = [part for part in body if not isinstance(part, nodes.Output | nodes.If)]
    if known is None or others or not values & names or values - names - {(name, "state")}:
        raise refused_template(shown_tree(node.iter), "a list in a message has the names of entities in a state")
    return known._replace(is_named=True, with_states=(name, "state") in values)


def _names_in(body: Sequence[nodes.Node]) -> set[tuple[str, ...]]:
    """Return the names in *body*, with their fields, such as ``s.attributes.friendly_name``."""
    if not body:
        return set()
    whole: set[tuple[str, ...]] = set()
    for part in body:
        if path := path_of(part):
            whole.add(path)
        else:
            whole |= _names_in([*part.iter_child_nodes()])
    return whole


def _tests_of(node: nodes.For) -> tuple[list[nodes.Node], Sequence[nodes.Node]]:
    """Return the conditions of a loop, also of the only `if` in it, and the text that it writes then."""
    tests = [node.test] if node.test is not None else []
    match [part for part in node.body if not _is_space(part)]:
        case [nodes.If(else_=[], elif_=[]) as choice]:
            return [*tests, choice.test], choice.body
    return [*tests], node.body


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
            chosen = _FIELDS.get(path[1:]) if path[:1] == (name,) and not is_number else None
            return None if chosen is None else chosen(known, sign, [*map(str, constants_in(right))])
        case nodes.Test(name="defined") | nodes.Call(node=nodes.Name(name="is_number" | "has_value"), args=[_]):
            return known
        case nodes.Call(node=nodes.Name(name="is_state"), args=[entity, nodes.Const(value=str(state))]) if path_of(
            entity
        ) in {(name, "entity_id"), (name,)}:
            return known._replace(states=(state,))
    return None


_FIELDS: Final = {("state",): _by_state, ("attributes", "device_class"): _by_class}
"""The elements that a comparison in a loop leaves of a list, by the comparison."""


def any_of_queries(texts: Sequence[str]) -> str:
    """Return the query that one of *texts* fits."""
    return texts[0] if len(texts) == 1 else f"({' or '.join(texts)})"


def count_text(automation: Automation, known: EntityList) -> str:
    """Return the number of the entities of *known*, of which each is a device of its own."""
    if known == EntityList(domain="light", states=("on",)):
        return "count of light on"
    devices = [entity.device.id for entity in known.entities(automation)]
    if len({*devices}) < len(devices):
        raise NotCarriedError("template: several of the entities that it counts are one device")
    return f"count of {any_of_queries([*dict.fromkeys(known.texts(automation))])}"


def names_text(automation: Automation, known: EntityList) -> str:
    """Return the value of a message with the names of the entities of *known*."""
    automation.notes.append("a list of names is written with commas, and `none` without any")
    texts = [*dict.fromkeys(known.texts(automation))]
    query = any_of_queries(texts)
    if not known.with_states:
        return f"{{names of {query}}}"
    of_class = {*filter(None, map(capability_of_class, known.classes))}
    capabilities = of_class or {entity.capability for entity in known.entities(automation)}
    if len(capabilities) != 1 or "" in capabilities:
        raise NotCarriedError("template: a list of entities with their states, which are of several kinds")
    return f"{{names with {capabilities.pop().replace('_', ' ')} of {query}}}"
