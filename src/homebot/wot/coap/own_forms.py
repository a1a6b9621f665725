"""The forms of a thing that are at its own host. Pure."""

from __future__ import annotations

from dataclasses import replace

from homebot.conventions.coap.endpoint import authority_of
from homebot.wot.thing import Thing

__all__ = ["with_own_forms"]


def with_own_forms(thing: Thing, base: str) -> Thing:
    """Return *thing* with those forms alone that are at the endpoint *base*: it does not speak for other hosts."""
    own = authority_of(base)
    affordances = (
        replace(one, forms=tuple(form for form in one.forms if _is_at(form.href, own))) for one in thing.affordances
    )
    return replace(
        thing, affordances=tuple(affordances), forms=tuple(form for form in thing.forms if _is_at(form.href, own))
    )


def _is_at(href: str, own: str) -> bool:
    try:
        return authority_of(href) == own
    except ValueError:
        return False
