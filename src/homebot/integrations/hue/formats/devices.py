"""Devices of a Hue bridge, with their parts, made of its resources. Pure."""

from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from itertools import count
from types import MappingProxyType
from typing import Final, NamedTuple

from homebot.conventions.capability_row import described
from homebot.conventions.payload import as_fields, text_of
from homebot.devices.identity import identifiers, in_pairs
from homebot.devices.part import Category, Part, SceneValue
from homebot.devices.value import Value
from homebot.integrations.hue.formats.resources import Fields, HueResources, HueRow, at
from homebot.integrations.hue.formats.service_rows import BUTTON_KINDS, MOTION_KINDS, SERVICE_ROWS
from homebot.support.numbers import whole_number

_TYPES: Final[Mapping[str, tuple[str, Category]]] = {
    "light": ("light", ""),
    **dict.fromkeys(MOTION_KINDS, ("occupancy_sensor", "")),
    "temperature": ("temperature_sensor", ""),
    "light_level": ("light_sensor", ""),
    "contact": ("contact_sensor", ""),
    "tamper": ("x_binary_sensor", "diagnostic"),
    "device_power": ("x_battery", "diagnostic"),
    **dict.fromkeys((*BUTTON_KINDS, "relative_rotary"), ("generic_switch", "")),
    "grouped_light": ("light", ""),
    "scene": ("x_scene", ""),
    "smart_scene": ("x_scene", ""),
}
"""By type of resource: type and category of the part."""

_DEVICES: Final = frozenset({"device", "motion_area_configuration"})
"""The latter is a room or zone with lights that notice motion."""

_GROUPS: Final = ("room", "zone", "bridge_home")

_FACTS: Final = {
    "manufacturer": "manufacturer_name",
    "model": "product_name",
    "model_id": "model_id",
    "sw_version": "software_version",
}
_PLAIN: Final = frozenset({"on", "dimming", "color", "color_temperature"})
"""Fields of the actions of scenes of which lamps report the values; not a gradient or an effect."""

_MAX_ACTIONS: Final = 300
_REACHABLE: Final = {"connected": True, "disconnected": False, "connectivity_issue": False}
"""By status in the radio network; other states mean that it only sends, or is still searched for."""


class HueService(NamedTuple):
    """A resource as the part of a device: its id, the part, and the rows of its capabilities."""

    id: str
    part: Part
    rows: tuple[HueRow, ...]


class HueDevice(NamedTuple):
    """A device, or the scenes or lights of a room or zone; with the id of its resource.

    Attributes:
        reachable: None if that is unknown.
    """

    id: str
    name: str
    services: tuple[HueService, ...]
    area: str = ""
    identifiers: tuple[str, ...] = ()
    metadata: Mapping[str, str] = MappingProxyType({})
    is_bridge: bool = False
    reachable: bool | None = None


def bridge_identifiers(bridge_id: str) -> tuple[str, ...]:
    """Return the identifiers of the bridge with an id, the EUI-64 of its hardware address: ``001788fffe123456``."""
    return identifiers((bridge_id, in_pairs(bridge_id[:6] + bridge_id[10:])))


def devices_of(resources: HueResources, ids: Collection[str]) -> Iterator[HueDevice]:
    """Yield the devices with these ids, and of each room or zone with one the scenes, and all lights, as one device."""
    for rid in ids:
        device = resources.get(rid)
        if text_of(device.get("type")) in _DEVICES:
            yield _device(resources, rid, device)
            continue
        if device.get("type") in _GROUPS:
            yield from _all_lights(resources, device)
        elif device.get("type") == "grouped_light":
            for _, group in resources.holders(rid, *_GROUPS):
                yield from _all_lights(resources, group)
        if device and (scenes := tuple(resources.holders(rid, "scene", "smart_scene"))):
            children = list(resources.referred(device, "children"))
            devices = (holder for rid, _ in children for holder, _ in resources.holders(rid, "device"))
            members = tuple(f"id:hue:{target}" for target in dict.fromkeys((*(rid for rid, _ in children), *devices)))
            services = tuple(_scene(resources, scene, fields, members) for scene, fields in scenes)
            area = _name(device) if device.get("type") == "room" else ""
            yield HueDevice(rid, f"{_name(device)} scenes".strip(), services, area, identifiers((f"hue:{rid}",)))


def _all_lights(resources: HueResources, group: Fields) -> Iterator[HueDevice]:
    """Yield the group of all lights in a room or zone, or of the bridge: "all lights" would mean those of the house."""
    members = tuple(dict.fromkeys(_lights(resources, group)))
    for rid, light in resources.referred(group, "services"):
        if light.get("type") == "grouped_light" and members:
            service = _service(rid, light, "grouped_light", "", members=members)
            area = _name(group) if group.get("type") == "room" else ""
            yield HueDevice(rid, f"{_name(group) or 'Hue'} lights", (service,), area, identifiers((f"hue:{rid}",)))


