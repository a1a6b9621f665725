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
from homebot.wot.mqtt.payload_codec import meant_value, spelt_value

__all__ = ["thing_codec"]


def thing_codec(meant: ClassifiedPart) -> TableCodec[bytes]:
    """Return the codec of one part of a thing.

    Args:
        meant: The part; what it reads and writes is said by its capabilities, whatever its affordances offer.
    """
    readers: dict[str, tuple[Reader[bytes], ...]] = {}
    event_readers: dict[str, tuple[Reader[bytes], ...]] = {}
    writers: dict[str, Writer] = {}
    for capability, affordance in meant.affordances:
        heard, told = observe_form(affordance), write_form(affordance)
        if capability.readable and heard is not None:
            readers.setdefault(heard.filter, ())
            table = event_readers if affordance.kind == "event" else readers
            table[heard.filter] = (*table.get(heard.filter, ()), partial(_read, capability, affordance))
        if capability.settable and told is not None:
            writers.setdefault(capability.name, partial(_write, capability, affordance, told))
    return TableCodec(raw_bytes, readers, event_readers, writers)


def _read(capability: Capability, affordance: Affordance, payload: bytes) -> Readings:
    value = meant_value(capability, affordance, payload)
    return NO_READINGS if value is None else {capability.name: value[0]}


def _write(
    capability: Capability, affordance: Affordance, form: Form, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    """A Thing Description does not speak of transitions."""
    if affordance.kind == "action":
        if value is not True:
            raise RefusedError(f"{capability.name} {shown(value)}", "it takes true")
        return (Publication(form.topic, b"", form.qos, form.retain),)
    payload = spelt_value(capability, affordance, value, form.content_type)
    return (Publication(form.topic, payload, form.qos, form.retain),)
