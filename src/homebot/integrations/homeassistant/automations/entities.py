"""The devices and parts of a house by the ids of their entities in Home Assistant; the context of reading. Pure."""

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final, NamedTuple, TypeAlias, TypeVar, final

from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.devices.device import Device, DevicePart
from homebot.devices.device_names import names_of
from homebot.devices.part import Capability, Part
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.variables import is_constant, resolved
from homebot.messages.builtin_interfaces import Time
from homebot.support.folding import fold
from homebot.support.located import Located
from homebot.words.opening_kinds import opening_kind
from homebot.words.tokens import quoted

_ID: Final = re.compile(r"[a-z_]+\.[a-z0-9_]+")
_LISTED: Final = re.compile(r"(?P<id>[a-z_]+\.[a-z0-9_]+)(?: \((?P<unit>[^)]*)\))?")
_ODD: Final = re.compile(r"[\"\\\n]|: |\b(?:for|in|press|pressed|presses)\b", re.IGNORECASE)
"""Parts of names that mean something else in texts of routines."""

_HELPERS: Final = {
    "input_boolean": ("false", "on_off"),
    "input_number": ("0", "number"),
    "input_button": ("{ button = true }", "press push"),
    "input_datetime": ('{ time = "07:00" }', "text"),
    "input_text": ('{ text = "" }', "text"),
    "counter": ("{ counter = 0 }", "number"),
    "timer": ('{ timer = "10m" }', "on_off press number"),
}
"""How a helper is written that the house lacks, and its capabilities."""

_OF_HELPERS: Final = _HELPERS.keys() | {"input_select", "schedule"}

_SENSED: Final = r"(?:attributes|binary_sensor|device_tracker|person|sun|weather|zone)"
_COMMANDED: Final = re.compile(rf"\bstates(?!\(|\.{_SENSED}\b)|['\"](?!{_SENSED}\.)[a-z_]+\.[a-z]|_entities\(")
"""The parts of a template that a command may change at once."""

_OF_GROUPS: Final = frozenset({"binary_sensor", "fan", "input_boolean", "light", "siren", "switch"})
"""The domains of members of groups that are on or off."""

_SENSORS: Final = {"binary_sensor": True, "sensor": False}
"""Whether they measure a truth value."""

_NAMES: Final[Mapping[str, tuple[str, ...]]] = {
    "press": ("action",),
    "contact": ("opening", "door", "window"),
    "occupancy": ("motion", "presence"),
    "water_leak": ("moisture", "leak"),
    "illuminance": ("illuminance_lux", "lux"),
    "battery": ("battery_level",),
    "temperature": ("air_temperature",),
    "humidity": ("relative_humidity",),
}
"""Other names of capabilities in ids of sensors; they count if no entity is called so itself."""

_CONTROLS: Final = {
    "light": ("light", "on_off"),
    "switch": ("switch plug pump", "on_off"),
    "fan": ("fan", "on_off fan_speed"),
    "siren": ("siren", "on_off"),
    "humidifier": ("x_humidifier", "on_off"),
    "media_player": ("speaker video_player", "playback on_off volume"),
    "cover": ("window_covering closure", "movement position"),
    "lock": ("door_lock", "lock"),
    "valve": ("water_valve", "valve position"),
    "lawn_mower": ("x_lawn_mower", "mower"),
    "water_heater": ("x_water_heater", "water_heater_mode heating_setpoint on_off"),
    "climate": ("thermostat room_air_conditioner", "thermostat_mode heating_setpoint cooling_setpoint"),
    "vacuum": ("robotic_vacuum_cleaner", "vacuum"),
    "alarm_control_panel": ("x_alarm_panel", "alarm"),
    "person": ("x_person x_tracker", "place at_home"),
    "device_tracker": ("x_tracker", "place"),
    "event": ("generic_switch", "press"),
    "scene": ("x_scene", "scene"),
    "button": ("x_setting", "push"),
    "number": ("x_setting", "number"),
    "select": ("x_setting", "option"),
    "input_boolean": ("x_setting", "on_off"),
    "input_button": ("x_setting", "push"),
    "input_select": ("x_setting", "option"),
    "input_number": ("x_setting", "number"),
    "counter": ("x_setting", "number"),
    "input_datetime": ("x_setting", "text"),
    "input_text": ("x_setting", "text"),
    "schedule": ("x_setting", "on_off"),
    "time": ("x_setting", "text"),
    "timer": ("x_setting", "on_off"),
    "update": ("x_update", "update_available"),
    "weather": ("x_sensor", "value"),
    "sensor": ("", "value"),
}
"""The types of the parts that are entities of a domain, and their capabilities: the first one tells the state."""

