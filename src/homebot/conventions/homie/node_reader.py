"""Reader of the nodes and properties of a Homie device. Pure.

Unknown fields are ignored; an invalid field invalidates its property or its node.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TypeVar

from homebot.conventions.homie.model import MAX_PROPERTIES, HomieNode, HomieProperty, make_property
from homebot.conventions.payload import clean_text, shown
from homebot.errors import WireError

__all__ = ["LONGEST_TYPE", "NodeReader", "optional"]

T = TypeVar("T")

LONGEST_TYPE = 200
"""Most characters of the type of a device or a node."""


class NodeReader:
    """Reader of the nodes of a device, in the form that a document of version 5 has.

    Args:
        topic: The topic of the device.
        ids: The pattern of valid ids.
        names_form: See :class:`homebot.conventions.homie.model.HomieProperty`.

    Attributes:
        ignored: Number of invalid nodes and properties.
    """

    def __init__(self, topic: str, ids: re.Pattern[str], *, names_form: bool = True) -> None:
        self.ignored = 0
        self._topic = topic
        self._ids = ids
        self._names_form = names_form
        self._count = 0

    def nodes(self, fields: Mapping[str, object]) -> tuple[HomieNode, ...]:
        """Return the valid nodes of *fields*, by id."""
        found = []
        for node_id, node in fields.items():
            if self._count >= MAX_PROPERTIES:
                self.ignored += 1
                continue
            try:
                found.append(self._node(node_id, node))
            except WireError:
                self.ignored += 1
        return tuple(found)

    def _node(self, node_id: str, fields: object) -> HomieNode:
        name = self._legal_id(node_id)
        if not isinstance(fields, dict):
            raise WireError(f"node {shown(name)} is {shown(fields)}, not an object")
        return HomieNode(
            id=name,
            name=clean_text(optional(fields, "name", str) or ""),
            type=clean_text(optional(fields, "type", str) or "", LONGEST_TYPE),
            properties=self._properties(name, optional(fields, "properties", dict) or {}),
        )

    def _properties(self, node_id: str, fields: Mapping[str, object]) -> tuple[HomieProperty, ...]:
        found = []
        for prop_id, prop in fields.items():
            try:
                if self._count >= MAX_PROPERTIES:
                    raise WireError(f"more than {MAX_PROPERTIES} properties")  # noqa: TRY301 - as any other flaw
                found.append(self._property(node_id, prop_id, prop))
            except WireError:
                self.ignored += 1
            else:
                self._count += 1
        return tuple(found)

    def _property(self, node_id: str, prop_id: str, fields: object) -> HomieProperty:
        name = self._legal_id(prop_id)
        if not isinstance(fields, dict):
            raise WireError(f"property {shown(name)} is {shown(fields)}, not an object")
        return make_property(
            lambda key: optional(fields, key, str) or "",
            prop_id=name,
            topic=f"{self._topic}/{node_id}/{name}",
            is_settable=optional(fields, "settable", bool) or False,
            is_retained=optional(fields, "retained", bool) is not False,
            names_form=self._names_form,
        )

    def _legal_id(self, value: str) -> str:
        if self._ids.fullmatch(value):
            return value
        raise WireError(f"{shown(value)} is not a valid id")


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
    raise WireError(f"{name} is {shown(value)}, not a {kind.__name__}")
