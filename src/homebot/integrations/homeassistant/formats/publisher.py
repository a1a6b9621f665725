"""Publisher of exposed devices, as configs and states for a Home Assistant. Pure.

Source: Home Assistant core 2024.3 to 2026.11, ``components/mqtt``.
"""

import hashlib
import json
import re
from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

from homebot.conventions.description import Publication, Publications
from homebot.devices.exposure import ExposedDevice
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Part
from homebot.devices.value import PlainValue, Value
from homebot.integrations.homeassistant.formats.published_controls import (
    FAN_ROWS,
    publish_alarm,
    publish_climate,
    publish_cover,
    publish_humidifier,
    publish_light,
    publish_lock,
    publish_mower,
    publish_siren,
    publish_vacuum,
    publish_valve,
    publish_water_heater,
)
from homebot.integrations.homeassistant.formats.published_entity import (
    Available,
    CommandReader,
    PublishedEntity,
    is_settable,
    publish_single,
)


class _Whole(NamedTuple):
    """An entity with several capabilities of a part.

    Attributes:
        needs: The capabilities that the part must be able to set.
        publish: Moves the capabilities of a part to it; none if Home Assistant has no such entity.
        service_types: The types of parts that it is of; empty for any.
    """

    component: str
    needs: tuple[str, ...]
    publish: Callable[[PublishedEntity, Available, Part], None]
    service_types: tuple[str, ...] = ()

    def fits(self, part: Part, available: Available) -> bool:
        fits_type = not self.service_types or part.service_type in self.service_types
        return fits_type and all(is_settable(available, name) for name in self.needs)


_WHOLE: tuple[_Whole, ...] = (
    _Whole("light", ("on_off",), publish_light, ("light",)),
    _Whole("fan", ("on_off",), lambda entity, available, _: entity.add_rows(available, FAN_ROWS), ("fan",)),
    _Whole("siren", ("on_off",), publish_siren, ("siren",)),
    _Whole("climate", (), publish_climate, ("thermostat", "room_air_conditioner")),
    _Whole("water_heater", ("heating_setpoint",), publish_water_heater, ("water_heater",)),
    _Whole("humidifier", ("on_off", "humidity_setpoint"), publish_humidifier, ("x_humidifier",)),
    _Whole("lock", ("lock",), publish_lock),
    _Whole("valve", ("valve",), publish_valve),
    _Whole("cover", (), publish_cover),
    _Whole("vacuum", ("vacuum",), publish_vacuum),
    _Whole("lawn_mower", ("mower",), publish_mower),
    _Whole("alarm_control_panel", ("alarm",), publish_alarm),
)
"""Each removes its capabilities, so that the position of a valve is no cover."""


_MAX_COMMAND = 1000
_WATCHED = frozenset({"binary_sensor", "sensor"})
"""Components that can be diagnostic in Home Assistant, but not settings."""


