"""Lists of entities in the templates of automations: how many are in a state, and their names. Pure.

Source: Jinja 3.1 documentation, List of Builtin Filters; Home Assistant core 2026.11, ``helpers/template``.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple, TypeAlias

from homebot.devices.query.terms import Operator
from homebot.integrations.homeassistant.automations.entities import (
    Automation,
    KnownEntity,
    capability_of_class,
    slug_of,
)
from homebot.integrations.homeassistant.automations.expressions import (
    constant_number,
    constants_in,
    is_space,
    path_of,
    refused_template,
    shown_tree,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.automations.states import UNKNOWN, limits_text, state_text
from homebot.integrations.homeassistant.automations.template_numbers import SIGNS, holds, whole_limit
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes

_SAME: Final = frozenset({"list", "sort", "unique", "expand"})
"""Filters after which a list has the same entities."""

_AT_HOME: Final = {"home": "true", "not_home": "false"}
_NAME: Final = frozenset({"name", "attributes.friendly_name"})

_PLACES: Final = {f"{place}_entities": f"{place}_id" for place in ("area", "device", "floor", "label")}
"""The fields of a target with the places of the entities that these functions list."""

_OF_DOMAIN: Final = re.compile(r"\^?([a-z_]+)(?:\\?\.)?(?:\.\*)?")
"""A pattern that the ids of a domain match."""


class EntityList(NamedTuple):
    """Entities in a state; those of a list that are in no such state are left out.

    Attributes:
        ids: Their ids; without any, all of *domain*.
        domain: Their domain; empty for any.
        place: The field of a target and the place in it where they are; empty for anywhere.
        classes: The classes of devices that count; empty for all.
        but: The ids that do not count.
        states: The states that count; empty for any.
        limit: A limit of their number.
        is_known: Whether unknown states are left out.
        told: What is listed of each: ``name`` or ``state``; empty for the entity or its id.
        number: The filter that made a number of each state, and the number that counts while that is unknown.
        with_states: Whether the states stand beside the names.
    """

    ids: tuple[str, ...] = ()
    domain: str = ""
    place: tuple[str, str] = ("", "")
    classes: frozenset[str] = frozenset()
    but: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    limit: tuple[Operator, float] | None = None
    is_known: bool = False
    told: str = ""
    number: tuple[str, float | None] = ("", None)
    with_states: bool = False

    @property
    def is_at_home(self) -> bool:
        """True for persons, or groups of these, at home."""
        are_groups = self.ids and all(entity.startswith("group.") for entity in self.ids)
        return self.states == ("home",) and (self.domain == "person" or bool(are_groups))

    def texts(self, automation: Automation) -> list[str]:
        """Return for each entity that it is so.

        Raises:
            NotCarriedError: It asks for no state, or homebot knows none of the entities.
        """
        if not self.ids and not any(self.place) and (of_all := self._of_all(automation)):
            return of_all
        entities = self.entities(automation)
        if not self.ids:
            if any(self.place) and not self.domain:
                raise NotCarriedError("template: entities of a place; write `selectattr('domain', 'eq', 'light')`")
            named = " ".join(self.place).strip() or f"states.{self.domain}"
            automation.notes.append(f"{named} means the devices that homebot knows now")
        if not entities or not (self.states or self.limit):
            raise NotCarriedError(f"template: no state of entities of {self.domain or 'the list'} that homebot knows")
        return [text for entity in entities for text in self._of(entity)]

    def entities(self, automation: Automation) -> list[KnownEntity]:
        """Return those that homebot knows now, in any state."""
        known = automation.entities
        if self.ids or not any(self.place):
            found = [*map(known.find, known.expanded(self.ids))] or known.of_class(self.domain, self.classes)
        else:
            found = known.of_target((self.domain,), *self.place)
        if self.domain == "person":  # a phone without an entity is none
            persons = [entity for entity in found if entity.part.part.service_type == "x_person"]
            found = persons or [entity for entity in found if entity.id in automation.entities.used]
        others = [(entity.device.id, entity.part.id) for entity in map(known.find, self.but)]
        return [entity for entity in found if (entity.device.id, entity.part.id) not in others]

    def _of_all(self, automation: Automation) -> list[str]:
        """Return the states of any light, or device of the classes, also of later ones; none if only some count."""
        flags, limit = {"on": "true", "off": "false"}, self.limit
        others = [f" not {entity.query}" for entity in map(automation.entities.find, self.but)]
        if self.domain == "light" and not limit and not self.classes and {*self.states} <= flags.keys():
            return [f"light {state}{''.join(others)}" for state in self.states]
        known = [capability_of_class(name) for name in self.classes]
        if self.domain not in {"sensor", "binary_sensor"} or not known or "" in known:
            return []
        if limit is not None:
            return [f"{name}{limit[0]}{limit[1]:.12g}{''.join(others)}" for name in known]
        return [f"{name}={flags[state]}{''.join(others)}" for name in known for state in self.states if state in flags]

    def limited(self, sign: str, limit: float) -> "EntityList | None":
        """Return those with a number on the side *sign* of *limit*; None if unknown ones count as well."""
        kind, default = self.number
        if sign not in SIGNS or self.limit is not None:
            return None
        if default is not None and not self.is_known and holds(default, SIGNS[sign], limit):
            return None
        return self._replace(limit=whole_limit(SIGNS[sign], limit) if kind == "int" else (SIGNS[sign], limit))

    def _of(self, entity: KnownEntity) -> list[str]:
        if self.limit is not None:
            return [limits_text(entity, entity.capability, [self.limit])]
        if entity.part.part.service_type == "x_person" and {*self.states} <= _AT_HOME.keys():
            return [f"{entity.query} at_home={_AT_HOME[state]}" for state in self.states]
        return [state_text(entity, state, "state") for state in self.states]


def entity_list(node: nodes.Node | None) -> EntityList | None:
    """Return the entities that *node* lists; None for another expression."""
    match node:
        case nodes.Name(name="states"):
            return EntityList()
        case nodes.Getattr() if len(path := path_of(node)) == 2 and path[0] == "states":
            return EntityList(domain=path[1])
        case nodes.Call(node=nodes.Name(name="expand"), args=args):
            return _together([_group(arg) or entity_list(arg) for arg in args])
        case nodes.Call(node=nodes.Name(name=name), args=[nodes.Const(value=str(place))]) if name in _PLACES:
            return EntityList(place=(_PLACES[name], place if name == "device_entities" else slug_of(place)))
        case nodes.Const(value=str(entity)) if "." in entity and not entity.startswith("group."):
            return EntityList((entity,))
        case nodes.Const(value=list() as values):
            return _together([*map(entity_list, map(nodes.Const, values))])
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
    """Return the only one of *lists*, or the entities of all; None if one of them is none, or has no ids."""
    ids = [known.ids for known in lists if known is not None and known.ids]
    if len(lists) == 1:
        return lists[0]
    return EntityList(sum(ids, ())) if lists and len(ids) == len(lists) else None


def _filtered(known: EntityList, node: nodes.Filter) -> EntityList | None:
    """Return *known* after a filter; None for one that a list of homebot has no counterpart for."""
    if node.name in _SAME:
        return None if node.name == "unique" and known.told == "state" else known
    if node.name == "map" and not node.args:
        return _with_attribute(known, node)
    values = [[*constants_in(arg)] for arg in node.args]
    word, *rest = [str(value[0]) for value in values if value] or [""]
    if known.told in {"state", "number"} and node.name in {"select", "reject"}:
        return _of_values(known, node.name == "reject", word, values[-1] if rest else [])
    if known.told == "state":
        if node.name != "map" or word not in {"float", "int"}:
            return None
        default = constant_number(node.args[1]) if len(node.args) > 1 else None
        return known._replace(told="number", number=(word, default))
    chosen = _FILTERS.get((node.name, word))
    test = word if node.name in {"select", "reject"} else (*rest, "")[0]
    return None if chosen is None else chosen(known, test, [*map(str, values[-1])])


def _with_attribute(known: EntityList, node: nodes.Filter) -> EntityList | None:
    """Return the names, states or ids of *known*; None for another attribute."""
    attributes = {str(one.value.value) for one in node.kwargs if isinstance(one.value, nodes.Const)}
    told = "state" if attributes == {"state"} else "name" if attributes <= _NAME else ""
    return known._replace(told=told) if told or attributes == {"entity_id"} else None


def _of_values(known: EntityList, is_denied: bool, test: str, values: Sequence[object]) -> EntityList | None:  # noqa: FBT001
    """Return those of *known* with states, or numbers, that pass a test."""
    if known.told == "state":
        return (_but_by_state if is_denied else _by_state)(known, test, [*map(str, values)])
    sign = _SIGN_WORDS.get(test, test)
    sign = NEGATED.get(sign, "") if is_denied else sign
    return known.limited(sign, float(str(values[0]))) if values else None


def _by_state(known: EntityList, test: str, states: Sequence[str]) -> EntityList | None:
    """Return those in one of *states*, or in any other state than unknown ones."""
    if test in _KNOWN:
        return known._replace(is_known=True)
    if test in _IN and not known.states:
        return known._replace(states=tuple(states))
    return known._replace(is_known=True) if test in _NOT_IN and {*states} <= UNKNOWN else None


def _but_by_state(known: EntityList, test: str, states: Sequence[str]) -> EntityList | None:
    """Return those in none of *states*, which are unknown ones, or one of two."""
    if test not in _IN:
        return None
    if {*states} <= UNKNOWN:
        return known._replace(is_known=True)
    others = {"on": "off", "off": "on"}
    return _by_state(known, "eq", [others[states[0]]]) if len(states) == 1 and states[0] in others else None


def _by_class(known: EntityList, test: str, classes: Sequence[str]) -> EntityList | None:
    if test == "defined":
        return known
    return known._replace(classes=frozenset(classes)) if test in _IN else None


def _by_domain(known: EntityList, test: str, domains: Sequence[str]) -> EntityList | None:
    """Return those of the only one of *domains*."""
    if test not in _IN or len(domains) != 1 or known.domain not in {"", *domains}:
        return None
    ids = tuple(one for one in known.ids if one.partition(".")[0] == domains[0])
    return known._replace(domain=domains[0], ids=ids) if ids or not known.ids else None


def _by_id(known: EntityList, test: str, ids: Sequence[str]) -> EntityList | None:
    """Return those with one of *ids*, or with another one."""
    if test in _IN:
        return known._replace(ids=tuple(ids)) if not known.ids else None
    return known._replace(but=(*known.but, *ids)) if test in _NOT_IN else None


def _by_pattern(known: EntityList, test: str, patterns: Sequence[str]) -> EntityList | None:
    """Return those of the domain that a pattern of ids means."""
    found = _OF_DOMAIN.fullmatch(patterns[0]) if test == "match" or patterns[0].startswith("^") else None
    return None if found is None else _by_domain(known, "eq", [found[1]])


_IN: Final = frozenset({"eq", "==", "equalto", "in"})
_NOT_IN: Final = frozenset({"ne", "!=", "notin"})
_KNOWN: Final = frozenset({"is_number", "has_value", "defined"})
_SIGN_WORDS: Final = {
    **dict.fromkeys(("<", "lessthan"), "lt"),
    **dict.fromkeys((">", "greaterthan"), "gt"),
    **dict.fromkeys(("<=", "le"), "lteq"),
    **dict.fromkeys((">=", "ge"), "gteq"),
}
_MATCH: Final = frozenset({"match", "search"})
NEGATED: Final = {"lt": "gteq", "gteq": "lt", "gt": "lteq", "lteq": "gt"}
"""The comparisons that hold if others do not."""

_Reader: TypeAlias = Callable[[EntityList, str, Sequence[str]], EntityList | None]
_FILTERS: Final[Mapping[tuple[str, str], _Reader]] = {
    ("selectattr", "state"): _by_state,
    ("select", "is_state"): lambda known, _, states: _by_state(known, "eq", states),
    ("select", "has_value"): lambda known, *_: known._replace(is_known=True),
    ("rejectattr", "state"): _but_by_state,
    ("reject", "is_state"): lambda known, _, states: _but_by_state(known, "eq", states),
    ("selectattr", "attributes.device_class"): _by_class,
    ("selectattr", "entity_id"): lambda known, test, ids: (_by_pattern if test in _MATCH else _by_id)(known, test, ids),
    ("rejectattr", "entity_id"): lambda known, test, ids: _by_id(known, "ne", ids) if test in _IN else None,
    **{("select", test): _by_pattern for test in ("match", "search")},
    ("select", "in"): _by_id,
    ("reject", "in"): lambda known, _, ids: _by_id(known, "ne", ids),
    ("selectattr", "domain"): _by_domain,
    ("map", "states"): lambda known, *_: known._replace(told="state"),
    ("map", "state_attr"): lambda known, test, _: known._replace(told="name") if test == "friendly_name" else None,
}
"""By its name and first word the rest of a list after a filter, by its test and the values of that."""


def listed_numbers(node: nodes.Node | None) -> list[nodes.Expr]:
    """Return the numbers that *node* lists, each of an entity that it names; none for another expression."""
    if isinstance(node, nodes.List):
        return node.items
    known = entity_list(node)
    if known is None or known.told != "number" or not known.ids or known.limit or known.states:
        return []
    kind, default = known.number
    given: list[nodes.Expr] = [] if default is None else [nodes.Const(default)]
    states = nodes.Name("states", "load")
    return [
        nodes.Filter(nodes.Call(states, [nodes.Const(one)], [], None, None), kind, given, [], None, None)
        for one in known.ids
    ]


def counted_list(node: nodes.Node | None) -> EntityList | None:
    """Return the entities of which *node* is the number; None for another expression."""
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
    outputs = [part for part in body if isinstance(part, nodes.Output)]
    told = {field for part in outputs for field in _told_in(part, name)} - {_UNIT}
    names = {("name",), ("attributes", "friendly_name"), ("entity_id",), ()}
    others = [part for part in body if part not in outputs and (not isinstance(part, nodes.If) or _told_in(part, name))]
    if known is not None and known.told == "name" and told == {()} and not tests:
        return known  # each name once more
    if known is None or known.told or others or not told & names or told - names - {("state",)}:
        raise refused_template(shown_tree(node.iter), "a list in a message has the names of entities in a state")
    return known._replace(told="name", with_states=("state",) in told)


def _field(node: nodes.Node, name: str) -> tuple[str, ...] | None:
    """Return the field of the entity *name* that *node* is, none for it or its id; None for another expression."""
    match node:
        case nodes.Call(node=nodes.Name(name="states"), args=[entity]) if _field(entity, name) in _ITSELF:
            return ("state",)
        case nodes.Call(node=nodes.Name(name="state_attr"), args=[entity, nodes.Const(value=str(attribute))]) if (
            _field(entity, name) in _ITSELF
        ):
            return ("attributes", attribute)
    path = path_of(node)
    return path[1:] if path[:1] == (name,) else None


_ASKED: Final = ((), ("entity_id",), ("state",))
_ITSELF: Final[tuple[tuple[str, ...], ...]] = ((), ("entity_id",))


_UNIT: Final = ("attributes", "unit_of_measurement")


def _told_in(node: nodes.Node, name: str) -> set[tuple[str, ...]]:
    """Return the fields of the entity *name* that *node* writes; one called ``?`` for other values than the round."""
    if (field := _field(node, name)) is not None:
        return {field}
    if isinstance(node, nodes.Name):
        return set() if node.name == "loop" else {("?",)}
    return {field for part in node.iter_child_nodes() for field in _told_in(part, name)}


def _tests_of(node: nodes.For) -> tuple[list[nodes.Node], Sequence[nodes.Node]]:
    """Return the conditions of a loop, also of the only `if` in it, and the text that it writes then."""
    tests = [node.test] if node.test is not None else []
    match [part for part in node.body if not is_space(part)]:
        case [nodes.If(else_=[], elif_=[]) as choice]:
            return [*tests, choice.test], choice.body
    return [*tests], node.body


def _tested(known: EntityList, node: nodes.Node, name: str) -> EntityList | None:
    """Return those of *known* for which the test *node* of a loop over *name* holds; None for another test."""
    match node:
        case nodes.And(left=left, right=right):
            first = _tested(known, left, name)
            return None if first is None else _tested(first, right, name)
        case nodes.Compare(expr=left, ops=[nodes.Operand(op=sign, expr=right)]):
            return _compared(known, left, sign, right, name)
        case nodes.Test(name="defined", node=inner) if _field(inner, name) is not None:
            return known
        case nodes.Call(node=nodes.Name(name="is_number" | "has_value"), args=[inner]) if _field(inner, name) in _ASKED:
            return known._replace(is_known=True)
        case nodes.Call(node=nodes.Name(name="is_state"), args=[entity, nodes.Const(value=str(state))]) if (
            _field(entity, name) in _ITSELF
        ):
            return _by_state(known, "eq", [state])
    return None


def _compared(known: EntityList, left: nodes.Expr, sign: str, right: nodes.Expr, name: str) -> EntityList | None:
    """Return those of *known* of which a field, or the number of the state, is so compared with a constant."""
    kind, default = "", None
    while isinstance(left, nodes.Filter) and left.name in {"float", "int"} and left.node is not None:
        default = constant_number(left.args[0]) if left.args else default
        kind, left = left.name, left.node
    field = _field(left, name)
    if kind and field == ("state",):
        return known._replace(number=(kind, default)).limited(sign, constant_number(right))
    chosen = _FIELDS.get(field or ()) if not kind else None
    return None if chosen is None else chosen(known, sign, [*map(str, constants_in(right))])


_FIELDS: Final[Mapping[tuple[str, ...], _Reader]] = {
    ("state",): _by_state,
    ("attributes", "device_class"): _by_class,
    ("entity_id",): _by_id,
    ("domain",): _by_domain,
}
"""The elements that a comparison in a loop leaves of a list, by the field that it compares."""


def any_of_queries(texts: Sequence[str]) -> str:
    """Return the query that one of *texts* fits."""
    return texts[0] if len(texts) == 1 else f"({' or '.join(texts)})"


def count_text(automation: Automation, known: EntityList) -> str:
    """Return the number of the entities of *known*, of which each is a device of its own."""
    texts = [*dict.fromkeys(known.texts(automation))]
    devices = [entity.device.id for entity in known.entities(automation)] if texts[0][:6] != "light " else []
    if len({*devices}) < len(devices):
        raise NotCarriedError("template: several of the entities that it counts are one device")
    return f"count of {any_of_queries(texts)}"


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
