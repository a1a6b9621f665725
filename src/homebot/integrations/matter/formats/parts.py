"""Parts of an endpoint of a Matter node, with their names. Pure.

The tables of device types are the vocabulary's.

Source: Matter 1.5 Device Library; Matter 1.4 Core Specification, 9.5.5 (TagList), 9.8 (Fixed Label), 9.9 (User Label);
Standard Namespaces.
"""

from collections.abc import Iterator, Mapping
from typing import Final

from homebot.conventions.payload import text_of
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability, Part
from homebot.integrations.matter.formats.appliance_clusters import APPLIANCE_ROWS, MODE, MODE_SELECT, is_oven_cabinet
from homebot.integrations.matter.formats.climate_clusters import CLIMATE_ROWS
from homebot.integrations.matter.formats.cluster_row import ClusterRow
from homebot.integrations.matter.formats.endpoint import DESCRIPTOR, TAG_LIST, MatterEndpoint, field_of
from homebot.integrations.matter.formats.light_clusters import LIGHT_ROWS
from homebot.integrations.matter.formats.opening_clusters import OPENING_ROWS
from homebot.integrations.matter.formats.sensor_clusters import BATTERY, PLAIN, SENSOR_ROWS
from homebot.support.numbers import whole_number

_ROWS: Final = (*LIGHT_ROWS, *OPENING_ROWS, *CLIMATE_ROWS, *APPLIANCE_ROWS, *SENSOR_ROWS)
_SERVICE_TYPES: Final[Mapping[int, str]] = {
    number: device_type.name for device_type in DEVICE_TYPES.values() for number in device_type.matter
}
_METER: Final = "electrical_meter"
_CAPABILITY_TYPES: Final = {
    "occupancy": "occupancy_sensor",
    "movement": "closure",
    "position": "closure",
    "tilt": "closure",
    "number": "x_setting",
    "option": "x_setting",  # of an appliance too: a command to turn all switches off must not stop a freezer
    **dict.fromkeys(("color", "color_temperature", "level"), "light"),  # some dimmers say that they are remote controls
    "on_off": "switch",
    "press": "generic_switch",
    "power": _METER,
    "energy": _METER,
    "temperature": "temperature_sensor",
    "humidity": "humidity_sensor",
}
"""By capability: the type of an endpoint with unknown device types."""

_NAMES: Final = {
    0x0017: "solar power",
    0x0018: "battery storage",
    0x0027: "mode select",
    0x0040: "irrigation system",
    0x0070: "refrigerator",
    0x0071: "cabinet",
    0x0073: "laundry washer",
    0x0075: "dishwasher",
    0x0077: "cooktop",
    0x0078: "cooktop",
    0x0079: "microwave oven",
    0x007B: "oven",
    0x007C: "laundry dryer",
    0x050C: "car charger",
}
"""By device type: the name that people and policies use for a device without a type in the vocabulary."""

_UTILITIES: Final = frozenset({0x000E, 0x0011, 0x0012, 0x0013, 0x0014, 0x0016, 0x050D})
"""Device types of aggregators, power sources, updates, bridged and root nodes, and energy management."""

USER_LABEL, FIXED_LABEL = 65, 64
_NAMING: Final = frozenset({"name", "label", "button"})
"""The labels that name an endpoint; others say where it is, or describe it."""

_ORIENTATION: Final = "orientation"
_PLACES: Final = frozenset({"top", "bottom", "left", "right", "middle", "center", "upper", "lower", "front", "back"})
"""Orientations on the device itself, such as of one of two sockets; ``North`` is none."""

_NUMBER: Final = 0x07
_NAMESPACES: Final[Mapping[int, tuple[str, ...]]] = {
    0x08: ("left", "right", "top", "bottom", "middle", "row", "column"),
    0x41: ("refrigerator", "freezer"),
    0x43: ("on", "off", "toggle", "up", "down", "next", "previous", "select"),
    0x45: ("lift", "tilt"),
}
"""Common Position, Refrigerator, Switches and Closure Panel: each the words of its tags."""

_COUNTED: Final = frozenset({"row", "column"})
_MAX_NAME_CHARACTERS: Final = 40


