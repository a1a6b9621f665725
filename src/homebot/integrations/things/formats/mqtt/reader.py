"""Reader of Thing Descriptions that came over MQTT: descriptions in, devices with their codecs out. Pure."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from homebot.conventions.command_values import Writer, require_true
from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
    Publication,
    Publications,
)
from homebot.conventions.payload import Readings, clean_text, parse_object, unreadable
from homebot.conventions.table_codec import Reader, TableCodec
from homebot.devices.capabilities import implied_settings
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import InvalidNameError, WireError
from homebot.integrations.things.formats.binding import ClassifiedAffordance, ClassifiedPart
from homebot.integrations.things.formats.classify import parts_of
from homebot.integrations.things.formats.parse import read_thing
from homebot.integrations.things.formats.payload import (
    PayloadFormat,
    PayloadFormats,
    basic_formats,
    decode_document,
    encode_document,
)
from homebot.integrations.things.formats.thing import (
    OBSERVE_OPS,
    WRITE_OPS,
    Affordance,
    Form,
    Thing,
    facts_of,
    identifiers_of,
)
from homebot.mqtt.topics import validate_filter, validate_topic


@dataclass(frozen=True, slots=True)
class MqttBinding:
    """The forms with topics, of payloads in known *formats*: each subscriber is sent the values."""

    formats: PayloadFormats = basic_formats

    def observe_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms with a filter to subscribe to."""
        return tuple(form for form in self._usable(affordance, OBSERVE_OPS) if form.filter)

    def write_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms with a topic to publish on."""
        return tuple(form for form in self._usable(affordance, WRITE_OPS) if form.topic)

    def _usable(self, affordance: Affordance, ops: frozenset[str]) -> Iterator[Form]:
        for form in affordance.forms:
            if form.is_mqtt and not ops.isdisjoint(form.ops) and self.formats(form.content_type):
                yield form


class ThingReader:
    """Reads Thing Descriptions below *prefixes*; keeps nothing between messages."""

    def __init__(self, prefixes: tuple[str, ...]) -> None:
        self.rejected = 0
        self._prefixes = prefixes

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the device of a description; raise WireError, with field and value, if it breaks a rule of TD 1.1."""
        del retained
        name = self._name(topic)
        if name is None:
            return ()
        if not payload:
            return (DeviceWithdrawn(name, "its description was withdrawn"),)
        thing = read_thing(parse_object(payload))
        announced = DeviceAnnounced(
            key=name,
            convention="thing",
            identifiers=identifiers_of(thing),
            name=clean_text(thing.title) or name,
            parts=tuple(_parts(thing)),
            topic=topic,
            area=clean_text(thing.area),
            facts=facts_of(thing),
            implies_alive=True,  # its publisher has just seen the thing; a forgotten one comes back so
        )
        return (announced,)

    def _name(self, topic: str) -> str | None:
        for prefix in self._prefixes:
            if topic.startswith(f"{prefix}/") and topic.endswith("/td"):
                name = topic[len(prefix) + 1 : -len("/td")]
                if name and "/" not in name:
                    return name
        return None


_BINDING = MqttBinding()


def _parts(thing: Thing) -> Iterator[DescribedPart]:
    for classified in parts_of(thing, _BINDING):
        reads: dict[str, None] = {}
        writes: dict[str, None] = {}
        for affordance in classified.affordances:
            if affordance.observed is not None:
                reads[_check(affordance.affordance.name, affordance.observed.filter, validate_filter)] = None
            for source in (affordance, *affordance.actions.values()):
                if source.written is not None:
                    writes[_check(source.affordance.name, source.written.topic, validate_topic)] = None
        name = clean_text(classified.part.name)
        part = classified.part.model_copy(update={"name": name, "reads": tuple(reads), "writes": tuple(writes)})
        usable = ClassifiedPart(part, classified.affordances)
        yield DescribedPart(usable.part, _thing_codec(usable))


def _check(name: str, topic: str, check: Callable[[str], None]) -> str:
    try:
        check(topic)
    except InvalidNameError as exc:
        raise WireError(f"the topic of {clean_text(name, 60)}: {exc}") from exc
    if topic[0] in "+#$":
        raise WireError(f"the topic of {clean_text(name, 60)}: {topic[:60]!a} names more than one Thing")
    return topic


def _thing_codec(part: ClassifiedPart) -> TableCodec[bytes]:
    """Return the codec of one part of a thing, by the first form of each of its affordances."""
    readers: dict[str, tuple[Reader[bytes], ...]] = {}
    event_readers: dict[str, tuple[Reader[bytes], ...]] = {}
    for affordance in part.affordances:
        observed = affordance.observed
        if observed is not None and (format_ := basic_formats(observed.content_type)) is not None:
            readers.setdefault(observed.filter, ())
            table = event_readers if affordance.affordance.kind == "event" else readers
            reader = partial(_read, affordance.capability, affordance.affordance, format_)
            table[observed.filter] = (*table.get(observed.filter, ()), reader)
    spelt = {name: partial(_spell, setting) for name, setting in part.settable.items()}
    writers: dict[str, Writer] = {name: partial(_write, spelt, name) for name in spelt}
    return TableCodec(bytes, readers, event_readers, writers)


def _read(capability: Capability, affordance: Affordance, format_: PayloadFormat, payload: bytes) -> Readings:
    try:
        document = format_.parse(payload)
    except WireError:
        return unreadable(payload, "JSON")
    value = decode_document(capability, affordance, document)
    return unreadable(payload, "a value of its data schema") if value is None else {capability.name: value[0]}


def _write(
    spelt: Mapping[str, Callable[[PlainValue], Publication]], capability: str, value: PlainValue, _transition: float
) -> Publications:
    """Write a value; a Thing Description has no transitions."""
    return tuple(spelt[name](setting) for name, setting in implied_settings(capability, value, spelt))


def _spell(affordance: ClassifiedAffordance, value: PlainValue) -> Publication:
    by, form, value = affordance.request(value)
    payload = b""
    if by.affordance.kind == "action" and by.capability.name == "push":
        require_true(by.capability.name, value)
    elif (format_ := basic_formats(form.content_type)) is not None:
        payload = format_.encode(encode_document(by.capability, by.affordance, value))
    return Publication(form.topic, payload, form.qos, form.retain)
