"""The forms of a thing that are at its own host. Pure."""

from __future__ import annotations

from homebot.conventions.coap.endpoint import authority_of
from homebot.wot.thing import Thing, change_forms

__all__ = ["with_own_forms"]


def with_own_forms(thing: Thing, base: str) -> Thing:
    """Return *thing* with those forms alone that are at the endpoint *base*: it does not speak for other hosts."""
    own = authority_of(base)
    return change_forms(thing, lambda form: form if _is_at(form.href, own) else None)


def _is_at(href: str, own: str) -> bool:
    try:
        return authority_of(href) == own
    except ValueError:
        return False