_CLASSES: Final = {
    **{kind: ("contact", kind) for kind in ("door", "garage_door", "window")},
    "opening": ("contact", ""),
    **dict.fromkeys(("motion", "presence", "occupancy"), ("occupancy", "")),
    "moisture": ("water_leak", ""),
}
"""The capability of sensors of a class, and the kind of opening that their device must be."""

_BY_KIND: Final = {
    **dict.fromkeys(("open", "opened", "closed"), "contact"),
    **dict.fromkeys(("motion", "occupied", "present"), "occupancy"),
    **dict.fromkeys(("moist",), "water_leak"),
    **dict.fromkeys(("battery_level",), "battery"),
}
"""The capability of a sensor by the word for it in a trigger or condition of its device, if it has another name."""

_USUAL: Final[Mapping[str, tuple[float, float]]] = {
    "heating_setpoint": (3.0, 40.0),
    "cooling_setpoint": (3.0, 40.0),
    "color_temperature": (1_000.0, 12_000.0),
}
"""Limits of devices that declare none: a number in another unit is beyond them."""

_UNSEEN: Final = Time(sec=0, nanosec=0)


class _Meant(NamedTuple):
    device: Device
    part: DevicePart
    capability: str


_OF_PERSONS: Final = re.compile("famil|household|people|person|resident|everyone|everybody|bewohner")
_ASKED: Final = re.compile(r"\b(?:name|id)=")
_COMPARED: Final = re.compile(r" of (?:name|id)=")


def is_of_device(text: str) -> bool:
    """Return whether the condition *text* asks for a device."""
    return _ASKED.search(text) is not None


def is_of_two_values(text: str) -> bool:
    """Return whether the condition *text* compares values, and is no query."""
    return _COMPARED.search(text) is not None


class KnownEntity(NamedTuple):
    """An entity with the part that it is in homebot.

    Attributes:
        capability: What a sensor measures; empty for anything else.
        name: The name that means its device alone.
        unit: Its unit in Home Assistant, if that is another than homebot's; empty otherwise.
    """

    id: str
    device: Device
    part: DevicePart
    capability: str
    name: str
    unit: str = ""

    @property
    def domain(self) -> str:
        """The domain, such as ``light``."""
        return self.id.partition(".")[0]

    @property
    def query(self) -> str:
        """The query that means its device alone: an id that reads like a name which others have is asked as an id."""
        is_shared = self.name != self.device.name and fold(self.name) == fold(self.device.name)
        return f"{'id' if is_shared else 'name'}={text_value(self.name)}"

    @property
    def controls(self) -> list[str]:
        """The capabilities that entities of its domain may have; the first one tells its state."""
        return _CONTROLS.get(self.domain, ("", ""))[1].split()

    def has(self, name: str) -> bool:
        """Return whether its part tells a capability."""
        return (capability := self._capability(name)) is not None and capability.readable

    def takes(self, name: str) -> bool:
        """Return whether its part takes a capability."""
        return (capability := self._capability(name)) is not None and capability.settable

    def options(self, name: str) -> tuple[str, ...]:
        """Return the texts of a capability: those of its part, else all that homebot knows."""
        capability = self._capability(name)
        return (capability.options if capability else ()) or CAPABILITIES.get(name, OWN).options or ()

    def bounds(self, name: str) -> tuple[float, ...]:
        """Return the limits of a capability of its part, else all that homebot knows; empty for none."""
        capability = self._capability(name)
        return (capability.bounds if capability else ()) or CAPABILITIES.get(name, OWN).bounds or _USUAL.get(name, ())

    def _capability(self, name: str) -> Capability | None:
        return next((capability for capability in self.part.part.capabilities if capability.name == name), None)