class HomeAssistantPublisher:
    """Publisher of retained configs and states, and of events.

    Args:
        owner: The lasting name of this homebot, unique in the house.
        status_topic: The topic of its ``online`` and ``offline``.
    """

    def __init__(self, prefix: str, owner: str, status_topic: str) -> None:
        self._prefix = prefix
        self._owner = f"homebot_{_slug(owner)}"
        self._base = f"homebot/{_slug(owner)}/offers"
        self._status_topic = status_topic
        self._routes: dict[str, tuple[str, str, CommandReader]] = {}  # the exposed part of each topic of commands
        self._published: dict[str, tuple[tuple[Part, tuple[PublishedEntity, ...]], ...]] = {}

    def filters(self) -> tuple[str, ...]:
        """Return the filter of Home Assistant's commands."""
        return (f"{self._base}/+/+/+/set",)

    def is_own_topic(self, topic: str) -> bool:
        """Return whether *topic* is a config of this homebot, which is no device to it."""
        return topic.startswith(f"{self._prefix}/") and f"/{self._owner}/" in topic

    def publications(self, offer: ExposedDevice) -> Publications:
        """Return the configs of *offer*, or the removal of its retained messages."""
        entities = tuple((part, self._entities(offer, part)) for part in offer.parts)
        publish = self._withdrawal if offer.is_withdrawn else self._config
        if offer.is_withdrawn:
            self._published.pop(offer.id, None)
        else:
            self._published[offer.id] = entities
        return tuple(
            publication
            for part, entities_of_part in entities
            for entity in entities_of_part
            for publication in publish(offer, part, entity)
        )

    def states(
        self, offer: ExposedDevice, known: Mapping[tuple[str, str], PlainValue], changed: Collection[tuple[str, str]]
    ) -> Publications:
        """Return the states of *offer* with a *changed* value among the *known* ones, by part and capability."""
        publications: list[Publication] = []
        for part, entities in self._published.get(offer.id, ()):
            news = {name for part_id, name in changed if part_id == part.id}
            values = {name: value for (part_id, name), value in known.items() if part_id == part.id} if news else {}
            publications.extend(
                Publication(state.topic, state.write(values).encode(), qos=1, retain=not state.is_event)
                for entity in entities
                for state in entity.states
                if state.capabilities & news
            )
        return tuple(publications)

    def read_command(self, topic: str, payload: bytes) -> tuple[Command, ...]:
        """Return the commands in a message on one of the filters, in this order."""
        route = self._routes.get(topic)
        if route is None or len(payload) > _MAX_COMMAND:
            return ()
        try:
            text = payload.decode()
        except UnicodeDecodeError:
            return ()
        offer_id, part_id, read = route
        return tuple(
            Command(key=offer_id, part=part_id, capability=name, value=Value.of(value))
            for name, value in read(text).items()
        )

    def _entities(self, offer: ExposedDevice, part: Part) -> tuple[PublishedEntity, ...]:
        """Return the entities of *part*: the main one, then one for each other capability."""
        base = f"{self._base}/{_slug(offer.id)}/{_slug(part.id) or '_'}"
        available: Available = {capability.name: capability for capability in part.capabilities}
        entities: list[PublishedEntity] = []
        for whole in _WHOLE:
            if whole.fits(part, available):
                entity = PublishedEntity(base, whole.component)
                whole.publish(entity, available, part)
                entities += [entity] if entity.commands or entity.states else []
        return (
            *entities,
            *(entity for capability in available.values() for entity in publish_single(part, capability, base)),
        )

    def _config(self, offer: ExposedDevice, part: Part, entity: PublishedEntity) -> Publications:
        for topic, read in entity.commands.items():
            self._routes[topic] = offer.id, part.id, read
        facts = {
            "identifiers": [f"{self._owner}_{_slug(offer.id)}"],
            "name": offer.name,
            "manufacturer": "homebot",
            "model": offer.model,
            "suggested_area": offer.area,
        }
        config: dict[str, object] = {
            "device": {key: value for key, value in facts.items() if value},
            "origin": {"name": "homebot"},
            "availability_topic": self._status_topic,
            **entity.config,
        }
        if entity.component == "tag":
            config = {key: config[key] for key in ("device", "origin", "topic")}
        else:
            config["name"] = " ".join(word for word in (part.name, entity.name.replace("_", " ")) if word) or None
            config["unique_id"] = f"{self._owner}_{self._object_id(offer, part, entity)}"
            if part.category:
                config["entity_category"] = "diagnostic" if entity.component in _WATCHED else part.category
        payload = json.dumps(config, ensure_ascii=False).encode()
        return (Publication(self._config_topic(offer, part, entity), payload, qos=1, retain=True),)

    def _withdrawal(self, offer: ExposedDevice, part: Part, entity: PublishedEntity) -> Publications:
        for topic in entity.commands:
            self._routes.pop(topic, None)
        kept = [state.topic for state in entity.states if not state.is_event]
        return tuple(
            Publication(topic, b"", qos=1, retain=True) for topic in (self._config_topic(offer, part, entity), *kept)
        )

    def _config_topic(self, offer: ExposedDevice, part: Part, entity: PublishedEntity) -> str:
        return f"{self._prefix}/{entity.component}/{self._owner}/{self._object_id(offer, part, entity)}/config"

    def _object_id(self, offer: ExposedDevice, part: Part, entity: PublishedEntity) -> str:
        """Return the object id; its pieces are separated by two ``_``, which no piece has."""
        return "__".join(_slug(word) for word in (offer.id, part.id, entity.name or entity.component) if word)


def _slug(text: str) -> str:
    """Return *text* with letters, digits and ``_`` alone, and a checksum if it had other characters."""
    slug = re.sub("[^a-zA-Z0-9]+", "_", text).strip("_")
    if slug == text:
        return slug
    return f"{slug}_{hashlib.sha256(text.encode()).hexdigest()[:6]}" if text else ""
