"""The entities of a Home Assistant with their states, grouped into devices. Pure.

The entities of one device of Home Assistant are the parts of one device; an entity without a device is a device.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from homebot.conventions.description import Publication, Publications
from homebot.conventions.entity_rows import quantity_of_entity
from homebot.conventions.payload import as_fields, compact_json, shown, text_of
from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.errors import LinkError, UnableError, WireError
from homebot.gateways.announced.gateway_device import GatewayDevice, ShowingCodec
from homebot.integrations.homeassistant.formats.device import DeviceInfo
from homebot.integrations.homeassistant.formats.states.domains import DOMAINS
from homebot.integrations.homeassistant.formats.states.entity import HomeAssistantEntity
from homebot.integrations.homeassistant.formats.states.presses import APP_KEY, APP_PARTS, RAW_PART, open_button
from homebot.integrations.homeassistant.formats.states.registries import Registries

_TELLING = frozenset({"zha", "deconz"})
"""Integrations that tell the events of remotes."""

MAX_PARTS = 200
"""The parts of one device."""

_MAX_FACT = 255

_ORDER = {domain: number for number, domain in enumerate(DOMAINS)}


@dataclass(frozen=True)
class _ServiceCodec(ShowingCodec):
    """The codec of an entity, which shows its service calls."""

    entity: HomeAssistantEntity

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        return self.write_with_code(capability, value, "", transition)

    def write_with_code(self, capability: str, value: PlainValue, code: str, transition: float = 0.0) -> Publications:
        call = self.entity.call(capability, value, transition, code)
        return (
            Publication(
                f"{call.domain}.{call.service}", compact_json({"entity_id": call.entity_id, **call.data}).encode()
            ),
        )


class HomeAssistantEntities:
    """The entities with a state or a registry entry.

    Args:
        max_entities: Most known entities; further ones are left out and counted.

    Attributes:
        celsius: Whether Home Assistant uses °C.
        own_user: The id of homebot's own user there; empty if unknown.
        triggers: The parts for triggers, by device id.
        left_out: Entities beyond the limit.
    """

    def __init__(self, max_entities: int) -> None:
        self.registries = Registries()
        self.celsius = True
        self.own_user = ""
        self.triggers: Mapping[str, tuple[Part, ...]] = {}
        self.left_out = 0
        self._max_entities = max_entities
        self._entities: dict[str, HomeAssistantEntity] = {}
        self._parts: dict[str, dict[str, HomeAssistantEntity]] = {}
        self._devices: dict[str, GatewayDevice] = {}

    def put(self, entity_id: str, change: object, *, is_new: bool) -> tuple[HomeAssistantEntity, bool] | None:
        """Apply the state of an entity, or a change; return the entity, and whether its part may have changed.

        None for an entity that homebot does not use.

        Raises:
            WireError: It is invalid.
        """
        if entity_id.partition(".")[0] not in DOMAINS:
            return None
        fields = as_fields(change) if is_new else as_fields(as_fields(change).get("+"))
        gone = [] if is_new else as_fields(as_fields(change).get("-")).get("a", [])
        if not isinstance(change, dict) or not isinstance(gone, list) or not (fields or gone):
            raise WireError(f"the state of {entity_id[:100]} is {shown(change)}")
        entity = self._entities.get(entity_id)
        if entity is None and not is_new:
            return None
        if entity is None:
            if len(self._entities) >= self._max_entities:
                self.left_out += 1
                return None
            entry = self.registries.entity(entity_id)
            entity = HomeAssistantEntity(entity_id, entry, celsius=self.celsius, others=self._entities)
            self._entities[entity_id] = entity
        is_described_anew = entity.put(fields, is_new=is_new)
        entity.forget(gone)
        return entity, is_described_anew

    def lose(self, entity_id: str) -> HomeAssistantEntity | None:
        """Record that an entity has lost its state: it is being reloaded, or was removed, as its registry tells."""
        entity = self._entities.get(entity_id)
        if entity is not None:
            entity.has_state = entity.is_available = False
        return entity

    def lose_all(self) -> None:
        """Forget all states: the next ones are the complete list."""
        self.left_out = 0
        for entity_id in self._entities:
            self.lose(entity_id)

    def regroup(self, *, forget: bool = False) -> dict[str, tuple[HomeAssistantEntity, ...]]:
        """Regroup the entities by the registries; return them by the keys of their devices.

        Args:
            forget: Whether to drop entities that have neither a state nor ever had an entry.
        """
        gone = [
            key
            for key, entity in self._entities.items()
            if not entity.has_state and not self.registries.has_entity(key)
        ]
        for entity_id in gone:
            if forget or self._entities[entity_id].entry.key != entity_id:
                del self._entities[entity_id]
        self._parts = groups = self._group()
        self._devices = {key: device for key, device in self._devices.items() if key in groups}
        return {key: tuple(parts.values()) for key, parts in groups.items()}

    def _group(self) -> dict[str, dict[str, HomeAssistantEntity]]:
        """Return the entities by device and part, each with its newest entry."""
        groups: dict[str, dict[str, HomeAssistantEntity]] = {}
        for entity_id, entity in sorted(self._entities.items(), key=_order):
            entity.device_key, entity.entry = "", self.registries.entity(entity_id)
            entry = entity.entry
            if entity.is_left_out(self.registries) or self.registries.is_left_out(entry.device_id):
                continue
            key = entry.device_id or entry.key
            parts = groups.setdefault(key, {})
            if entry.part_id in parts:  # from another integration with the same id
                entity.entry = entry = entry._replace(part_id=entry.key)
            if len(parts) < MAX_PARTS:
                parts[entry.part_id] = entity
                entity.device_key = key
        for key in self.triggers:
            if self.registries.device(key) is not None and not self.registries.is_left_out(key):
                groups.setdefault(key, {})
        if self.registries.has_device_of("mobile_app"):
            groups.setdefault(APP_KEY, {})
        return groups

    def of(self, key: str) -> tuple[HomeAssistantEntity, ...]:
        """Return the entities of a device, in the order of its parts."""
        return tuple(self._parts.get(key, {}).values())

    def is_new(self, entity_id: str) -> bool:
        """Return whether an entity appeared after the last grouping; one left out then is not new."""
        return entity_id in self._entities and self._entities[entity_id].device_key is None

    def is_reached(self, key: str) -> bool:
        """Return whether Home Assistant can reach a device; None without entities."""
        entities = self.of(key)
        return not entities or any(entity.is_available for entity in entities)

    def key_of(self, entity_id: str) -> str:
        """Return the key of the device of an entity; empty for none."""
        return (entity_id in self._entities and self._entities[entity_id].device_key) or ""

    def entity(self, key: str, part: str) -> HomeAssistantEntity:
        """Return the entity of a part, which can be reached now.

        Raises:
            UnableError: There is no such part.
            LinkError: Home Assistant cannot reach it.
        """
        entity = self._parts.get(key, {}).get(part)
        if entity is None:
            raise UnableError(f"Home Assistant has no entity for the part {part[:100]!r} any more")
        if not entity.is_available:
            raise LinkError(f"{entity.entity_id} is unavailable in Home Assistant")
        return entity

    def device(self, key: str) -> GatewayDevice:
        """Return a device as last described, or else describe it."""
        return self._devices.get(key) or self.describe(key)

    def describe(self, key: str) -> GatewayDevice:
        """Describe a device from the registries and the attributes of its entities."""
        entities = self.of(key)
        ids = [entity.entity_id for entity in entities]
        device = self.registries.device(key) or DeviceInfo((), "", "", {})
        name = device.name or _name_of(key, entities)
        sole = [entity for entity in entities if not entity.entry.category]
        area, floor = self.registries.place(key, [entity.entity_id for entity in sole or entities])
        parts = [*map(self._part, entities), *self._buttons(key)]
        shown_as = {text_of(entity.info.get("friendly_name")) for entity in sole if len(sole) == 1} - {"", name}
        aliases = (*shown_as, *self.registries.listed("aliases", key, ids))
        facts = {"tags": ", ".join(self.registries.listed("labels", key, ids)), "aliases": ", ".join(aliases)}
        facts |= {**device.facts, "floor": floor, "entities": ", ".join(map(self._list, ids))[:_MAX_FACT]}
        self._devices[key] = described = GatewayDevice(
            key,
            name,
            tuple(part.model_copy(update={"name": ""}) if part.name == name else part for part in parts),
            {fact: text for fact, text in facts.items() if text},
            device.identifiers,
            authenticated=True,  # our token proved that it is the owner's Home Assistant
            area=area,
            raw_address=f"homeassistant/{key}",
            codecs={entity.entry.part_id: _ServiceCodec(entity) for entity in entities},
            native=False,  # the gateway of its native protocol knows it better
        )
        return described

    def _buttons(self, key: str) -> tuple[Part, ...]:
        """Return the buttons of a device that are no entities: its triggers, and of a remote all that it tells."""
        if key == APP_KEY:
            return APP_PARTS
        triggers = self.triggers.get(key, ())
        is_remote = any(part.tag != "device_offline" for part in triggers)
        is_told = is_remote and self.registries.is_of(key, _TELLING)
        return (*triggers, open_button(RAW_PART, "event")) if is_told else (*triggers,)

    def _part(self, entity: HomeAssistantEntity) -> Part:
        if entity.domain not in {"scene", "person"} and not entity.reaches_others(self.registries):
            return entity.part()
        members = tuple([f"#{self.registries.entity(member).part_id}" for member in entity.members])
        return entity.part().model_copy(update={"members": members})

    def _list(self, entity_id: str) -> str:
        """Return the id of an entity, with its unit if homebot converts that: limits of automations are in it."""
        info = self._entities[entity_id].info
        unit = text_of(info.get("unit_of_measurement"))
        return entity_id if unit in {"", quantity_of_entity(info).unit} else f"{entity_id} ({unit})"


def _name_of(key: str, entities: Sequence[HomeAssistantEntity]) -> str:
    """Return the name of a device without one of its own: that of its first entity."""
    if not entities:
        return "Home Assistant app" if key == APP_KEY else key
    return entities[0].name or entities[0].entity_id.partition(".")[2].replace("_", " ") or key


def _order(key_and_entity: tuple[str, HomeAssistantEntity]) -> tuple[bool, int, bool, str]:
    """Return the sort key of an entity: settings last, then as :data:`DOMAINS` are sorted, a whole before its parts."""
    entity_id, entity = key_and_entity
    return bool(entity.entry.category), _ORDER[entity.domain], not entity.is_group, entity_id
