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
from homebot.devices.identity import identifiers
from homebot.devices.part import Capability, Part
from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.topics import validate_filter, validate_topic
from homebot.wot import ClassifiedPart, Thing, observe_form, parts_of, read_thing, write_form
from homebot.wot.mqtt.codec import is_supported, thing_codec

__all__ = ["ThingReader"]

_OWN = ("mac:", "eui64:", "id:")


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
        own = tuple(one for one in thing.identifiers if one.startswith(_OWN))
        others = identifiers(one for one in (*thing.identifiers, thing.id) if one and one not in own)
        facts = {clean_text(key, 60): clean_text(value) for key, value in thing.facts.items()}
        if thing.description:
            facts.setdefault("description", clean_text(thing.description, 200))
        return DeviceAnnounced(
            key=name,
            convention="thing",
            identifiers=tuple(dict.fromkeys((*own, *others))),
            name=clean_text(thing.title) or name,
            parts=tuple(_parts(thing)),
            topic=topic,
            area=clean_text(thing.area),
            facts=facts,
            implies_alive=True,  # who describes a thing now has just seen it; a forgotten one comes back so
        )


def _parts(thing: Thing) -> Iterator[DescribedPart]:
    for classified in parts_of(thing):
        usable = _usable(classified)
        yield DescribedPart(usable.part, thing_codec(usable))


def _usable(classified: ClassifiedPart) -> ClassifiedPart:
    """Return the part without what cannot be used.

    Raises:
        WireError: A topic to read or write is none.
    """
    affordances = []
    reads: dict[str, None] = {}
    writes: dict[str, None] = {}
    for capability, affordance in classified.affordances:
        observed, written = observe_form(affordance), write_form(affordance)
        if observed is not None and capability.readable and is_supported(observed.content_type):
            reads[_checked(affordance.name, observed.filter, validate_filter)] = None
        else:
            observed = None
        if written is not None and capability.settable and is_supported(written.content_type):
            writes[_checked(affordance.name, written.topic, validate_topic)] = None
        else:
            written = None
        offered = capability.model_copy(update={"readable": observed is not None, "settable": written is not None})
        affordances.append((offered, affordance))
    capabilities: tuple[Capability, ...] = tuple(one for one, _ in affordances)
    part: Part = classified.part.model_copy(
        update={
            "name": clean_text(classified.part.name),
            "capabilities": capabilities,
            "reads": tuple(reads),
            "writes": tuple(writes),
        }
    )
    return ClassifiedPart(part, tuple(affordances))


def _checked(name: str, topic: str, check: Callable[[str], None]) -> str:
    try:
        check(topic)
    except InvalidNameError as exc:
        raise WireError(f"the topic of {clean_text(name, 60)}: {exc}") from exc
    if topic[0] in "+#$":
        raise WireError(f"the topic of {clean_text(name, 60)}: {topic[:60]!a} names more than one Thing")
    return topic
