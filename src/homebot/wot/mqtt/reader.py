"""Reader of Thing Descriptions that came over MQTT: descriptions in, devices out. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
)
from homebot.conventions.payload import clean_text, parse_object
from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.topics import validate_filter, validate_topic
from homebot.wot import ClassifiedPart, Thing, facts_of, identifiers_of, parts_of, read_thing
from homebot.wot.mqtt.binding import MqttBinding
from homebot.wot.mqtt.codec import thing_codec

__all__ = ["ThingReader"]

_BINDING = MqttBinding()


class ThingReader:
    """Reads Thing Descriptions; keeps nothing between messages.

    Args:
        prefixes: Where descriptions are looked for.
    """

    def __init__(self, prefixes: tuple[str, ...]) -> None:
        self.rejected = 0
        self._prefixes = prefixes

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Take a description.

        Raises:
            WireError: It breaks a rule of TD 1.1; names field and value.
        """
        del retained
        name = self._name(topic)
        if name is None:
            return ()
        if not payload:
            return (DeviceWithdrawn(name, "its description was withdrawn"),)
        return (self._described(name, topic, read_thing(parse_object(payload))),)

    def _name(self, topic: str) -> str | None:
        for prefix in self._prefixes:
            if topic.startswith(f"{prefix}/") and topic.endswith("/td"):
                name = topic[len(prefix) + 1 : -len("/td")]
                if name and "/" not in name:
                    return name
        return None

    def _described(self, name: str, topic: str, thing: Thing) -> DeviceAnnounced:
        return DeviceAnnounced(
            key=name,
            convention="thing",
            identifiers=identifiers_of(thing),
            name=clean_text(thing.title) or name,
            parts=tuple(_parts(thing)),
            topic=topic,
            area=clean_text(thing.area),
            facts=facts_of(thing),
            implies_alive=True,  # who describes a thing now has just seen it; a forgotten one comes back so
        )


def _parts(thing: Thing) -> Iterator[DescribedPart]:
    for classified in parts_of(thing, _BINDING):
        usable = _with_checked_topics(classified)
        yield DescribedPart(usable.part, thing_codec(usable))


def _with_checked_topics(classified: ClassifiedPart) -> ClassifiedPart:
    """Return the part with the topics that it does use.

    Raises:
        WireError: A topic to read or write is none.
    """
    reads: dict[str, None] = {}
    writes: dict[str, None] = {}
    for one in classified.affordances:
        if one.observed is not None:
            reads[_checked(one.affordance.name, one.observed.filter, validate_filter)] = None
        if one.written is not None:
            writes[_checked(one.affordance.name, one.written.topic, validate_topic)] = None
    name = clean_text(classified.part.name)
    part = classified.part.model_copy(update={"name": name, "reads": tuple(reads), "writes": tuple(writes)})
    return ClassifiedPart(part, classified.affordances)


def _checked(name: str, topic: str, check: Callable[[str], None]) -> str:
    try:
        check(topic)
    except InvalidNameError as exc:
        raise WireError(f"the topic of {clean_text(name, 60)}: {exc}") from exc
    if topic[0] in "+#$":
        raise WireError(f"the topic of {clean_text(name, 60)}: {topic[:60]!a} names more than one Thing")
    return topic
