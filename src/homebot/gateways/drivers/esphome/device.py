"""An ESPHome device as homebot has it: what it said of itself and of its entities becomes parts. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TypeAlias

from homebot.devices.identity import identifiers
from homebot.errors import RefusedError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.esphome.climate import build_climate, build_fan, build_water_heater
from homebot.gateways.drivers.esphome.entity import EsphomeEntity, Fields, key_of, text_of, whole_of
from homebot.gateways.drivers.esphome.light import build_light
from homebot.gateways.drivers.esphome.openings import build_cover, build_lock, build_valve
from homebot.gateways.drivers.esphome.simple_entities import SIMPLE_BUILDERS

__all__ = ["EsphomeDevice", "ListedEntity"]

ListedEntity: TypeAlias = tuple[str, Fields]
"""Component and fields of an entity, as the device lists it."""

MAX_ENTITIES = 500
"""Entities of one device; a large one has a hundred."""

STALE_AFTER_SLEEP = 24 * 3600.0
"""Seconds of silence after which a device that sleeps counts as stale; most wake up at least once a day."""

_BUILDERS: Mapping[str, Callable[[str, Fields], EsphomeEntity]] = {
    "climate": build_climate,
    "water_heater": build_water_heater,
    "light": build_light,
    "cover": build_cover,
    "lock": build_lock,
    "valve": build_valve,
    "fan": build_fan,
    **SIMPLE_BUILDERS,
}
"""By component, in the order of parts: the first one that is no setting says what the device is."""

_ORDER = {kind: number for number, kind in enumerate(_BUILDERS)}


class EsphomeDevice:
    """A device and its entities.

    Entities that are disabled by default are left out, as are cameras, and infrared and radio transmitters, for which
    the vocabulary has nothing.

    Args:
        info: What it said of itself (``DeviceInfoResponse``).
        listed: Its entities, as it lists them.

    Attributes:
        sleeps: Whether it sleeps most of the time, out of reach.
        entities: Its entities by the ids of their parts.
        left_out: How many more entities it lists than are taken.
    """

    def __init__(self, info: Fields, listed: Iterable[ListedEntity]) -> None:
        self.sleeps = info.get("has_deep_sleep") is True
        self.entities: dict[str, EsphomeEntity] = {}
        self._by_key: dict[tuple[str, tuple[int, int]], str] = {}
        self._info = info
        known = [one for one in listed if one[0] in _BUILDERS and one[1].get("disabled_by_default") is not True]
        self.left_out = max(0, len(known) - MAX_ENTITIES)
        for kind, fields in sorted(known[:MAX_ENTITIES], key=lambda one: _ORDER[one[0]]):
            self._add(_BUILDERS[kind](kind, fields), text_of(fields, "object_id")[:_MAX_ID])

    def describe(self, key: str, fallback_name: str) -> GatewayDevice:
        """Return its description.

        Args:
            key: The gateway's key of it.
            fallback_name: What it is called where it does not say.
        """
        info = self._info
        name = text_of(info, "name")
        area = info.get("area")
        owners = _names(info.get("devices"))
        addresses = [text_of(info, "mac_address"), text_of(info, "bluetooth_mac_address")]
        facts = {
            "manufacturer": text_of(info, "manufacturer") or text_of(info, "project_name").partition(".")[0],
            "model": text_of(info, "model"),
            "sw_version": text_of(info, "esphome_version"),
            "project": f"{text_of(info, 'project_name')} {text_of(info, 'project_version')}".strip(),
        }
        return GatewayDevice(
            key,
            text_of(info, "friendly_name") or name or fallback_name,
            tuple(entity.part(part_id, owners.get(entity.key[0], "")) for part_id, entity in self.entities.items()),
            metadata={fact: text for fact, text in facts.items() if text},
            identifiers=identifiers(addresses if any(addresses) else [name]),
            area=(text_of(area, "name") if isinstance(area, dict) else "") or text_of(info, "suggested_area"),
            stale_after=STALE_AFTER_SLEEP if self.sleeps else 0.0,
        )

    def part_of(self, kind: str, state: Fields) -> str | None:
        """Return the id of the part that a state of the component *kind* is of; None for one that was not listed."""
        return self._by_key.get((kind, key_of(state)))

    def entity(self, part_id: str) -> EsphomeEntity:
        """Return the entity of a part.

        Raises:
            RefusedError: There is none.
        """
        if part_id not in self.entities:
            raise RefusedError(f"a command to the part {part_id[:40]!r}", "the device has no such part any more")
        return self.entities[part_id]

    def _add(self, entity: EsphomeEntity, object_id: str) -> None:
        if (entity.kind, entity.key) in self._by_key:
            return
        base = part_id = f"{entity.kind}_{object_id}" if object_id else f"{entity.kind}_{entity.key[1]}"
        number = 1
        while part_id in self.entities:
            number += 1
            part_id = f"{base}_{number}"
        self.entities[part_id] = entity
        self._by_key[entity.kind, entity.key] = part_id


_MAX_ID = 120


def _names(listed: object) -> dict[int, str]:
    rows = listed[:MAX_ENTITIES] if isinstance(listed, list) else []
    return {whole_of(row, "device_id"): text_of(row, "name") for row in rows if isinstance(row, dict)}
