"""Devices as programs read them: JSON with plain values and times in ISO 8601."""

from __future__ import annotations

from homebot.cli.time_format import iso
from homebot.devices.device import Device, State
from homebot.messages.json import message_to_json

__all__ = ["device_json"]


def device_json(device: Device) -> dict[str, object]:
    """Return *device* as a JSON object."""
    first = device.endpoints[0] if device.endpoints else None
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
        "endpoints": [message_to_json(one) for one in device.endpoints],
        "metadata": {one.key: one.value for one in device.metadata},
        "service_types": list(device.service_types),
        "area": device.area,
        "names": list(device.names),
        "identifiers": list(device.identifiers),
        "reachable": {
            "state": device.reachable.state,
            "since": iso(device.reachable.since),
            "why": device.reachable.why,
        },
        "offline_parts": list(device.offline_parts),
        "parts": [message_to_json(one) for one in device.parts],
        "states": [_state(one) for one in device.states],
        "events": [_state(one) for one in device.events],
        "facts": [message_to_json(one) | {"said_at": iso(one.said_at)} for one in device.facts],
        "evidence": list(device.evidence),
        "conflicts": list(device.conflicts),
    }


def _state(state: State) -> dict[str, object]:
    value = state.value.plain()
    return {
        "part": state.part,
        "capability": state.capability,
        "value": list(value) if isinstance(value, tuple) else value,
        "since": iso(state.since),
        "told_at": iso(state.told_at),
        "live": state.live,
    }