@final
class Entities:
    """The entities that the gateway of Home Assistant lists, and those whose name leads to one device alone.

    Home Assistant makes ids of the names of devices and entities, unless their owner changes one of them later.

    Attributes:
        used: Those that were found since it was last emptied, by id.
        notes: Assumptions since then, for people.
        marks: The helpers that have the date of the last run of the automation that is read, and are not set here, with
            whether they have the time of day too.

    Args:
        groups: The members of groups that files define, by the ids of these.
    """

    def __init__(self, devices: Sequence[Device], groups: Mapping[str, Sequence[str]] | None = None) -> None:
        self._devices = devices
        self._groups = groups or {}
        self._names = Counter(name for device in devices for name in _names(device))
        self._listed = {entity: (device, unit) for device in devices for entity, unit in _listed(device).items()}
        self._named: dict[str, dict[tuple[str, str, str], _Meant]] = {}
        self._also_named: dict[str, dict[tuple[str, str, str], _Meant]] = {}
        for device in devices:
            for domain in (*_CONTROLS, *_SENSORS):
                for slug, meant, is_own in _by_slug(device, domain):
                    key = device.id, meant.part.id, meant.capability
                    (self._named if is_own else self._also_named).setdefault(f"{domain}.{slug}", {})[key] = meant
        self.used: dict[str, KnownEntity] = {}
        self.notes: list[str] = []
        self.marks: Mapping[str, bool] = {}

    def find(self, entity_id: str) -> KnownEntity:
        """Return the entity *entity_id*."""
        if entity_id in self.marks:
            raise NotCarriedError(f"{entity_id} has the time of the last run, which a routine asks only how long ago")
        if entity_id not in self.used:
            if not _ID.fullmatch(entity_id):
                raise NotCarriedError(f"{entity_id!r} is no id of an entity, such as light.hall")
            device, unit = self._listed.get(entity_id, (None, ""))
            named = [*(self._named.get(entity_id) or self._also_named.get(entity_id, {})).values()]
            meant = self._of_listed(entity_id, named, device) if device else self._of_named(entity_id, named)
            if len(meant) != 1:
                is_known = device is not None or meant
                problem = "may be several parts of what homebot knows" if is_known else "is nothing that homebot knows"
                raise NotCarriedError(f"{entity_id} {problem}{_advice(entity_id)}")
            self.used[entity_id] = KnownEntity(entity_id, *meant[0], self.name_of(meant[0].device), unit)
        return self.used[entity_id]

    def _of_named(self, entity_id: str, named: Sequence[_Meant]) -> Sequence[_Meant]:
        """Return those of *named*, to which the name of a device leads, that are meant: no other device has helpers."""
        if entity_id.partition(".")[0] in _OF_HELPERS:
            return [entity for entity in named if _is_of_helpers(entity.device)] or self._lacked(entity_id)
        return [entity for entity in named if entity.part.part.service_type == "x_person"] or named

    def _of_listed(self, entity_id: str, named: Sequence[_Meant], device: Device) -> Sequence[_Meant]:
        """Return the parts of *device*, which Home Assistant lists with the entity, that are meant."""
        domain, _, name = entity_id.partition(".")
        meant, possible = [entity for entity in named if entity.device is device], [*_possible(device, domain)]
        siblings = [listed for listed in _listed(device) if listed.startswith(f"{domain}.")]
        if not meant and len(siblings) == len(possible) == 1:
            return possible
        return meant if len(meant) == 1 else [entity for entity in possible if slug_of(entity.part.part.name) == name]

    def knows(self, entity_id: str) -> bool:
        """Return whether the name of a device leads to *entity_id*."""
        return entity_id in self._named

    def _lacked(self, entity_id: str) -> list[_Meant]:
        """Return the helper *entity_id*, which people have yet to write; none if its name means another device."""
        domain, _, slug = entity_id.partition(".")
        name, (written, able) = slug.replace("_", " "), _HELPERS.get(domain, ("", ""))
        if not written or self._names[fold(name)]:
            return []
        self.notes.append(f"write `{slug} = {written}` or the like in the table [helpers]")
        part = Part(id="", service_type="x_setting", capabilities=tuple(map(_settable, able.split())))
        helper = Device(
            id=slug, name=name, service_type=part.service_type, parts=(DevicePart(id="", part=part, routes=()),),
            endpoints=(), metadata=(), first_seen=_UNSEEN, last_seen=_UNSEEN, expires=_UNSEEN, freshness="stale",
        )  # fmt: skip
        return [_Meant(helper, helper.parts[0], "")]

    def members(self, entity_id: str) -> list[str]:
        """Return the entities of a group that is on if one of them is; none for another entity."""
        members = [*self._groups.get(entity_id, ())]
        return members if all(member.partition(".")[0] in _OF_GROUPS for member in members) else []

    def expanded(self, ids: Iterable[str]) -> list[str]:
        """Return *ids* with the members of groups in the place of these."""
        return [member for entity_id in ids for member in (self.members(entity_id) or [entity_id])]

    def find_of_device(self, entity_id: str, device_id: str, domain: str, kind: str) -> KnownEntity:
        """Return the entity *entity_id*, which may be an id of the registry that only its device explains.

        Args:
            kind: The state that an automation asks for, such as ``is_open``: it tells sensors of one device apart.
        """
        if _ID.fullmatch(entity_id) or entity_id in self.used:
            return self.find(entity_id)
        device = self.device_of(device_id)
        possible = [*_possible(device, domain)]
        words = kind.removeprefix("is_").removeprefix("not_").removeprefix("no_")
        meant = _BY_KIND.get(words, words)
        fitting = [entity for entity in possible if entity.capability == meant] or possible
        if len(fitting) != 1:
            raise NotCarriedError(f"{device.name} has several entities of {domain}; name the one that is meant")
        known = KnownEntity(f"{domain}.{slug_of(device.name)}", *fitting[0], self.name_of(device))
        self.used[entity_id] = known
        return known

    def device_of(self, device_id: str) -> Device:
        """Return the device with the id *device_id* of Home Assistant."""
        known = [device for device in self._devices if any(route.key == device_id for route in device.endpoints)]
        if len(known) != 1:
            raise NotCarriedError(f"the device {device_id!r} is not known; its id is of the gateway of Home Assistant")
        return known[0]

    def device_called(self, slug: str) -> Device:
        """Return the device with buttons and the name *slug* in ids, perhaps with the kind of the button behind it."""
        names = {slug, slug.removesuffix("_button")}
        known = [device for device in self._devices if names & {*map(slug_of, _names(device))} and _has_event(device)]
        if len(known) != 1:
            raise NotCarriedError(f"the device {slug!r} is no button that homebot knows")
        return known[0]

    def device_at(self, address: str) -> Device | None:
        """Return the device of MQTT that tells its values at *address*; None for none, or several."""
        known = [device for device in self._devices if any(route.address == address for route in device.endpoints)]
        return known[0] if len(known) == 1 else None

    def commanded_at(self, topic: str) -> Device | None:
        """Return the device of MQTT that takes its commands at *topic*; None for none, or several."""
        known = [
            device
            for device in self._devices
            if any(topic in {end.command_address, f"{end.address}/set"} for end in device.endpoints)
            or any(topic in route.topics for part in device.parts for route in part.routes)
        ]
        return known[0] if len(known) == 1 and topic else None

    def device_by_address(self, address: str) -> Device:
        """Return the device with a radio address, such as ``00:15:8d:00:01:02:03:04``."""
        wanted = _plain_address(address)
        known = [
            device
            for device in self._devices
            if any(_plain_address(route.key) == wanted for route in device.endpoints)
            or any(_plain_address(identifier) == wanted for identifier in device.identifiers)
        ]
        if len(known) != 1 or not wanted:
            raise NotCarriedError(f"the device with the address {address!r} is not known")
        return known[0]

    def name_of(self, device: Device) -> str:
        """Return the name of *device* if it is plain and no other one has it, else its id."""
        is_plain = self._names[fold(device.name)] <= 1 and not _ODD.search(device.name)
        return device.name if is_plain else device.id

    @property
    def knows_people(self) -> bool:
        """True if a household is known."""
        return any(device.service_type == "x_household" for device in self._devices)

    @property
    def people(self) -> int:
        """The number of its persons."""
        return sum(device.service_type == "x_person" for device in self._devices)

    def is_household(self, entity_id: str, *, by_name: bool = False) -> bool:
        """Return whether a group, which is asked for places of persons or is called so, is that of all known ones."""
        members = self._groups.get(entity_id, ())
        is_meant = entity_id.startswith("group.") and (not by_name or _OF_PERSONS.search(entity_id) is not None)
        return is_meant and self.knows_people and len(members) in {0, self.people}

    def of_target(self, domains: Sequence[str], kind: str, place: str) -> list["KnownEntity"]:
        """Return the entities of *domains* that the target *place* means; *kind* is its field."""
        devices = self._devices_at(kind, place)
        known = [entity for device in devices for domain in domains for entity in self._entities_of(device, domain)]
        if not known:
            raise NotCarriedError(f"{kind} {place!r}: homebot knows no {domains[0]} there; name the entities")
        return known

    def of_domain(self, domain: str) -> list["KnownEntity"]:
        """Return all entities of *domain*."""
        return [entity for device in self._devices for entity in self._entities_of(device, domain)]

    def of_class(self, domain: str, classes: Collection[str]) -> list["KnownEntity"]:
        """Return the entities of *domain* whose device is of one of *classes*, or all if these are none."""
        if domain not in _SENSORS:
            return [] if classes else self.of_domain(domain)
        wanted = [_CLASSES.get(name, (name, "")) for name in classes]
        known = []
        for device in self._devices:
            for meant in _possible(device, domain):
                kinds = {kind for capability, kind in wanted if capability == meant.capability}
                if meant.capability and (kinds & {"", opening_kind(device)} or not classes):
                    known.append(KnownEntity(f"{domain}.{slug_of(device.id)}", *meant, self.name_of(device)))
        return known

    def _devices_at(self, kind: str, place: str) -> Iterable[Device]:
        match kind:
            case "device_id":
                return [self.device_of(place)]
            case "area_id":
                room = self.room_of(place)
                return [device for device in self._devices if device.area == room]
            case "label_id":
                return [device for device in self._devices if place in map(slug_of, device.tags)]
        return [device for device in self._devices if place == slug_of(_fact(device, "floor"))]

    def _entities_of(self, device: Device, domain: str) -> Iterator["KnownEntity"]:
        if listed := _listed(device):
            yield from (self.find(entity) for entity in listed if entity.startswith(f"{domain}."))
            return
        for meant in _possible(device, domain) if not _is_of_helpers(device) else ():
            if meant.part.part.category == "" and not meant.capability:
                yield KnownEntity(f"{domain}.{device.id}", *meant, self.name_of(device))

    def room_of(self, area_id: str) -> str:
        """Return the room with the id *area_id* of Home Assistant."""
        areas = {device.area for device in self._devices if device.area}
        areas_found = [area for area in areas if slug_of(area) == area_id]
        if len(areas_found) != 1:
            raise NotCarriedError(f"the area {area_id!r} is no room that homebot knows")
        if others := [area for area in areas if area != areas_found[0] and fold(area).startswith(fold(areas_found[0]))]:
            raise NotCarriedError(f"the area {area_id!r} would mean {others[0]} as well")
        return areas_found[0]


