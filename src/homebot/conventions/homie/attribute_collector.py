"""Nodes and properties of Homie 4 and 3, put together from single attributes. Pure.

Source: Homie 4.0 and 3.0.1, Node and Property Attributes; arrays: 3.0.1, Arrays.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from homebot.conventions.homie.formats import COLOR_FORMS, DATATYPES, Range, parse_options, parse_range
from homebot.conventions.homie.model import MAX_PROPERTIES, HomieNode, HomieProperty
from homebot.conventions.payload import clean_text, shown
from homebot.errors import WireError

__all__ = ["AttributeCollector"]

_MAX_ARRAY = 100
_LISTED = re.compile(r"[A-Za-z0-9_-]{1,100}(?:\[\])?")
_ARRAY = re.compile(r"([0-9]{1,5})-([0-9]{1,5})")


class AttributeCollector:
    """The nodes of one device, as its attributes have them.

    Args:
        topic: What the device's topics begin with.
        attributes: By topic below that.

    Attributes:
        ignored: Properties that were illegal.
    """

    def __init__(self, topic: str, attributes: Mapping[str, str]) -> None:
        self.ignored = 0
        self._topic = topic
        self._attributes = attributes
        self._count = 0

    def nodes(self) -> tuple[HomieNode, ...] | None:
        """Return the nodes; None while something announced is missing."""
        found: list[HomieNode] = []
        listed = _listed(self._attributes.get("$nodes"))
        for name in listed or ():
            node_id = name.removesuffix("[]")
            elements = self._elements(node_id) if name.endswith("[]") else (node_id,)
            properties = _listed(self._attributes.get(f"{node_id}/$properties"))
            if elements is None or properties is None:
                return None
            for element in elements:
                node = self._node(node_id, element, properties)
                if node is None:
                    return None
                found.append(node)
        return None if listed is None else tuple(found)

    def _elements(self, node_id: str) -> tuple[str, ...] | None:
        match = _ARRAY.fullmatch(self._attributes.get(f"{node_id}/$array", ""))
        if match is None:
            return None
        first, last = int(match[1]), int(match[2])
        return tuple(f"{node_id}_{index}" for index in range(first, min(last, first + _MAX_ARRAY - 1) + 1))

    def _node(self, node_id: str, element: str, listed: tuple[str, ...]) -> HomieNode | None:
        properties: list[HomieProperty] = []
        for prop_id in listed:
            if f"{node_id}/{prop_id}/$datatype" not in self._attributes:
                return None
            try:
                properties.append(self._property(node_id, element, prop_id))
            except WireError:
                self.ignored += 1
        own = self._attributes.get(f"{element}/$name")
        return HomieNode(
            id=element,
            name=clean_text(own if own is not None else self._attributes.get(f"{node_id}/$name", "")),
            type=clean_text(self._attributes.get(f"{node_id}/$type", "")),
            properties=tuple(properties),
        )

    def _property(self, node_id: str, element: str, prop_id: str) -> HomieProperty:
        def field(attribute: str) -> str:
            return self._attributes.get(f"{node_id}/{prop_id}/{attribute}", "")

        self._count += 1
        datatype, spelled = field("$datatype"), field("$format")
        if datatype not in DATATYPES or self._count > MAX_PROPERTIES:
            raise WireError(f"datatype is {shown(datatype)}, or there are more than {MAX_PROPERTIES}")
        options = parse_options(spelled) if datatype in {"enum", "color"} else ()
        if datatype == "color" and not set(options) <= set(COLOR_FORMS):
            raise WireError(f"format {shown(spelled)} has no form of a colour")
        return HomieProperty(
            id=prop_id,
            name=clean_text(field("$name")),
            datatype=datatype,
            topic=f"{self._topic}/{element}/{prop_id}",
            unit=clean_text(field("$unit"), 20),
            range=parse_range(spelled) if datatype in {"integer", "float"} else Range(),
            options=options,
            is_settable=field("$settable") == "true",
            is_retained=field("$retained") != "false",
            names_form=False,
        )


def _listed(text: str | None) -> tuple[str, ...] | None:
    """The ids of a list; None where it is missing. What is no id is passed over."""
    if text is None:
        return None
    return tuple(dict.fromkeys(one for one in text.split(",") if _LISTED.fullmatch(one)))
