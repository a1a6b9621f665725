"""An accessory as a device of the gateway: key, name, facts and identifiers. Pure.

Source: HomeKit Accessory Protocol Specification R2, 8.1 (Accessory Information), 2.5.3.2 (bridges).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from homebot.devices.identity import identifiers, may_be_unique
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.integrations.homekit.formats.accessory import Accessory, HapCharacteristic
from homebot.integrations.homekit.formats.parts import HomekitPart, parts_of
from homebot.integrations.homekit.gateway.port import FoundAccessory

_NAME, _SERIAL = "23", "30"
_FACTS: Final = {"manufacturer": "20", "model": "21", "sw_version": "52", "hw_version": "53"}
_FIRST: Final = 1
"""The accessory ID of a standalone accessory, and of a bridge."""


def key_of(server: str, aid: int) -> str:
    """Return the key of an accessory: the pairing ID of its server, plus its accessory ID behind a bridge."""
    return server if aid == _FIRST else f"{server}.{aid}"


@dataclass(frozen=True, slots=True)
class AccessoryDevice:
    """An accessory, with its accessory ID, device and parts."""

    aid: int
    device: GatewayDevice
    parts: Mapping[str, HomekitPart]

    def find(self, iid: int) -> HapCharacteristic | None:
        """Return a characteristic of its parts, or None for an unknown *iid*."""
        known = (
            characteristic for part in self.parts.values() for characteristic in part.service.characteristics.values()
        )
        return next((characteristic for characteristic in known if characteristic.iid == iid), None)


def describe(sighted: FoundAccessory, accessory: Accessory | None = None) -> AccessoryDevice:
    """Return an accessory as a device; without parts if it is not paired."""
    known = accessory or Accessory(_FIRST)
    key, information, is_first = key_of(sighted.id, known.aid), known.information, known.aid == _FIRST
    parts = {part.part.id: part for part in parts_of(known)}
    texts = {fact: known.information.text(kind) for fact, kind in _FACTS.items()}
    texts["model"] = texts["model"] or sighted.model
    texts["via_device"] = "" if known.aid == _FIRST else sighted.id
    facts = {fact: text for fact, text in texts.items() if text}
    own = "pairing" if is_first else f"aid {known.aid}"
    serial = information.text(_SERIAL)
    device = GatewayDevice(
        key,
        information.text(_NAME) or sighted.name,
        tuple(part.part for part in parts.values()),
        facts,
        identifiers(
            [
                f"homekit {sighted.id.upper()} {own}",
                *([serial] if may_be_unique(serial, facts.get("model", "")) else []),
            ]
        ),
        whole_device=True,
        authenticated=accessory is not None,  # it has proved the key of its pairing
        service_type="" if parts else sighted.service_type,
        raw_address=f"homekit/{key}",
        sleeps=known.sleeps,
    )
    return AccessoryDevice(known.aid, device, parts)