def _plain_address(text: str) -> str:
    """Return the last 16 hexadecimal digits of *text*, in which a radio address is; empty for none."""
    digits = re.sub(r"[:\-\s]|^0x", "", text.casefold().partition("-")[0])
    return digits if re.fullmatch(r"[0-9a-f]{16}", digits) else ""


def text_value(text: str) -> str:
    """Return *text* as a value in a query, in quotation marks that a file of TOML need not escape, if possible."""
    return quoted(text) if set("'\"\\") & set(text) else f"'{text}'"


def slug_of(name: str) -> str:
    """Return *name* as it is in ids."""
    return "_".join(re.findall(r"[a-z0-9]+", fold(name)))


def _names(device: Device) -> set[str]:
    return {*map(fold, names_of(device))}


def _listed(device: Device) -> dict[str, str]:
    """Return the entities of a device that Home Assistant told, with their units there if these differ."""
    texts = [text for fact in device.facts if fact.name == "entities" for text in fact.value.split(", ")]
    return {match["id"]: match["unit"] or "" for match in map(_LISTED.fullmatch, texts) if match}


def _has_event(device: Device) -> bool:
    return any(can.name in EVENTS for part in device.parts for can in part.part.capabilities)


def capability_of_class(name: str) -> str:
    """Return the capability that all sensors of a class have, and no other ones; empty if the device counts too."""
    capability, kind = _CLASSES.get(name, (name, ""))
    return "" if kind or capability not in CAPABILITIES or name == "opening" else capability


