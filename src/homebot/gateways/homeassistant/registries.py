"""The registries of Home Assistant: devices, entities, areas, floors and labels, checked. Pure.

Source: Home Assistant core 2024.3, ``components/config/*_registry.py``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from homebot.conventions.payload import as_fields, text_of
from homebot.devices.identity import identifiers
from homebot.devices.part import Category

__all__ = ["NO_ENTRY", "REGISTRIES", "DeviceEntry", "EntityEntry", "Registries", "own_entry"]

REGISTRIES: Final = ("device", "entity", "area", "floor", "label")
"""The last two are missing before 2024.3."""

_MAX_NAME: Final = 120
_MAX_ID: Final = 255
_MAX_IDENTIFIERS: Final = 64
_MAX_LISTED: Final = 50
_PLAIN_CONNECTIONS: Final = frozenset({"mac", "bluetooth", "zigbee"})
_PAIR: Final = 2
_CATEGORIES: Final[Mapping[object, Category]] = {"config": "config", "diagnostic": "diagnostic"}
_FACTS: Final = ("manufacturer", "model", "hw_version", "sw_version", "serial_number")


class EntityEntry(NamedTuple):
    """The entry of an entity.

    Attributes:
        part_id: Its lasting id within its device.
        key: Its lasting id in Home Assistant.
        name: Its own name; empty for none.
        is_disabled: Whether its owner switched it off.
    """

    part_id: str
    key: str
    device_id: str = ""
    name: str = ""
    category: Category = ""
    is_disabled: bool = False
    area_id: str = ""
    labels: tuple[str, ...] = ()


NO_ENTRY: Final = EntityEntry("", "")


def own_entry(entity_id: str) -> EntityEntry:
    """Return the entry of an entity that the registry does not have."""
    return EntityEntry(entity_id.replace(".", "_")[:_MAX_NAME], entity_id)


class DeviceEntry(NamedTuple):
    """The entry of a device.

    Attributes:
        identifiers: See :func:`homebot.devices.identity.identifiers`.
        is_left_out: Whether its owner switched it off, or homebot announced it to Home Assistant.
    """

    name: str
    identifiers: tuple[str, ...]
    metadata: Mapping[str, str]
    area_id: str = ""
    labels: tuple[str, ...] = ()
    is_left_out: bool = False


@dataclass(slots=True)
class Registries:
    """All registries.

    Attributes:
        devices: The devices by their ids.
        entities: The entities by their entity ids.
        areas: The name of each area, and the id of its floor.
        floors: The name of each floor.
        labels: The name of each label.
    """

    devices: dict[str, DeviceEntry] = field(default_factory=dict)
    entities: dict[str, EntityEntry] = field(default_factory=dict)
    areas: dict[str, tuple[str, str]] = field(default_factory=dict)
    floors: dict[str, str] = field(default_factory=dict)
    labels: dict[str, str] = field(default_factory=dict)

    def put(self, registry: str, listed: object) -> None:
        """Replace a registry of :data:`REGISTRIES` by what Home Assistant lists; invalid entries are left out."""
        rows = [as_fields(one) for one in listed] if isinstance(listed, list) else []
        match registry:
            case "device":
                self.devices = {_id(one, "id"): _device(one) for one in rows if _id(one, "id")}
            case "entity":
                self.entities = {_id(one, "entity_id"): _entity(one) for one in rows if _id(one, "entity_id")}
            case "area":
                self.areas = {_id(one, "area_id"): (text_of(one.get("name")), _id(one, "floor_id")) for one in rows}
            case "floor":
                self.floors = {_id(one, "floor_id"): text_of(one.get("name")) for one in rows}
            case _:
                self.labels = {_id(one, "label_id"): text_of(one.get("name")) for one in rows}

    def area_of(self, *area_ids: str) -> tuple[str, str]:
        """Return the name of the first known of these areas, and that of its floor; empty for none."""
        for area_id in area_ids:
            if area_id in self.areas:
                name, floor_id = self.areas[area_id]
                return name, self.floors.get(floor_id, "")
        return "", ""

    def labels_of(self, label_ids: Iterable[str]) -> tuple[str, ...]:
        """Return the names of labels, sorted."""
        return tuple(sorted({self.labels[one] for one in label_ids if self.labels.get(one)}))


def _id(fields: Mapping[str, object], key: str) -> str:
    value = fields.get(key)
    return value if isinstance(value, str) and len(value) <= _MAX_ID else ""


def _texts(value: object) -> tuple[str, ...]:
    listed = value[:_MAX_LISTED] if isinstance(value, list) else []
    return tuple(one for one in listed if isinstance(one, str))


def _entity(fields: Mapping[str, object]) -> EntityEntry:
    domain = _id(fields, "entity_id").partition(".")[0]
    unique = fields.get("unique_id")
    name = text_of(fields.get("name"), _MAX_NAME) or text_of(fields.get("original_name"), _MAX_NAME)
    category = _CATEGORIES.get(fields.get("entity_category"), "")
    return EntityEntry(
        part_id=f"{domain}_{unique}"[:_MAX_NAME] if isinstance(unique, (str, int)) else _id(fields, "id"),
        key=_id(fields, "id") or _id(fields, "entity_id"),
        device_id=_id(fields, "device_id"),
        name=name,
        category="config" if fields.get("hidden_by") and not category else category,
        is_disabled=bool(fields.get("disabled_by")),
        area_id=_id(fields, "area_id"),
        labels=_texts(fields.get("labels")),
    )


def _device(fields: Mapping[str, object]) -> DeviceEntry:
    metadata = {name: text_of(fields.get(name), _MAX_ID) for name in _FACTS}
    metadata["via_device"] = _id(fields, "via_device_id")
    name = text_of(fields.get("name_by_user"), _MAX_NAME) or text_of(fields.get("name"), _MAX_NAME)
    ids = _pairs(fields.get("identifiers"))
    return DeviceEntry(
        name=name or metadata["model"] or "device",
        identifiers=identifiers([*map(_identifier, ids), *map(_connection, _pairs(fields.get("connections")))]),
        metadata={key: text for key, text in metadata.items() if text},
        area_id=_id(fields, "area_id"),
        labels=_texts(fields.get("labels")),
        is_left_out=bool(fields.get("disabled_by")) or any(_is_own(*one) for one in ids),
    )


def _pairs(listed: object) -> list[tuple[str, str]]:
    rows = listed[:_MAX_IDENTIFIERS] if isinstance(listed, list) else []
    pairs = [one for one in rows if isinstance(one, list) and len(one) >= _PAIR]
    return [(str(one[0]), str(one[1])[:_MAX_ID]) for one in pairs]


def _is_own(domain: str, identifier: str) -> bool:
    """Return whether homebot announced this device, see :mod:`homebot.conventions.homeassistant.publisher`."""
    return domain == "mqtt" and identifier.startswith("homebot_")


def _identifier(pair: tuple[str, str]) -> str:
    """Return the identifier of a device as its own protocol has it, where homebot knows that."""
    domain, identifier = pair
    if domain == "mqtt":
        return identifier
    if domain == "matter":
        return identifier.removeprefix("serial_")
    return f"{domain}:{identifier}"


def _connection(pair: tuple[str, str]) -> str:
    kind, value = pair
    return value if kind in _PLAIN_CONNECTIONS else f"{kind}:{value}"
