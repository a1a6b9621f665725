"""Devices for programs: JSON with plain values and times in ISO 8601."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from typing import TYPE_CHECKING

from homebot.devices.names import OWNER
from homebot.devices.wording.json_message import fields_of
from homebot.devices.wording.time_format import iso
from homebot.devices.wording.values import plain_value
from homebot.support.strict_json import in_ascii

if TYPE_CHECKING:
    from homebot.devices import Device, State


def json_text(device: Mapping[str, object]) -> str:
    """Return *device* as indented ASCII JSON text, in a tenth of the standard library's time."""
    from pydantic_core import to_json  # noqa: PLC0415 - for JSON alone

    return in_ascii(to_json(device, indent=2).decode())


def list_text(devices: Sequence[str]) -> str:
    """Return the JSON list of *devices*, which are texts of :func:`json_text`."""
    if not devices:
        return "[]"
    return "[\n  " + ",\n".join(devices).replace("\n", "\n  ") + "\n]"


def device_json(device: Device, waiting: Container[str] = ()) -> dict[str, object]:
    """Return *device* as a JSON object for other programs: with plain values, and times in ISO 8601.

    Args:
        waiting: The ids of the devices that wait for approval.
    """
    first = device.endpoints[0] if device.endpoints else None
    reachable = device.reachable
    return {
        "id": device.id,
        "name": device.name,
        "service_type": device.service_type,
        "gateway": first.gateway if first else "",
        "address": first.address if first else "",
        "first_seen": iso(device.first_seen),
        "last_seen": iso(device.last_seen),
        "expires": iso(device.expires),
        "freshness": device.freshness,
        "endpoints": [{**fields_of(endpoint), "last_seen": iso(endpoint.last_seen)} for endpoint in device.endpoints],
        "metadata": {item.key: item.value for item in device.metadata},
        "service_types": device.service_types,
        "area": device.area,
        "outer_areas": device.outer_areas,
        "tags": device.tags,
        "names": device.names,
        "identifiers": device.identifiers,
        "reachable": {"state": reachable.state, "since": iso(reachable.since), "why": reachable.why},
        "offline_parts": device.offline_parts,
        "parts": fields_of(device)["parts"],
        "states": [_state(state) for state in device.states],
        "events": [_state(event) for event in device.events],
        "facts": [{**fields_of(fact), "said_at": iso(fact.said_at)} for fact in device.facts],
        "evidence": device.evidence,
        "conflicts": device.conflicts,
        "approved": _approval(device, waiting),
    }


def _approval(device: Device, waiting: Container[str]) -> bool | None:
    if device.id in waiting:
        return False
    return True if _is_approved(device) else None


def _is_approved(device: Device) -> bool:
    """Return whether the owner approved *device*, as :func:`homebot.devices.always_ask.is_approved`."""
    return any(fact.name == "approved" and fact.convention == OWNER and not fact.gateway for fact in device.facts)


def _state(state: State) -> dict[str, object]:
    return {
        "part": state.part,
        "capability": state.capability,
        "value": plain_value(state.value),
        "since": iso(state.since),
        "told_at": iso(state.told_at),
        "live": state.live,
    }
