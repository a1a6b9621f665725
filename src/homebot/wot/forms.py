"""Choice among the forms of a thing by their addresses."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from homebot.wot.thing import Form, Thing

__all__ = ["change_forms"]


def change_forms(thing: Thing, change: Callable[[Form], Form | None]) -> Thing:
    """Return *thing* with its forms changed.

    Args:
        thing: The thing.
        change: Returns what stands in place of a form; None leaves it out.
    """

    def changed(forms: Iterable[Form]) -> tuple[Form, ...]:
        return tuple(new for one in forms if (new := change(one)) is not None)

    affordances = tuple(replace(one, forms=changed(one.forms)) for one in thing.affordances)
    return replace(thing, affordances=affordances, forms=changed(thing.forms))