def _lights(resources: HueResources, group: Fields) -> Iterator[str]:
    """Yield the lights in a room (its children are devices), a zone (its children are lights), or all rooms."""
    for child, resource in resources.referred(group, "children"):
        if resource.get("type") == "room" and group.get("type") == "bridge_home":
            yield from _lights(resources, resource)
        is_device = resource.get("type") == "device"
        for owner, device in [(child, resource)] if is_device else resources.holders(child, "device"):
            for service in _services(device, tuple(resources.referred(device, "services"))):
                if service.part.advertised == "light" and (is_device or service.id == child):
                    yield f"id:hue:{owner}#{service.part.id}"


def _device(resources: HueResources, rid: str, device: Fields) -> HueDevice:
    services = tuple(resources.referred(device, "services"))
    bridge = next((text_of(service.get("bridge_id")) for _, service in services if service.get("type") == "bridge"), "")
    radio = next((service for _, service in services if service.get("type") == "zigbee_connectivity"), {})
    zones = dict.fromkeys(_name(zone) for service, _ in services for _, zone in resources.holders(service, "zone"))
    group = resources.get(text_of(at(device, "group", "rid")))
    rooms = (*(room for _, room in resources.holders(rid, "room")), group if group.get("type") == "room" else {})
    own = (text_of(radio.get("mac_address")), f"hue:{rid}")
    facts = {fact: text_of(at(device, "product_data", name)) for fact, name in _FACTS.items()}
    facts["tags"] = ", ".join(zones)
    return HueDevice(
        rid,
        _name(device),
        tuple(_services(device, services)),
        _name(rooms[0]),
        (*(bridge_identifiers(bridge) if bridge else ()), *identifiers(own)),
        {name: value for name, value in facts.items() if value},
        bool(bridge),
        _REACHABLE.get(text_of(radio.get("status"))),
    )


def _services(device: Fields, listed: tuple[tuple[str, Fields], ...]) -> Iterator[HueService]:
    """Yield the services that are parts: ``light``, or ``button-1`` and ``button-2`` if there are several."""
    is_plug = "plug" in (at(device, "metadata", "archetype"), at(device, "product_data", "product_archetype"))
    used = [(rid, service, kind) for rid, service in listed if (kind := text_of(service.get("type"))) in _TYPES]
    counts = Counter(kind for _, _, kind in used)
    taken: set[tuple[str, int]] = set()
    for rid, service, kind in used:
        part_id, name = kind, ""
        if counts[kind] > 1:
            own = whole_number(at(service, "metadata", "control_id")) or whole_number(service.get("service_id")) or 1
            number = next(free for free in count(own) if (kind, free) not in taken)
            taken.add((kind, number))
            part_id, name = f"{kind}-{number}", _name(service) or f"{kind.replace('_', ' ').capitalize()} {number}"
        yield _service(rid, service, part_id, name, is_plug=is_plug)


def _scene(resources: HueResources, rid: str, scene: Fields, members: tuple[str, ...]) -> HueService:
    service = _service(rid, scene, rid, _name(scene), members=members)
    values = tuple(_values(resources, scene))
    is_whole = all(as_fields(as_fields(action).get("action")).keys() <= _PLAIN for action in _actions(scene))
    return service._replace(part=service.part.model_copy(update={"values": values if is_whole else ()}))


def _actions(scene: Fields) -> list[object]:
    listed = scene.get("actions")
    return listed[:_MAX_ACTIONS] if isinstance(listed, list) else []


def _values(resources: HueResources, scene: Fields) -> Iterator[SceneValue]:
    """Yield the values that a scene sets on the lamps that the bridge still has."""
    for action in _actions(scene):
        rid = text_of(at(action, "target", "rid"))
        for owner, device in resources.holders(rid, "device"):
            services = _services(device, tuple(resources.referred(device, "services")))
            light = next((service for service in services if service.id == rid), None)
            if light is None:
                continue
            wanted = {"id": rid, "type": "light", **as_fields(at(action, "action"))}
            is_off = at(wanted, "on", "on") is False
            for capability, row in described(SERVICE_ROWS, wanted):
                value = None if row.read is None or (is_off and capability.name != "on_off") else row.read(wanted)
                if value is not None:
                    member = f"id:hue:{owner}#{light.part.id}"
                    yield SceneValue(member=member, capability=capability.name, value=Value.of(value))


def _service(
    rid: str, resource: Fields, part_id: str, name: str, *, is_plug: bool = False, members: tuple[str, ...] = ()
) -> HueService:
    kind = text_of(resource.get("type"))
    service_type, category = _TYPES[kind]
    rows = described(SERVICE_ROWS, resource)
    part = Part(
        id=part_id,
        name=name,
        service_type="plug" if is_plug and kind == "light" else service_type,
        advertised=kind,
        category=category,
        capabilities=tuple(capability for capability, _ in rows),
        members=members,
        fades=kind == "scene"
        or (service_type == "light" and any(capability.name == "level" for capability, _ in rows)),
    )
    return HueService(rid, part, tuple(row for _, row in rows))


def _name(resource: Fields) -> str:
    return text_of(at(resource, "metadata", "name")) or text_of(resource.get("name"))
