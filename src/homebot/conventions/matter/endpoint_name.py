"""The name of an endpoint for people: its labels, or the words of its semantic tags. Pure.

Source: Matter 1.4 Core Specification, 9.5.5 (TagList), 9.8 (Fixed Label), 9.9 (User Label); Standard Namespaces.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from homebot.conventions.matter.endpoint import DESCRIPTOR, TAG_LIST, MatterEndpoint
from homebot.conventions.payload import clean_text, text_of

__all__ = ["name_of"]

USER_LABEL, FIXED_LABEL = 65, 64
_NAMING: Final = frozenset({"name", "label", "button"})
"""The labels that name an endpoint; others say where it is, or describe it."""

_ORIENTATION: Final = "orientation"
_PLACES: Final = frozenset({"top", "bottom", "left", "right", "middle", "center", "upper", "lower", "front", "back"})
"""Orientations on the device itself, such as of one of two sockets; ``North`` is none."""

_NUMBER: Final = 0x07
_NAMESPACES: Final[Mapping[int, tuple[str, ...]]] = {
    0x08: ("left", "right", "top", "bottom", "middle", "row", "column"),
    0x41: ("refrigerator", "freezer"),
    0x43: ("on", "off", "toggle", "up", "down", "next", "previous", "select"),
    0x45: ("lift", "tilt"),
}
"""Common Position, Refrigerator, Switches and Closure Panel: each the words of its tags."""

_COUNTED: Final = frozenset({"row", "column"})
_LONGEST: Final = 40


def name_of(endpoint: MatterEndpoint) -> str:
    """Return a name such as ``2``, ``top`` or ``column 1 up``; empty if it has none of its own."""
    for cluster in (USER_LABEL, FIXED_LABEL):
        for one in endpoint.structs(cluster, 0):
            label, value = one.get("0", one.get("label")), one.get("1", one.get("value"))
            if not isinstance(label, str) or not isinstance(value, str):
                continue
            is_place = label.casefold() == _ORIENTATION and value.casefold() in _PLACES
            if (label.casefold() in _NAMING or is_place) and clean_text(value):
                return clean_text(value)
    words = list(dict.fromkeys(_words(endpoint)))
    while len(" ".join(words)) > _LONGEST:
        words.pop()
    return " ".join(words)


def _words(endpoint: MatterEndpoint) -> Iterator[str]:
    for one in endpoint.structs(DESCRIPTOR, TAG_LIST):
        namespace, tag = one.get("1", one.get("namespaceID")), one.get("2", one.get("tag"))
        text = one.get("3", one.get("label"))
        label = text_of(text)
        if type(namespace) is not int or type(tag) is not int or tag < 0:
            continue
        words = _NAMESPACES.get(namespace, ())
        if namespace == _NUMBER:
            yield label or str(tag)
        elif tag < len(words):
            yield f"{words[tag]} {label}" if words[tag] in _COUNTED and label else words[tag]
        elif words and label:
            yield label