def _fact(device: Device, name: str) -> str:
    return next((fact.value for fact in device.facts if fact.name == name), "")


def _settable(name: str) -> Capability:
    return Capability(name=name, settable=name not in EVENTS)


def _is_of_helpers(device: Device) -> bool:
    return any(route.gateway == "helpers" for route in device.endpoints)


def _advice(entity_id: str) -> str:
    """Return how the house gets to know an entity of its kind; empty if nothing special helps."""
    domain, _, name = entity_id.partition(".")
    if domain == "group":
        return "; name its entities in place of the group, or give its file, groups.yaml, beside this one"
    if domain == "person":
        return "; write it in the table [people]"
    if domain == "schedule":
        return f"; write `{name} = false` in [helpers], and routines that turn it on and off at its times"
    if domain == "input_select":
        return f'; write its choices in the table [helpers], like `{name} = ["day", "night"]`'
    return "; a device has the name of this helper: give it another one" if domain in _HELPERS else ""


def _by_slug(device: Device, domain: str) -> Iterator[tuple[str, _Meant, bool]]:
    """Yield the parts of *device* that may be entities of *domain*, by the ends of ids, and whether these are own."""
    names = {slug_of(name) for name in _names(device)}
    possible = [*_possible(device, domain)]
    for own_part in possible:
        part = own_part.part.part
        own = {slug_of(text) for text in (part.name, part.tag, own_part.capability)} - {""}
        ends = {f"_{text}" for text in own} | ({""} if len(possible) == 1 else set())
        yield part.id.removeprefix(f"{domain}_"), own_part, True
        yield from ((f"{name}{end}", own_part, True) for name in names for end in ends)
        is_main = own_part.capability and CAPABILITIES.get(own_part.capability, OWN).sensor == device.service_type
        if is_main:
            yield from ((name, own_part, False) for name in names)
        others = _NAMES.get(own_part.capability, ())
        yield from ((f"{name}_{end}", own_part, False) for name in names for end in others)


