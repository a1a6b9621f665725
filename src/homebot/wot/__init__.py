"""W3C Thing Descriptions 1.1: read, understood and written. Pure.

Each name is imported when it is first asked for: few houses have such descriptions.
"""

from typing import TYPE_CHECKING

from homebot.lazy_names import lazy_names

if TYPE_CHECKING:
    from homebot.wot.classify import ClassifiedPart, observe_form, parts_of, write_form
    from homebot.wot.export import TEXT_CONTENT_TYPE, to_thing
    from homebot.wot.parse import CONTEXT, read_thing
    from homebot.wot.scale import canonical, on_the_wire
    from homebot.wot.thing import Affordance, DataSchema, Form, Thing

__all__ = [
    "CONTEXT",
    "TEXT_CONTENT_TYPE",
    "Affordance",
    "ClassifiedPart",
    "DataSchema",
    "Form",
    "Thing",
    "canonical",
    "observe_form",
    "on_the_wire",
    "parts_of",
    "read_thing",
    "to_thing",
    "write_form",
]

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.wot.classify": "ClassifiedPart observe_form parts_of write_form",
            "homebot.wot.export": "TEXT_CONTENT_TYPE to_thing",
            "homebot.wot.parse": "CONTEXT read_thing",
            "homebot.wot.scale": "canonical on_the_wire",
            "homebot.wot.thing": "Affordance DataSchema Form Thing",
        },
    )
