"""W3C Thing Descriptions 1.1: read, understood and written. Pure.

Each name is imported when it is first asked for: few houses have such descriptions.
"""

from typing import TYPE_CHECKING

from homebot.support.lazy_names import lazy_names

if TYPE_CHECKING:
    from homebot.wot.binding import Binding, RequestBinding
    from homebot.wot.classify import ClassifiedAffordance, ClassifiedPart, parts_of
    from homebot.wot.export import FormWriter, property_names, thing_id, to_thing
    from homebot.wot.mqtt_forms import MqttForms
    from homebot.wot.parse import CONTEXT, read_thing
    from homebot.wot.payload import (
        TEXT_CONTENT_TYPE,
        PayloadFormat,
        PayloadFormats,
        basic_formats,
        decode_document,
        encode_document,
        media_type,
    )
    from homebot.wot.scale import canonical, in_told_unit, on_the_wire
    from homebot.wot.thing import Affordance, DataSchema, Form, SecurityScheme, Thing, facts_of, identifiers_of

__all__ = [
    "CONTEXT",
    "TEXT_CONTENT_TYPE",
    "Affordance",
    "Binding",
    "ClassifiedAffordance",
    "ClassifiedPart",
    "DataSchema",
    "Form",
    "FormWriter",
    "MqttForms",
    "PayloadFormat",
    "PayloadFormats",
    "RequestBinding",
    "SecurityScheme",
    "Thing",
    "basic_formats",
    "canonical",
    "decode_document",
    "encode_document",
    "facts_of",
    "identifiers_of",
    "in_told_unit",
    "media_type",
    "on_the_wire",
    "parts_of",
    "property_names",
    "read_thing",
    "thing_id",
    "to_thing",
]

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.wot.binding": "Binding RequestBinding",
            "homebot.wot.classify": "ClassifiedAffordance ClassifiedPart parts_of",
            "homebot.wot.export": "FormWriter property_names thing_id to_thing",
            "homebot.wot.mqtt_forms": "MqttForms",
            "homebot.wot.parse": "CONTEXT read_thing",
            "homebot.wot.payload": (
                "TEXT_CONTENT_TYPE PayloadFormat PayloadFormats basic_formats"
                " decode_document encode_document media_type"
            ),
            "homebot.wot.scale": "canonical in_told_unit on_the_wire",
            "homebot.wot.thing": "Affordance DataSchema Form SecurityScheme Thing facts_of identifiers_of",
        },
    )