def _possible(device: Device, domain: str) -> Iterator[_Meant]:
    """Yield the parts that an entity of *domain* may be."""
    kinds, able = _CONTROLS.get(domain, ("", ""))
    for part in device.parts:
        yield from (_Meant(device, part, name) for name in _measured(part.part, domain))
        abilities = {capability.name for capability in part.part.capabilities}
        if part.part.service_type in kinds.split() and not abilities.isdisjoint(able.split()):
            yield _Meant(device, part, "")


def _measured(part: Part, domain: str) -> Iterator[str]:
    for capability in part.capabilities if domain in _SENSORS else ():
        is_flag = CAPABILITIES.get(capability.name, OWN).kind == "bool" or capability.name == "state"
        if capability.readable and not capability.settable and is_flag is _SENSORS[domain]:
            yield capability.name


T = TypeVar("T")


Condition: TypeAlias = tuple[str, ...]
"""Texts of which at least one must hold. A query is in brackets."""

NEVER: Final[Condition] = ()
"""It does not hold."""


class StartTrigger(NamedTuple):
    """A trigger of an automation in the words of routines.

    Attributes:
        id: Its id, or its number in the automation.
        entity: The entity whose state it is about; empty for another trigger.
        state: The state that begins; empty for another trigger.
        data: The fields of its event, as far as they are known.
        needs: Conditions that must hold beside it.
        asks: The field of its event that a condition asks for by the trigger and its value; empty for none.
    """

    text: str
    id: str = ""
    entity: str = ""
    state: str = ""
    data: tuple[tuple[str, str], ...] = ()
    needs: tuple[Condition, ...] = ()
    asks: str = ""

    def value(self, path: Sequence[str]) -> str | None:
        """Return the value of ``trigger.…`` at *path*, such as ``("trigger", "id")``; None if it is not known."""
        match tuple(path):
            case ("trigger", "id"):
                return self.id
            case ("trigger", "entity_id") | ("trigger", "to_state", "entity_id"):
                return self.entity or None
            case ("trigger", "to_state", "state"):
                return self.state or None
            case ("trigger", "from_state", "state"):
                return dict(self.data).get("from")
            case ("trigger", "for" | "platform" | "event" as field):
                return dict(self.data).get(field)
            case (
                ("trigger", "event", "data", field)
                | ("trigger", "to_state", "attributes", "event_type" as field)
                | ("trigger", "payload" | "above" | "below" as field)
            ):
                return dict(self.data).get(field)
        return None


