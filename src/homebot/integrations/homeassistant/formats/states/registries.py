"""The registries of Home Assistant: devices, entities, areas, floors and labels. Pure.

Source: Home Assistant core 2024.3, ``components/config/*_registry.py``.
"""

import re
from collections.abc import Collection, Iterable, Mapping
from itertools import starmap
from typing import Final, NamedTuple

from homebot.conventions.payload import as_fields, text_of
from homebot.devices.identity import may_be_unique
from homebot.devices.part import Category
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.device import DeviceInfo, read_device

REGISTRIES: Final = {"device": "id", "entity": "entity_id", "area": "area_id", "floor": "floor_id", "label": "label_id"}
"""Each with the field of its ids; the last two are missing before 2024.3."""

_MAX_ID: Final = 120
_CATEGORIES: Final[Mapping[object, Category]] = {"config": "config", "diagnostic": "diagnostic"}

_ZWAVE_NODE: Final = re.compile(r"([0-9]{1,10})-([0-9]{1,4})(?:-.*)?", re.DOTALL)
"""Home and node in decimal digits; the second identifier of a node adds what its maker says."""

_Fields = Mapping[str, object]


class EntityEntry(NamedTuple):
    """The entry of an entity.

    Attributes:
        key: Its lasting id in Home Assistant; of one without an entry its entity id.
        part_id: Its lasting id within its device.
        device_id: Its device; empty for none.
        name: Its own name; empty for none.
        is_disabled: Whether its owner switched it off.
        has_code: Whether Home Assistant knows the code that it needs.
    """

    key: str
    part_id: str
    device_id: str = ""
    name: str = ""
    category: Category = ""
    is_disabled: bool = False
    has_code: bool = False


