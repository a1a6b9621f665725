"""Codec of a part of a thing on MQTT topics. Pure."""

from __future__ import annotations

from functools import partial

from homebot.conventions.command_values import Writer
from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.conventions.table_codec import Reader, TableCodec, raw_bytes
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.wot import Affordance, ClassifiedPart, Form, PayloadFormat, basic_formats, decode_document, encode_document

__all__ = ["thing_codec"]


def thing_codec(part: ClassifiedPart) -> TableCodec[bytes]:
    """Return the codec of one part of a thing, by the first form of each of its affordances."""
    readers: dict[str, tuple[Reader[bytes], ...]] = {}
    event_readers: dict[str, tuple[Reader[bytes], ...]] = {}
    writers: dict[str, Writer] = {}
    for one in part.affordances:
        observed, written = one.observed, one.written
        if observed is not None and (format_ := basic_formats(observed.content_type)) is not None:
            readers.setdefault(observed.filter, ())
            table = event_readers if one.affordance.kind == "event" else readers
            reader = partial(_read, one.capability, one.affordance, format_)
            table[observed.filter] = (*table.get(observed.filter, ()), reader)
        if written is not None and (format_ := basic_formats(written.content_type)) is not None:
            writers.setdefault(one.capability.name, partial(_write, one.capability, one.affordance, written, format_))
    return TableCodec(raw_bytes, readers, event_readers, writers)


def _read(capability: Capability, affordance: Affordance, format_: PayloadFormat, payload: bytes) -> Readings:
    try:
        document = format_.parse(payload)
    except WireError:
        return NO_READINGS
    value = decode_document(capability, affordance, document)
    return NO_READINGS if value is None else {capability.name: value[0]}


def _write(
    capability: Capability,
    affordance: Affordance,
    form: Form,
    format_: PayloadFormat,
    value: PlainValue,
    _transition: float,
) -> Publications:
    """Write a value; a Thing Description has no transitions."""
    if affordance.kind == "action":
        if value is not True:
            raise RefusedError(f"{capability.name} {shown(value)}", "it takes only true")
        return (Publication(form.topic, b"", form.qos, form.retain),)
    payload = format_.encode(encode_document(capability, affordance, value))
    return (Publication(form.topic, payload, form.qos, form.retain),)