def parts_of(endpoint: MatterEndpoint, *, covers: bool = False) -> Iterator[tuple[Part, tuple[ClusterRow, ...]]]:
    """Yield the parts of an endpoint, the main one first; a closure that *covers* is a blind, or a panel of one."""
    by_suffix: dict[str, dict[str, tuple[ClusterRow, Capability]]] = {"": {}}
    for row in _ROWS:
        is_spare = row.spare_part and row.capability in by_suffix[""]
        own = by_suffix.setdefault(row.spare_part if is_spare else row.part, {})
        if row.capability not in own and (capability := row.describe(endpoint)) is not None:
            own[row.capability] = row, capability
    for suffix, described in by_suffix.items():
        rows, capabilities = (
            tuple(row for row, _ in described.values()),
            tuple(capability for _, capability in described.values()),
        )
        if suffix and rows:
            yield _extra_part(endpoint, suffix, capabilities), rows
        elif any(row.read is not None or row.capability == "press" for row in rows):
            yield _main_part(endpoint, capabilities, covers=covers), rows


def _main_part(endpoint: MatterEndpoint, capabilities: tuple[Capability, ...], *, covers: bool) -> Part:
    kinds = [_SERVICE_TYPES[number] for number in endpoint.device_types if number in _SERVICE_TYPES]
    names = {capability.name for capability in capabilities}
    # a meter only if it is, and switches, nothing else
    only_meter = _METER if kinds and "on_off" not in names else ""
    service_type = next((kind for kind in kinds if kind != _METER), only_meter)
    if is_guessed := not service_type:
        service_type = next((kind for name, kind in _CAPABILITY_TYPES.items() if name in names), "x_sensor")
    # such as ``2``, ``top`` or ``column 1 up``
    words = list(dict.fromkeys(_tag_words(endpoint)))
    while len(" ".join(words)) > _MAX_NAME_CHARACTERS:
        words.pop()
    name = next(_label_names(endpoint), "") or " ".join(words)
    return Part(
        id=str(endpoint.id),
        name=name,
        service_type="window_covering" if covers and service_type == "closure" else service_type,
        advertised=_advertised(endpoint),
        guessed=is_guessed,
        capabilities=capabilities,
        fades=any(capability.name == "level" and capability.settable for capability in capabilities),
    )


def _extra_part(endpoint: MatterEndpoint, suffix: str, capabilities: tuple[Capability, ...]) -> Part:
    """Return a part beside the main one: the battery, a filter, a further setting, or a measurement of the air."""
    part_id = f"{endpoint.id}-{suffix}"
    if suffix == BATTERY:
        return Part(id=part_id, service_type="x_battery", category="diagnostic", capabilities=capabilities)
    kind = "air_quality_sensor" if suffix in PLAIN.values() else "x_sensor"
    is_setting = any(capability.settable for capability in capabilities)
    return Part(
        id=part_id,
        name=(suffix == MODE and endpoint.text(MODE_SELECT, 0)) or suffix.replace("_", " ").capitalize(),
        service_type="x_setting" if is_setting else kind,
        advertised=_advertised(endpoint) if is_setting else "",
        capabilities=capabilities,
    )


def _advertised(endpoint: MatterEndpoint) -> str:
    """Return the device types that the vocabulary lacks; the cabinet of an oven is known by its clusters."""
    if is_oven_cabinet(endpoint):
        return "oven"
    unlisted = [
        number for number in endpoint.device_types[:5] if number not in _UTILITIES and number not in _SERVICE_TYPES
    ]
    return ", ".join(sorted(_NAMES.get(number, f"0x{number:04X}") for number in unlisted))  # what ends it counts


def _label_names(endpoint: MatterEndpoint) -> Iterator[str]:
    for struct in (*endpoint.structs(USER_LABEL, 0), *endpoint.structs(FIXED_LABEL, 0)):
        label, value = text_of(field_of(struct, 0, "label")).casefold(), text_of(field_of(struct, 1, "value"))
        if value and (label in _NAMING or (label == _ORIENTATION and value.casefold() in _PLACES)):
            yield value


def _tag_words(endpoint: MatterEndpoint) -> Iterator[str]:
    for struct in endpoint.structs(DESCRIPTOR, TAG_LIST):
        namespace = whole_number(field_of(struct, 1, "namespaceID"))
        tag, label = whole_number(field_of(struct, 2, "tag")), text_of(field_of(struct, 3, "label"))
        if namespace is None or tag is None or tag < 0:
            continue
        known_words = _NAMESPACES.get(namespace, ())
        if namespace == _NUMBER:
            word = label or str(tag)
        elif tag < len(known_words):
            word = f"{known_words[tag]} {label}" if known_words[tag] in _COUNTED and label else known_words[tag]
        else:
            word = label if known_words else ""
        if word:
            yield word