class Registries:
    """All registries, as they were listed last."""

    def __init__(self) -> None:
        self._listed: dict[str, dict[str, _Fields]] = {name: {} for name in REGISTRIES}

    def put(self, registry: str, listed: object) -> None:
        """Replace a registry of :data:`REGISTRIES`; invalid entries are left out."""
        key = REGISTRIES[registry]
        rows = [row for row in listed if isinstance(row, dict)] if isinstance(listed, list) else []
        self._listed[registry] = {row[key]: row for row in rows if isinstance(row.get(key), str)}

    @property
    def device_ids(self) -> tuple[str, ...]:
        """The ids of all devices."""
        return tuple(self._listed["device"])

    def has_entity(self, entity_id: str) -> bool:
        """Return whether the registry has an entity."""
        return entity_id in self._listed["entity"]

    def entity(self, entity_id: str) -> EntityEntry:
        """Return the entry of an entity, or one made of its id."""
        fields = self._listed["entity"].get(entity_id)
        if fields is None:
            return EntityEntry(entity_id, entity_id.replace(".", "_")[:_MAX_ID])
        category, domain = _CATEGORIES.get(fields.get("entity_category"), ""), entity_id.partition(".")[0]
        return EntityEntry(
            key=_text(fields, "id") or entity_id,
            part_id=f"{domain}_{fields.get('unique_id') or _text(fields, 'id')}"[:_MAX_ID],
            device_id=_text(fields, "device_id"),
            name=text_of(fields.get("name")) or text_of(fields.get("original_name")),
            category="config" if fields.get("hidden_by") and not category else category,
            is_disabled=bool(fields.get("disabled_by")),
            has_code=bool(as_fields(as_fields(fields.get("options")).get(domain)).get("default_code")),
        )

    def device(self, device_id: str) -> DeviceInfo | None:
        """Return a device as it would announce itself; None for none."""
        fields = self._listed["device"].get(device_id)
        if fields is None:
            return None
        name = text_of(fields.get("name_by_user")) or text_of(fields.get("name"))
        known = {key: value for key, value in fields.items() if value is not None}
        block = {**known, "name": name, "identifiers": _identifiers(fields)}
        via = _text(fields, "via_device_id") or _text(fields, "parent_device_id")
        known_as = _identifiers(self._listed["device"].get(via, {}))
        block |= {"via_device": next(iter(known_as), via)}
        try:
            return read_device(block, {})
        except WireError:
            return DeviceInfo((), name, "", {})

    def is_left_out(self, device_id: str) -> bool:
        """Return whether the owner switched a device off, or homebot itself announced it to Home Assistant."""
        fields = self._listed["device"].get(device_id, {})
        return bool(fields.get("disabled_by")) or any(
            domain == "mqtt" and identifier.startswith("homebot_") for domain, identifier in _pairs(fields)
        )

    def is_of(self, device_id: str, integrations: Collection[str]) -> bool:
        """Return whether one of *integrations* made a device."""
        return any(domain in integrations for domain, _ in _pairs(self._listed["device"].get(device_id, {})))

    def has_device_of(self, integration: str) -> bool:
        """Return whether *integration* made any device."""
        return any(self.is_of(device_id, (integration,)) for device_id in self._listed["device"])

    def place(self, device_id: str, entity_ids: Iterable[str]) -> tuple[str, str]:
        """Return the names of the area and of the floor of a device; empty for none.

        The area of an entity outranks that of its device, which counts if the entities are in several. A child device,
        which came in 2026.11, is where its parent is.
        """
        fields, *others = self._entries(device_id, entity_ids)
        parent = self._listed["device"].get(_text(fields, "parent_device_id"), {})
        device = _text(fields, "area_id") or _text(parent, "area_id")
        entities = [_text(other, "area_id") for other in others]
        shared = {entity or device for entity in entities}
        for area_id in (*(shared if len(shared) == 1 else ()), device, *entities):
            area = self._listed["area"].get(area_id)
            if area is not None:
                floor = self._listed["floor"].get(_text(area, "floor_id"), {})
                return text_of(area.get("name")), text_of(floor.get("name"))
        return "", ""

    def listed(self, field: str, device_id: str, entity_ids: Iterable[str]) -> tuple[str, ...]:
        """Return the texts in a list of a device and its entities, sorted; of labels the names."""
        names = set()
        for fields in self._entries(device_id, entity_ids):
            texts = fields.get(field)
            for text in texts if isinstance(texts, list) else ():
                label = self._listed["label"].get(text) if field == "labels" and isinstance(text, str) else None
                names.add(text_of(text if label is None else label.get("name")))
        return tuple(sorted(names - {""}))

    def _entries(self, device_id: str, entity_ids: Iterable[str]) -> list[_Fields]:
        return [
            self._listed["device"].get(device_id, {}),
            *(self._listed["entity"].get(entity_id, {}) for entity_id in entity_ids),
        ]


def _text(fields: _Fields, key: str) -> str:
    value = fields.get(key)
    return value if isinstance(value, str) else ""


def _pairs(fields: _Fields) -> list[tuple[str, str]]:
    """Return the identifiers of a device, each with the integration that gave it; some are of three texts."""
    listed = fields.get("identifiers")
    rows = [row for row in listed if isinstance(row, list) and len(row) > 1] if isinstance(listed, list) else []
    texts = [list(map(str, row)) for row in rows if all(isinstance(text, str | int) for text in row)]
    return [(text[0], ":".join(text[1:])) for text in texts if all(text)]


def _identifiers(fields: _Fields) -> list[str]:
    return list(filter(None, starmap(_identifier, _pairs(fields))))


def _identifier(domain: str, identifier: str) -> str:
    """Return an identifier of a device as the gateway of its own protocol has it, if there is one.

    Source: Home Assistant core 2025.5, ``components``: cast, homekit_controller, matter, mqtt
    and zwave_js; Z-Wave JS UI 11, ``api/hass/utils.ts``.
    """
    match domain:
        case "cast" | "mqtt":
            return identifier
        case "matter" if identifier.startswith("serial_"):
            serial = identifier.removeprefix("serial_")
            return serial if may_be_unique(serial) else ""
        case "zwave_js" if node := _ZWAVE_NODE.fullmatch(identifier):
            return f"zwavejs2mqtt_0x{int(node[1]):x}_node{node[2]}"
        case "homekit_controller:accessory-id":
            server, _, aid = identifier.upper().partition(":AID:")
            return f"homekit {server} pairing" if aid == "1" else f"homekit {server} aid {aid}"
    return f"{domain}:{identifier}"
