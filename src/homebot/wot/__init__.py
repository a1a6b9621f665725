"""W3C Thing Descriptions 1.1: read, understood and written. Pure."""

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
