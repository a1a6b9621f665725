"""The resources of simulated Hue devices, rooms and scenes. Pure.

Source: Philips Hue, CLIP API v2 reference.
"""

import math
from collections.abc import Iterable, Mapping
from typing import Final, TypeAlias
from uuid import NAMESPACE_DNS, uuid5

from homebot.devices.identity import in_pairs
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import hardware_address, lamp_order, mired_kelvin, scaled

Resource: TypeAlias = dict[str, object]

CHANGED: Final = "2026-01-01T00:00:00.000Z"
_MIREKS: Final = (153, 454)
_EFFECTS: Final = ["no_effect", "candle", "fire", "prism"]
_GAMUT: Final = {
    "red": {"x": 0.6915, "y": 0.3083},
    "green": {"x": 0.17, "y": 0.7},
    "blue": {"x": 0.1532, "y": 0.0475},
}
_GRADIENT: Final = {
    "points": [],
    "mode": "interpolated_palette",
    "points_capable": 5,
    "mode_values": ["interpolated_palette", "interpolated_palette_mirrored", "random_pixelated"],
    "pixel_count": 10,
}
_SERVICES: Final[Mapping[str, tuple[str, ...]]] = {
    "lamp": ("light",),
    "plug": ("light",),
    "gradient": ("light",),
    "motion": ("motion", "device_power"),
    "lux": ("light_level", "device_power"),
    "contact": ("contact", "tamper", "device_power"),
}
"""By kind: the house's, ``plug``, at which there is a lamp, and ``gradient``, a lamp with several colours."""

_PRODUCTS: Final = {
    "lamp": ("LCA001", "Hue color lamp", "sultan_bulb"),
    "plug": ("LOM001", "Hue smart plug", "plug"),
    "gradient": ("LCX004", "Hue gradient lightstrip", "hue_lightstrip"),
    "motion": ("SML003", "Hue motion sensor", "unknown_archetype"),
    "lux": ("SML003", "Hue motion sensor", "unknown_archetype"),
    "contact": ("SOC001", "Hue secure contact sensor", "unknown_archetype"),
    "bridge": ("BSB002", "Hue Bridge", "bridge_v2"),
}


def resource_uuid(*names: str) -> str:
    """Return an id that is the same in every run."""
    return str(uuid5(NAMESPACE_DNS, "/".join(names)))


def radio_address(device: SimulatedDeviceInfo) -> str:
    """Return the address of a device in the radio network, in pairs of digits."""
    return in_pairs(hardware_address(device, 16))


def device_resources(device: SimulatedDeviceInfo, kind: str, state: DeviceState) -> list[Resource]:
    """Return a device and its services, all reachable."""
    owner = {"rid": resource_uuid(device.home, device.device_id), "rtype": "device"}
    services = [
        _base(device, kind_of_service, owner)
        | _FIXED.get("plug" if kind == "plug" else kind_of_service, {})
        | state_fields(kind_of_service, kind, state)
        for kind_of_service in (*_SERVICES[kind], "zigbee_connectivity")
    ]
    for service in services:
        if service["type"] == "zigbee_connectivity":
            service |= {"status": "connected", "mac_address": radio_address(device)}
        if kind == "gradient" and service["type"] == "light":
            service["gradient"] = dict(_GRADIENT)
        if service["type"] == "light":
            service |= {"metadata": {"name": device.device_id, "archetype": _PRODUCTS[kind][2], "function": "mixed"}}
    return [_device(owner["rid"], device.device_id, kind, services), *services]


def bridge_resources(bridge_id: str, name: str) -> list[Resource]:
    """Return the bridge as a device with its services."""
    owner = {"rid": resource_uuid(bridge_id), "rtype": "device"}
    own = {"id": resource_uuid(bridge_id, "bridge"), "owner": owner, "type": "bridge", "bridge_id": bridge_id}
    radio: Resource = {
        "id": resource_uuid(bridge_id, "zigbee"),
        "owner": owner,
        "type": "zigbee_connectivity",
        "status": "connected",
        "mac_address": in_pairs(bridge_id),
    }
    services: list[Resource] = [{**own, "time_zone": {"time_zone": "Europe/Berlin"}}, radio]
    return [_device(owner["rid"], name, "bridge", services), *services]


def group_resources(kind: str, name: str, children: Iterable[tuple[str, str]], archetype: str) -> list[Resource]:
    """Return a room, zone or the whole home with its *children*, ids and types, and its grouped light."""
    rid = resource_uuid(kind, name)
    grouped = resource_uuid(kind, name, "grouped_light")
    group: Resource = {
        "id": rid,
        "type": kind,
        "children": [{"rid": child, "rtype": child_type} for child, child_type in children],
        "services": [{"rid": grouped, "rtype": "grouped_light"}],
    }
    if kind != "bridge_home":
        group["metadata"] = {"name": name, "archetype": archetype}
    light: Resource = {
        "id": grouped,
        "type": "grouped_light",
        "owner": {"rid": rid, "rtype": kind},
        "on": {"on": False},
        "dimming": {"brightness": 0.0},
        "dimming_delta": {},
        "alert": {"action_values": ["breathe"]},
        "signaling": {"signal_values": ["no_signal", "on_off"]},
        "dynamics": {},
    }
    return [group, light]


