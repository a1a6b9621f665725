"""Codec of a part of a thing. Pure."""

from __future__ import annotations

from functools import partial

from homebot.conventions.decode import NO_READINGS, Readings
from homebot.conventions.description import Publication
from homebot.conventions.payload import shown
from homebot.conventions.table_codec import Reader, TableCodec, Writer, raw_bytes
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.wot import Affordance, ClassifiedPart, Form, observe_form, write_form
from homebot.wot.mqtt.payload_codec import decode_value, encode_value

__all__ = ["thing_codec"]


def thing_codec(part: ClassifiedPart) -> TableCodec[bytes]:
    """Return the codec of one part of a thing.

    Args:
        part: The part; what it reads and writes is said by its capabilities, whatever its affordances offer.
    """
    readers: dict[str, tuple[Reader[bytes], ...]] = {}
    event_readers: dict[str, tuple[Reader[bytes], ...]] = {}
    writers: dict[str, Writer] = {}
    for capability, affordance in part.affordances:
        observed, written = observe_form(affordance), write_form(affordance)
        if capability.readable and observed is not None:
            readers.setdefault(observed.filter, ())
            table = event_readers if affordance.kind == "event" else readers
            table[observed.filter] = (*table.get(observed.filter, ()), partial(_read, capability, affordance))
        if capability.settable and written is not None:
            writers.setdefault(capability.name, partial(_write, capability, affordance, written))
    return TableCodec(raw_bytes, readers, event_readers, writers)


def _read(capability: Capability, affordance: Affordance, payload: bytes) -> Readings:
    value = decode_value(capability, affordance, payload)
    return NO_READINGS if value is None else {capability.name: value[0]}


def _write(
    capability: Capability, affordance: Affordance, form: Form, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    """A Thing Description does not speak of transitions."""
    if affordance.kind == "action":
        if value is not True:
            raise RefusedError(f"{capability.name} {shown(value)}", "it takes true")
        return (Publication(form.topic, b"", form.qos, form.retain),)
    payload = encode_value(capability, affordance, value, form.content_type)
    return (Publication(form.topic, payload, form.qos, form.retain),)
