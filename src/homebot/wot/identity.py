"""Identifiers of a thing, and further facts of it. Pure."""

from __future__ import annotations

from homebot.conventions.payload import clean_text
from homebot.devices.identity import identifiers
from homebot.wot.thing import Thing

__all__ = ["facts_of", "identifiers_of"]

_OWN = ("mac:", "eui64:", "id:")


def identifiers_of(thing: Thing, *others: str) -> tuple[str, ...]:
    """Return the identifiers of *thing*, see :func:`homebot.devices.identity.identifiers`.

    Args:
        thing: The thing.
        others: What else it is known by, for example the name of its host.
    """
    own = tuple(one for one in thing.identifiers if one.startswith(_OWN))
    declared = identifiers(one for one in (*thing.identifiers, thing.id, *others) if one and one not in own)
    return tuple(dict.fromkeys((*own, *declared)))


def facts_of(thing: Thing) -> dict[str, str]:
    """Return the further facts that a description has of *thing*, by name."""
    facts = {clean_text(key, 60): clean_text(value) for key, value in thing.facts.items()}
    if thing.description:
        facts.setdefault("description", clean_text(thing.description, 200))
    return facts
