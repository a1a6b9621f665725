"""W3C Thing Descriptions 1.1: read, understood and written. Pure."""

from homebot.devices.thing.export import PLAIN_WORDS, to_thing
from homebot.devices.thing.meaning import Meant, hears, parts_of, tells
from homebot.devices.thing.reading import CONTEXT, read_thing
from homebot.devices.thing.scale import canonical, on_the_wire
from homebot.devices.thing.thing import Affordance, DataSchema, Form, Thing

__all__ = [
    "CONTEXT",
    "PLAIN_WORDS",
    "Affordance",
    "DataSchema",
    "Form",
    "Meant",
    "Thing",
    "canonical",
    "hears",
    "on_the_wire",
    "parts_of",
    "read_thing",
    "tells",
    "to_thing",
]
