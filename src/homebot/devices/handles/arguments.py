"""The check of what is asked of handles: a condition that nobody knows must not find the whole house. Pure."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import get_args

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Category
from homebot.devices.query import StateIs
from homebot.devices.query.vocabulary import FIELDS
from homebot.similar import did_you_mean

__all__ = ["check_place", "check_state"]

_PLACE: Mapping[str, type] = {"area": str, "name": str, "reachable": bool, "fresh": bool, "category": str}
_CUTOFF = 0.7
_CATEGORIES = get_args(Category)


def check_place(kind: str, wanted: Callable[..., object], place: Mapping[str, object]) -> None:
    """Check the conditions that every kind of handle takes.

    Args:
        kind: What the handles are called, for example ``Light``.
        wanted: What names all conditions of the kind.
        place: The conditions by name.

    Raises:
        TypeError: One is unknown, or its value is of another type; the message names what was probably meant.
        ValueError: The category is none.
    """
    for name, value in place.items():
        if name not in _PLACE:
            known = [one for one in inspect.signature(wanted).parameters if one != "place"] + list(_PLACE)
            meant = [FIELDS[name]] if FIELDS.get(name) in known else known
            hint = did_you_mean(FIELDS.get(name, name), meant, f"it takes {', '.join(sorted(known))}", _CUTOFF)
            raise TypeError(f"{kind} cannot be asked for by {name!r}: {hint}")
        if not isinstance(value, _PLACE[name]):
            raise TypeError(f"{name} is {_called(_PLACE[name])}, not {value!r}")
    if (category := place.get("category", "")) not in _CATEGORIES:
        known_categories = " or ".join(repr(one) for one in _CATEGORIES if one)
        raise ValueError(f"category is {known_categories}, not {category!r}")


def check_state(term: StateIs) -> None:
    """Check that a state is compared with a value of its own type.

    Raises:
        TypeError: It is not.
    """
    capability = CAPABILITIES.get(term.capability)
    if capability is None:
        return
    expected = {"bool": bool, "number": float, "text": str}.get(capability.kind, tuple)
    if not isinstance(term.value, expected):
        raise TypeError(f"{term.capability} is {_called(expected)}, not {term.value!r}")


def _called(kind: type) -> str:
    return {str: "a text", bool: "True or False", float: "a number", tuple: "several numbers"}[kind]