def scene_resource(room: str, name: str, lights: Iterable[str], brightness: float) -> Resource:
    """Return a scene of a room that lights all of its lamps."""
    action = {"on": {"on": True}, "dimming": {"brightness": brightness}}
    return {
        "id": resource_uuid("scene", room, name),
        "type": "scene",
        "actions": [{"target": {"rid": light, "rtype": "light"}, "action": action} for light in lights],
        "metadata": {"name": name},
        "group": {"rid": resource_uuid("room", room), "rtype": "room"},
        "palette": {"color": [], "dimming": [], "color_temperature": [], "effects": []},
        "speed": 0.5,
        "auto_dynamic": False,
        "recall": {},
        "status": {"active": "inactive"},
    }


def state_fields(service: str, kind: str, state: DeviceState) -> Resource:
    """Return the fields of a service that a state decides."""
    match service:
        case "light":
            if kind == "plug":
                return {"on": {"on": state.is_on}}
            mirek = min(max(round(1e6 / state.kelvin), _MIREKS[0]), _MIREKS[1])
            schema = {"mirek_minimum": _MIREKS[0], "mirek_maximum": _MIREKS[1]}
            return {
                "on": {"on": state.is_on},
                "dimming": {"brightness": round(state.brightness * 100, 2), "min_dim_level": 0.2},
                "color_temperature": {"mirek": mirek, "mirek_valid": True, "mirek_schema": schema},
            }
        case "motion":
            on = state.text in {"motion", "on", "1", "occupied"}
            return {"motion": {"motion": on, "motion_valid": True, "motion_report": {"changed": CHANGED, "motion": on}}}
        case "light_level":
            level = round(10_000 * math.log10(state.value) + 1) if state.value >= 1 else 0
            report = {"light_level_report": {"changed": CHANGED, "light_level": level}}
            return {"light": {"light_level": level, "light_level_valid": True, **report}}
        case "contact":
            closed = "contact" if state.text in {"closed", "off"} else "no_contact"
            return {"contact_report": {"changed": CHANGED, "state": closed}}
        case _:
            return {}


def light_orders(body: Mapping[str, object]) -> tuple[str, ...]:
    """Return the commands to a lamp for a request."""
    fields = {name: value if isinstance(value, dict) else {} for name, value in body.items()}
    is_on = fields.get("on", {}).get("on")
    return lamp_order(
        is_on=is_on if isinstance(is_on, bool) else None,
        brightness=scaled(fields.get("dimming", {}).get("brightness"), 100),
        kelvin=mired_kelvin(fields.get("color_temperature", {}).get("mirek")),
    )


def _base(device: SimulatedDeviceInfo, service: str, owner: Mapping[str, str]) -> Resource:
    return {"id": resource_uuid(device.home, device.device_id, service), "owner": dict(owner), "type": service}


def _device(rid: str, name: str, kind: str, services: Iterable[Resource]) -> Resource:
    model, product, archetype = _PRODUCTS[kind]
    return {
        "id": rid,
        "type": "device",
        "metadata": {"name": name, "archetype": archetype},
        "product_data": {
            "model_id": model,
            "manufacturer_name": "homebot",
            "product_name": product,
            "product_archetype": archetype,
            "certified": True,
            "software_version": "1.104.2",
        },
        "identify": {},
        "services": [{"rid": service["id"], "rtype": service["type"]} for service in services],
    }


_FIXED: Final[Mapping[str, Resource]] = {
    "light": {
        "identify": {},
        "dimming_delta": {},
        "color_temperature_delta": {},
        "color": {"xy": {"x": 0.4573, "y": 0.41}, "gamut": _GAMUT, "gamut_type": "C"},
        "dynamics": {
            "status": "none",
            "status_values": ["none", "dynamic_palette"],
            "speed": 0.0,
            "speed_valid": False,
        },
        "alert": {"action_values": ["breathe"]},
        "signaling": {"signal_values": ["no_signal", "on_off"]},
        "mode": "normal",
        "effects": {"status": "no_effect", "status_values": _EFFECTS, "effect_values": _EFFECTS},
        "effects_v2": {
            "action": {"effect_values": _EFFECTS},
            "status": {"effect": "no_effect", "effect_values": _EFFECTS},
        },
        "powerup": {
            "preset": "safety",
            "configured": True,
            "on": {"mode": "on", "on": {"on": True}},
            "dimming": {"mode": "dimming", "dimming": {"brightness": 100.0}},
            "color": {"mode": "color_temperature", "color_temperature": {"mirek": 366}},
        },
    },
    "plug": {"identify": {}, "alert": {"action_values": ["breathe"]}, "mode": "normal"},
    "motion": {"enabled": True, "sensitivity": {"status": "set", "sensitivity": 2, "sensitivity_max": 4}},
    "light_level": {"enabled": True},
    "contact": {"enabled": True},
    "tamper": {"tamper_reports": [{"changed": CHANGED, "source": "battery_door", "state": "not_tampered"}]},
    "device_power": {"power_state": {"battery_level": 90, "battery_state": "normal"}},
}