@dataclass
class Automation:
    """An automation while it is read.

    Attributes:
        names: The names of routines by the ends of ids of automations, and those of scenes.
        problems: All that is not carried over.
        notes: Small differences, for people.
        triggers: Its triggers, once they are read.
        constants: The values of its variables.
        has_waited: Whether its actions waited so far.
        waited: The triggers of its last wait; empty if that is not known, or had none.
        own_ids: The ends of the ids that it may have in Home Assistant.
        expressions: Templates of its variables, until the first step.
        calling: The texts of all automations of its file.
        others: The texts of all others of these, and of the scripts.
    """

    entities: Entities
    names: "NamesOfIds"
    problems: list[NotCarriedError] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    triggers: list[StartTrigger] = field(default_factory=list)
    constants: dict[str, object] = field(default_factory=dict)
    has_waited: bool = False
    waited: list[StartTrigger] = field(default_factory=list)
    own_ids: frozenset[str] = frozenset()
    expressions: dict[str, str] = field(default_factory=dict)
    calling: Sequence[str] = ()
    others: Sequence[str] = ()

    def calls_of(self, script: str) -> int:
        """Return the number of automations that call a script."""
        called = re.compile(rf"\bscript\.{re.escape(script)}\b")
        return sum(1 for text in self.calling if called.search(text))

    def routine_without_waits(self, entity_id: str) -> str:
        """Return the routine with the id of an automation, which ends at once.

        Raises:
            NotCarriedError: It is not known, or waits: the automation that runs it would not wait for its end.
        """
        name = self.names.routine(entity_id)
        if self.waits(name):
            raise NotCarriedError(f"automation.trigger: {name} waits; start it by the trigger of this one too")
        self.notes.append(f"`run routine {name}` runs it beside this one, whatever its conditions")
        return name

    def waits(self, name: str) -> bool:
        """Return whether the automation of the file with this name waits."""
        own = [text for text in self.calling if f"'alias': {name!r}" in text]
        return any("'delay'" in text or "'wait_" in text for text in own)

    def fires(self, event: str) -> bool:
        """Return whether an action of the file sends an event."""
        return any(f"'event': {event!r}" in text for text in {*self.calling, *self.others})

    def keeps_scene(self, entity_id: str) -> bool:
        """Return whether an action of the file makes a scene of the values of now."""
        made = f"'scene_id': {entity_id.removeprefix('scene.')!r}"
        return any(made in text for text in {*self.calling, *self.others})

    def asks_for(self, action: str) -> bool:
        """Return whether an automation of the file asks for a button of messages, beside the message with it."""
        asked = re.compile(rf"""(?:'action(?:Name)?': |== )\\?['"]{re.escape(action)}\\?['"]""")
        return sum(len(asked.findall(text)) for text in {*self.calling, *self.others}) > 1

    def define(self, variables: Located) -> Mapping[str, object]:
        """Define *variables*, and return the values of all that are known by now."""
        if not isinstance(variables.value, dict):
            raise NotCarriedError("variables: they have no names", variables.line)
        for name, node in variables.value.items():
            value = resolved(node, self.constants)
            self.constants.pop(name, None)
            named = re.compile(rf"(?<![.\w'\"]){re.escape(name)}\b")  # those that name it had its former value
            self.expressions = {
                key: text for key, text in self.expressions.items() if not named.search(f"{key} {text}")
            }
            if is_constant(value):
                self.constants[name] = value
            elif isinstance(value.value, str) and not named.search(value.value):
                self.expressions[name] = value.value
        return self.constants

    def forget_values(self, *, by_command: bool = False) -> None:
        """Forget the variables that a step, or only a command, may have changed: not those of the trigger, and time."""
        self.expressions = {
            name: text
            for name, text in self.expressions.items()
            if (by_command and "state" in text and not _COMMANDED.search(text))
            or ("state" not in text.replace("trigger.to_state.", "") and not (self.has_waited and "now()" in text))
        }

    def each(self, nodes: Sequence[Located], what: str, read: Callable[[UnreadFields], T]) -> list[T]:
        """Return the results of *read* for each of *nodes* that is switched on and carried over."""
        results: list[T] = []
        for node in nodes:
            with self.in_line(node.line):
                fields = UnreadFields(node, what)
                if fields.flag("enabled", default=True):
                    results.append(read(fields))
                    fields.end()
        return results

    @contextmanager
    def in_line(self, line: int) -> Iterator[None]:
        """Add refusals to the problems, by default with *line*."""
        try:
            yield
        except UsageError as exc:
            own = exc.line if isinstance(exc, NotCarriedError) else 0
            self.problems.append(NotCarriedError(str(exc), own or line))


class NamesOfIds(NamedTuple):
    """Names that ids of Home Assistant stand for, by these ids without the domain."""

    scenes: Mapping[str, str]
    routines: Mapping[str, str]

    def scenes_of(self, ids: Sequence[str]) -> list[str]:
        """Return the scenes with these ids; none unless all are known."""
        names = [self.scenes.get(entity.removeprefix("scene."), "") for entity in ids]
        return names if all(names) else []

    def routine(self, entity_id: str) -> str:
        """Return the routine with the id of an automation."""
        name = self.routines.get(entity_id.removeprefix("automation."), "")
        if not name or not entity_id.startswith("automation."):
            raise NotCarriedError(f"{entity_id} is no routine that homebot knows; import it first, or in the same file")
        return name
