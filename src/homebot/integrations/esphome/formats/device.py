"""An ESPHome device: its description and its entities, as parts of the vocabulary. Pure."""

from collections.abc import Iterable
from typing import TypeAlias

from homebot.conventions.entity_rows import Fields, text_of, whole_of
from homebot.conventions.secrets import names_secret
from homebot.devices.identity import identifiers
from homebot.devices.part import Part
from homebot.errors import RefusedError
from homebot.integrations.esphome.formats.entity import EsphomeEntity, key_of
from homebot.integrations.esphome.formats.kinds import KINDS

ListedEntity: TypeAlias = tuple[str, Fields]
"""Component and fields of an entity, as the device lists it."""

MAX_ENTITIES = 500
"""Entities of one device; a large one has a hundred."""

_ORDER = {component: number for number, component in enumerate(KINDS)}


class EsphomeDevice:
    """A device and its entities.

    Entities that are disabled by default are left out, as are cameras, and infrared and radio transmitters, for which
    the vocabulary has no type, and entities that report a code or password.

    Attributes:
        sleeps: Whether it sleeps most of the time, out of reach.
        entities: Its entities by the ids of their parts.
        left_out: Number of listed entities above the limit.
    """

    def __init__(self, info: Fields, listed: Iterable[ListedEntity]) -> None:
        self.sleeps = info.get("has_deep_sleep") is True
        self.entities: dict[str, EsphomeEntity] = {}
        self._by_key: dict[tuple[str, tuple[int, int]], str] = {}
        self._info = info
        known = [(kind, fields) for kind, fields in listed if kind in KINDS and _is_to_be_read(kind, fields)]
        self.left_out = max(0, len(known) - MAX_ENTITIES)
        for kind, fields in sorted(known[:MAX_ENTITIES], key=lambda kind_and_fields: _ORDER[kind_and_fields[0]]):
            name, owner = text_of(fields, "object_id")[:_MAX_ID], whole_of(fields, "device_id")
            entity = EsphomeEntity(kind, fields, KINDS[kind])
            object_id = f"{name}@{owner}" if name and owner else name
            if (entity.component, entity.key) in self._by_key:
                continue
            base = part_id = f"{entity.component}_{object_id}" if object_id else f"{entity.component}_{entity.key[1]}"
            number = 1
            while part_id in self.entities:
                number += 1
                part_id = f"{base}_{number}"
            self.entities[part_id] = entity
            self._by_key[entity.component, entity.key] = part_id

    @property
    def name(self) -> str:
        """Its name; empty for none."""
        return text_of(self._info, "friendly_name") or text_of(self._info, "name")

    @property
    def area(self) -> str:
        """Its room; empty for none."""
        area = self._info.get("area")
        return (text_of(area, "name") if isinstance(area, dict) else "") or text_of(self._info, "suggested_area")

    @property
    def identifiers(self) -> tuple[str, ...]:
        """Its hardware addresses, or its name without one; and those of its sub-devices, as Home Assistant has them.

        Source: Home Assistant core 2026.1, ``components/esphome/manager.py``.
        """
        mac = text_of(self._info, "mac_address")
        addresses = [mac, text_of(self._info, "bluetooth_mac_address")]
        owned = [f"esphome:{mac}_{number}" for number in _names(self._info.get("devices"))] if mac else []
        return identifiers([*addresses, *owned] if any(addresses) else [text_of(self._info, "name")])

    @property
    def metadata(self) -> dict[str, str]:
        """Further facts."""
        info = self._info
        facts = {
            "manufacturer": text_of(info, "manufacturer") or text_of(info, "project_name").partition(".")[0],
            "model": text_of(info, "model"),
            "sw_version": text_of(info, "esphome_version"),
            "project": f"{text_of(info, 'project_name')} {text_of(info, 'project_version')}".strip(),
        }
        return {fact: text for fact, text in facts.items() if text}

    def parts(self) -> tuple[Part, ...]:
        """Return its parts, one for each entity."""
        owners = _names(self._info.get("devices"))
        return tuple(entity.part(part_id, owners.get(entity.key[0], "")) for part_id, entity in self.entities.items())

    def part_of(self, kind: str, state: Fields) -> str | None:
        """Return the id of the part to which a state of the component *kind* belongs; None for an unlisted entity."""
        return self._by_key.get((kind, key_of(state)))

    def entity(self, part_id: str) -> EsphomeEntity:
        """Return the entity of a part.

        Raises:
            RefusedError: There is none.
        """
        if part_id not in self.entities:
            raise RefusedError(f"a command to the part {part_id[:40]!r}", "the device has no such part any more")
        return self.entities[part_id]


def _is_to_be_read(kind: str, fields: Fields) -> bool:
    if kind == "text_sensor" and names_secret(text_of(fields, "name")):
        return False
    return fields.get("disabled_by_default") is not True


_MAX_ID = 120


def _names(listed: object) -> dict[int, str]:
    rows = listed[:MAX_ENTITIES] if isinstance(listed, list) else []
    return {whole_of(row, "device_id"): text_of(row, "name") for row in rows if isinstance(row, dict)}
