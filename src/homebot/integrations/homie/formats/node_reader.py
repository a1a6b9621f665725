"""Reader of a Homie device, its nodes and its properties, in the form that a document of version 5 has. Pure.

Unknown fields are ignored; an invalid field invalidates its property, its node or the whole device.

Source: Homie convention 5, Device Attributes ($description), Nodes, Properties.
"""

import re
from collections.abc import Mapping
from typing import TypeVar

from homebot.conventions.payload import clean_text, shown
from homebot.errors import WireError
from homebot.integrations.homie.formats.model import (
    COLOR_FORMS,
    MAX_PROPERTIES,
    HomieDevice,
    HomieNode,
    HomieProperty,
    Range,
    parse_options,
    parse_range,
)

T = TypeVar("T")

_MAX_TYPE_CHARACTERS = 200
_MAX_UNIT_CHARACTERS = 20
_DATATYPES = frozenset({"integer", "float", "boolean", "string", "enum", "color", "datetime", "duration", "json"})
"""Every datatype of versions 3 to 5."""

_WITH_OPTIONS = frozenset({"enum", "color"})
_LOOKALIKES = str.maketrans("ºμ", "°µ")
"""Characters of units by others of the same look, as the examples of homie-esp8266 write ``ºC``."""

_FLAGS = (
    ("", "off", "on"),
    ("relay", "open", "closed"),
    ("contact", "closed", "open"),
    ("valve", "closed", "open"),
)
"""Enums that are booleans: the id, empty for any, and the options for false and true.

Source: homie4 0.2 (PyPI), ``Property_Switch`` and ``Property_Contact``; eBus 0.3, capability switch (SPAN panels).
"""


def read_device(
    fields: Mapping[str, object],
    device_id: str,
    topic: str,
    ids: re.Pattern[str],
    *,
    root: str = "",
    facts: Mapping[str, str],
    names_form: bool = True,
) -> HomieDevice:
    """Return the device with these *fields*, and the number of its invalid nodes and properties.

    Args:
        ids: The pattern of valid ids of nodes and properties.
        names_form: See :class:`homebot.integrations.homie.formats.model.HomieProperty`.

    Raises:
        WireError: A field of the device itself is illegal.
    """
    reader = _NodeReader(topic, ids, names_form=names_form)
    nodes = reader.nodes(optional(fields, "nodes", dict) or {})
    return HomieDevice(
        id=device_id,
        name=clean_text(optional(fields, "name", str) or "") or device_id,
        type=(optional(fields, "type", str) or "")[:_MAX_TYPE_CHARACTERS],
        topic=topic,
        nodes=nodes,
        root=root,
        facts=facts,
        ignored=reader.ignored,
    )


class _NodeReader:
    def __init__(self, topic: str, ids: re.Pattern[str], *, names_form: bool) -> None:
        self.ignored = 0
        self._topic = topic
        self._ids = ids
        self._names_form = names_form
        self._count = 0

    def nodes(self, fields: Mapping[str, object]) -> tuple[HomieNode, ...]:
        nodes = []
        for node_id, node in fields.items():
            try:
                self._check_count()
                nodes.append(self._node(node_id, node))
            except WireError:
                self.ignored += 1
        return tuple(nodes)

    def _node(self, node_id: str, node: object) -> HomieNode:
        fields = self._fields(node_id, node)
        return HomieNode(
            id=node_id,
            name=clean_text(optional(fields, "name", str) or ""),
            type=clean_text(optional(fields, "type", str) or "", _MAX_TYPE_CHARACTERS),
            properties=self._properties(node_id, optional(fields, "properties", dict) or {}),
        )

    def _properties(self, node_id: str, fields: Mapping[str, object]) -> tuple[HomieProperty, ...]:
        properties = []
        for prop_id, prop in fields.items():
            try:
                self._check_count()
                properties.append(self._property(f"{self._topic}/{node_id}/{prop_id}", prop_id, prop))
            except WireError:
                self.ignored += 1
            else:
                self._count += 1
        return tuple(properties)

    def _property(self, topic: str, prop_id: str, prop: object) -> HomieProperty:
        fields = self._fields(prop_id, prop)
        name, datatype, form, unit = (
            optional(fields, field, str) or "" for field in ("name", "datatype", "format", "unit")
        )
        if datatype not in _DATATYPES:
            raise WireError(f"datatype is {shown(datatype)}")
        options = _read_options(datatype, form)
        flags = _flags(prop_id, options) if datatype == "enum" else None
        if flags:
            datatype = "boolean"
        return HomieProperty(
            id=prop_id,
            name=clean_text(name),
            datatype=datatype,
            topic=topic,
            unit=clean_text(unit, _MAX_UNIT_CHARACTERS).translate(_LOOKALIKES),
            range=parse_range(form) if datatype in {"integer", "float"} else Range(),
            options=options if datatype in _WITH_OPTIONS else (),
            is_settable=optional(fields, "settable", bool) or False,
            is_retained=optional(fields, "retained", bool) is not False,
            names_form=self._names_form,
            flags=flags or ("false", "true"),
        )

    def _check_count(self) -> None:
        if self._count >= MAX_PROPERTIES:
            raise WireError(f"more than {MAX_PROPERTIES} properties")

    def _fields(self, name: str, value: object) -> Mapping[str, object]:
        """Return the fields of the node or property *name*."""
        if not self._ids.fullmatch(name):
            raise WireError(f"{shown(name)} is not a valid id")
        if not isinstance(value, dict):
            raise WireError(f"{shown(name)} is {shown(value)}, not an object")
        return value


def _read_options(datatype: str, form: str) -> tuple[str, ...]:
    """Return the options of an enum, the forms of a colour, or the names of false and true; empty for any other."""
    if datatype not in _WITH_OPTIONS and not (datatype == "boolean" and form):
        return ()
    options = parse_options(form)
    if datatype == "color" and not set(options) <= set(COLOR_FORMS):
        raise WireError(f"format {shown(form)} names no colour formats")
    if datatype == "boolean" and len(options) != len(("false", "true")):
        raise WireError(f"format {shown(form)} does not name false and true")
    return options


def _flags(prop_id: str, options: tuple[str, ...]) -> tuple[str, str] | None:
    """Return the options for false and true of an enum that is a boolean; None for any other enum."""
    spelled = {option.casefold(): option for option in options}
    for only_id, false, true in _FLAGS:
        if only_id in {"", prop_id} and {false, true} <= spelled.keys() <= {false, true, "unknown"}:
            return spelled[false], spelled[true]
    return None


def optional(fields: Mapping[str, object], name: str, kind: type[T]) -> T | None:
    """Return a field; None if it is missing.

    Raises:
        WireError: It is of another type. A boolean is no number.
    """
    if name not in fields:
        return None
    value = fields[name]
    if isinstance(value, kind) and (kind is bool or not isinstance(value, bool)):
        return value
    raise WireError(f"{name} is {shown(value)}, not {_KINDS[kind]}")


_KINDS: Mapping[type[object], str] = {
    bool: "true or false",
    dict: "an object",
    int: "a whole number",
    list: "a list",
    str: "a text",
}
