"""One Shelly of the second generation or later: its answers, and the description made from them. Pure."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

from homebot.conventions.description import (
    Availability,
    DescribedPart,
    DeviceAnnounced,
    LastWillAvailability,
    Publication,
)
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.payload import as_fields, clean_text, text_of
from homebot.devices.identity import identifiers, in_pairs
from homebot.integrations.shelly.formats.gen2_bluetooth import group_by_address
from homebot.integrations.shelly.formats.gen2_component import (
    BLUETOOTH,
    COMPONENTS,
    Gen2Topics,
    ShellyComponent,
    call,
    components_from,
    page_name,
)
from homebot.integrations.shelly.formats.gen2_parts import (
    LIGHTS,
    SENSORS,
    build_cover,
    build_diffuser,
    build_further,
    build_input,
    build_light,
    build_meters,
    build_own_temperature,
    build_power,
    build_sensor,
    build_switch,
    build_thermostat,
)
from homebot.integrations.shelly.formats.gen2_virtual import (
    CONSUMPTION,
    OF_THERMOSTAT,
    TARGET,
    VALVE_STATE,
    VIRTUAL,
    build_object,
    build_service_thermostat,
    build_valve,
    build_virtual,
    build_virtual_button,
    role_of,
)
from homebot.integrations.shelly.formats.status import Fields
from homebot.support.numbers import to_number

AnswerKind = Literal["info", "config", "status"]

ANSWERS: Mapping[AnswerKind, str] = {
    "info": "Shelly.GetDeviceInfo",
    "config": "Shelly.GetConfig",
    "status": "Shelly.GetStatus",
}
"""Methods of the answers that describe a device, in the order of their calls."""

_OWN_ID = re.compile(r"shelly[a-z0-9]{0,40}-([0-9a-f]{12})", re.IGNORECASE)
_MAX_PREFIX_CHARACTERS = 200
_MAX_EVENTS = 32
_MAX_PAGES = 100
_CHANGES = frozenset({"component_added", "component_removed", "config_changed"})


def is_prefix(prefix: str) -> bool:
    """Return whether *prefix* can be the beginning of a device's topics."""
    return 0 < len(prefix) <= _MAX_PREFIX_CHARACTERS and prefix.isprintable() and not set(prefix) & set("+#$")


def kind_of(result: Fields) -> str:
    """Return the kind of the answer *result*; empty for another one, such as that to a command."""
    if "mac" in result and "id" in result:
        return "info"
    if isinstance(result.get("components"), list):
        return "components"
    system = as_fields(result.get("sys"))
    if "device" in system:
        return "config"
    is_status = "mac" in system or "uptime" in system or any(":" in key for key in result)
    return "status" if is_status else ""


def mac_in(prefix: str) -> str:
    """Return the hardware address in a *prefix* that is a device id, as by default; empty for other prefixes."""
    match = _OWN_ID.fullmatch(prefix)
    return match[1].upper() if match else ""


def is_config_change(params: Fields) -> bool:
    """Return whether the *params* of an event report a changed configuration."""
    events = params.get("events")
    names = [as_fields(event).get("event") for event in events[:_MAX_EVENTS]] if isinstance(events, list) else []
    return any(isinstance(name, str) and name in _CHANGES for name in names)


def sleeps(status: Fields) -> bool:
    """Return whether a device is off the network most of the time, so that silence means nothing."""
    period = to_number(as_fields(status.get("sys")).get("wakeup_period"))
    external = as_fields(as_fields(status.get("devicepower:0")).get("external"))
    runs_on_battery = "devicepower:0" in status and external.get("present") is not True
    return runs_on_battery or (period is not None and period > 0)


MAX_COMPONENTS = 300
"""Most components of one device; a gateway with all possible sensors has about 150."""


def _build_parts(components: Sequence[ShellyComponent]) -> list[JsonPart]:
    """Return the parts of the device itself, the main one first."""
    parts: list[JsonPart] = []
    roles = {role_of(component.config): component for component in components}
    for component in components:
        role = role_of(component.config)
        if role == TARGET:
            parts.append(build_service_thermostat(roles))
        elif role == VALVE_STATE and CONSUMPTION in roles:
            parts.append(build_valve(component, role))
        elif role not in OF_THERMOSTAT or TARGET not in roles:
            for build in _BUILDERS.get(component.kind, ()):
                parts.extend(build(component))
    return parts


def _finish_parts(parts: Sequence[JsonPart], requests: Iterable[Publication]) -> tuple[DescribedPart, ...]:
    """Return the finished *parts*, of which the first requests the state of all."""
    for part in parts[:1]:
        part.add_state_request(*requests)
    return tuple(part.build() for part in parts)


_KEY = re.compile(r"[a-z0-9]{1,20}:[0-9]{1,5}")
_OWN_TEMPERATURE = re.compile("temperature:[0-9]{1,2}")
"""The inside of an energy meter; the sensors of an add-on begin at 100."""

_Build = Callable[[ShellyComponent], tuple[JsonPart, ...]]
_LOAD: tuple[_Build, ...] = (build_meters, build_own_temperature)
_BUILDERS: Mapping[str, tuple[_Build, ...]] = {
    "thermostat": (build_thermostat,),
    "switch": (build_switch, *_LOAD),
    "cover": (build_cover, *_LOAD),
    **dict.fromkeys(LIGHTS, (build_light, *_LOAD)),
    **dict.fromkeys(("pm1", "em", "em1"), (build_meters,)),
    **dict.fromkeys(SENSORS, (build_sensor, build_further, build_own_temperature)),
    "input": (build_input, build_further),
    "devicepower": (build_power,),
    **dict.fromkeys(VIRTUAL, (build_virtual,)),
    "button": (build_virtual_button,),
    "object": (build_object,),
    "cury": (build_diffuser,),
}
_CHANNEL = re.compile(rf"(?:switch|cover|em1|{'|'.join(LIGHTS)}):[0-9]{{1,2}}")
_PHASES = re.compile("em:[0-9]{1,2}")
_RANKS = {kind: rank for rank, kind in enumerate((*_BUILDERS, *BLUETOOTH))}


def _components(topics: Gen2Topics, status: Fields, config: Fields) -> tuple[ShellyComponent, ...]:
    components: list[ShellyComponent] = []
    is_meter = any(key.startswith(("em:", "em1:")) for key in status)
    is_actuator = as_fields(status.get("sys")).get("relay_in_thermostat") is True  # the thermostat switches its relay
    kinds = _RANKS.keys() - ({"switch"} if is_actuator else set())
    loads = as_fields(as_fields(config.get("sys")).get("ui_data")).get("consumption_types")  # of the device's own pages
    for key, fields in status.items():
        if len(components) >= MAX_COMPONENTS:
            break
        if isinstance(fields, dict) and _KEY.fullmatch(key) and key.partition(":")[0] in kinds:
            load = ""
            if key.startswith("switch:") and isinstance(loads, list) and (index := int(key[7:])) < len(loads):
                load = text_of(loads[index]).casefold()
            is_inside = is_meter and _OWN_TEMPERATURE.fullmatch(key) is not None
            components.append(ShellyComponent(topics, key, fields, as_fields(config.get(key)), load, is_inside))
    return tuple(sorted(components, key=lambda component: (_RANKS[component.kind], component.index)))


@dataclass(slots=True)
class Gen2Device:
    """The answers of one device so far.

    Attributes:
        status: The answer to ``Shelly.GetStatus``, or the status sent at wake-up; before both, the reported components.
        added: Components in the answer to ``Shelly.GetComponents``, added by users and gateways.
        pages_asked: Requested further pages of that answer.
        signs_of_life: Messages before its description.
        described: Its last description, and those of the devices behind it, by key.
    """

    prefix: str
    info: Fields = field(default_factory=dict)
    config: Fields = field(default_factory=dict)
    status: Fields = field(default_factory=dict)
    added: Mapping[str, Fields] = field(default_factory=dict)
    pages_asked: int = 0
    sizes: dict[str, int] = field(default_factory=dict)
    signs_of_life: int = 0
    described: dict[str, DeviceAnnounced] = field(default_factory=dict)
    _staged: dict[str, Fields] = field(default_factory=dict)
    _pages: tuple[int, ...] = ()
    _staged_pages: tuple[int, ...] = ()

    def record_answer(self, kind: str, answer: Fields, size: int) -> None:
        """Replace the answer of the *kind* info, config or status; *size* is in bytes."""
        self.sizes[kind] = size
        match kind:
            case "info":
                self.info = answer
            case "config":
                self.config = answer
            case _:
                self.status = answer

    def page_start(self, page: Fields) -> int | None:
        """Return the number at which a *page* of components begins.

        None for a page that is neither the first nor follows the last one: it answers a later request.
        """
        offset = to_number(page.get("offset")) or 0
        return int(offset) if offset in {0, len(self._staged)} else None

    def add_page(self, page: Fields, start: int, size: int) -> int:
        """Add a *page* of *size* bytes; the last page replaces the components.

        Returns:
            The number at which the next page begins; 0 after the last page.
        """
        if not start:
            self._staged, self._staged_pages = {}, ()
        self.sizes[page_name(start)] = size
        listed = page.get("components")
        for component in map(as_fields, listed if isinstance(listed, list) else []):
            if isinstance(key := component.get("key"), str) and len(self._staged) < MAX_COMPONENTS:
                attributes = as_fields(component.get("attrs"))  # the role in a maker's service
                config = {**as_fields(component.get("config")), **attributes}
                self._staged[key] = {"status": component.get("status"), "config": config}
        end = len(self._staged)
        self._staged_pages += (start,) if end > start else ()
        if start < end < min(to_number(page.get("total")) or 0, MAX_COMPONENTS):
            self.pages_asked += 1
            return end if self.pages_asked < _MAX_PAGES else 0
        self.pages_asked = 0
        self.added, self._pages = self._staged, self._staged_pages
        self._staged, self._staged_pages = {}, ()
        return 0

    def _with_added(self, kind: Literal["status", "config"]) -> Fields:
        answer = self.status if kind == "status" else self.config
        return {**{key: as_fields(component.get(kind)) for key, component in self.added.items()}, **answer}

    @property
    def has_status(self) -> bool:
        """True if it reported its whole status."""
        return "status" in self.sizes

    def has_new_fields(self, components: Fields) -> bool:
        """Return whether *components* have fields that are missing in its status."""
        return any(
            isinstance(fields, dict) and not fields.keys() <= as_fields(self.status.get(key)).keys()
            for key, fields in components.items()
        )

    def add_components(self, components: Fields, size: int) -> None:
        """Add reported components to its status; *size* is the stored bytes of all of them."""
        self.sizes["components"] = size
        status = dict(self.status)
        for key, fields in components.items():
            if isinstance(fields, dict) and (key in status or len(status) < MAX_COMPONENTS):
                status[key] = {**as_fields(status.get(key)), **fields}
        self.status = status

    @property
    def mac(self) -> str:
        """Its hardware address; empty if unknown."""
        address = text_of(self.info.get("mac")) or text_of(as_fields(self.status.get("sys")).get("mac"))
        return address or mac_in(self.prefix)

    def describe(
        self, client: str, topic: str, device_id: str, *, needs_parts: bool = False
    ) -> tuple[tuple[DeviceAnnounced, ...], frozenset[str]]:
        """Describe it, and the Bluetooth devices behind it.

        Args:
            topic: The topic of its last message.
            needs_parts: Whether it is no device as long as neither it nor a device behind it has parts.

        Returns:
            The descriptions that are new or changed, and the keys of devices that are gone.
        """
        device_id = text_of(self.info.get("id")) or device_id
        fresh = {announced.key: announced for announced in self._describe_all(client, topic, device_id)}
        if needs_parts and not any(announced.parts for announced in fresh.values()):
            fresh = {}
        changed = {
            key for key, announced in fresh.items() if _fingerprint(announced) != _fingerprint(self.described.get(key))
        }
        gone = frozenset(self.described.keys() - fresh.keys())
        self.described = {key: announced if key in changed else self.described[key] for key, announced in fresh.items()}
        return tuple(self.described[key] for key in fresh if key in changed), gone

    def _describe_all(self, client: str, topic: str, device_id: str) -> Iterator[DeviceAnnounced]:
        models = f"{device_id} {text_of(self.info.get('app'))}".casefold()
        is_plug = any(name in models for name in _PLUGS)
        source = f"{client}/{self.prefix}"
        topics = Gen2Topics(self.prefix, client, f"{source}/rpc", is_plug)
        components = _components(topics, self._with_added("status"), self._with_added("config"))
        pages = [call(self.prefix, source, COMPONENTS, components_from(offset)) for offset in self._pages]
        parts = _build_parts([component for component in components if component.kind not in BLUETOOTH])
        own_id = device_id if device_id.casefold().startswith("shelly") else ""
        configured = as_fields(as_fields(self.config.get("sys")).get("device")).get("name")
        whole = DeviceAnnounced(
            key=self.prefix,
            convention="shelly",
            native=True,
            whole_device=True,
            identifiers=identifiers((in_pairs(self.mac), own_id, *self._channels())),
            name=text_of(self.info.get("name")) or text_of(configured) or clean_text(self.prefix),
            parts=_finish_parts(parts, [call(self.prefix, source, ANSWERS["status"]), *pages]),
            topic=self.described[self.prefix].topic if self.prefix in self.described else topic,
            facts=self._facts(),
            availability=None
            if sleeps(self.status)
            else Availability((LastWillAvailability(f"{self.prefix}/online", b"true", b"false"),)),
            owns=(self.prefix,),
            implies_alive=True,
        )
        yield whole
        for device in group_by_address(component for component in components if component.kind in BLUETOOTH):
            yield whole._replace(
                key=f"{self.prefix}/{device.address}",
                whole_device=False,  # several Shellys may receive it
                identifiers=identifiers((device.address,)),
                name=device.name,
                parts=_finish_parts(device.parts(), pages),
                facts={**device.facts, "via_device": device_id or self.prefix},
                implies_alive=False,
            )

    def _channels(self) -> list[str]:
        """Return the identifiers of its channels, where another program may have each as a device of its own.

        Source: Home Assistant core 2026.1, ``components/shelly/utils.py``: ``get_rpc_device_info``.
        """
        channels = [key for key in self.status if _CHANNEL.fullmatch(key)]
        phases = [f"{key}-{phase}" for key in self.status if _PHASES.fullmatch(key) for phase in "abc"]
        channels_and_phases = [*channels, *phases] if self.mac and len(channels) + len(phases) > 1 else []
        return [f"shelly:{self.mac.upper()}-{key}" for key in channels_and_phases]

    def _facts(self) -> dict[str, str]:
        generation = to_number(self.info.get("gen"))
        facts = {
            "manufacturer": "Shelly",
            "model": text_of(as_fields(self.info.get("jwt")).get("n")) or text_of(self.info.get("model")),
            "model_id": text_of(self.info.get("app")),
            "sw_version": text_of(self.info.get("ver")),
            "generation": "" if generation is None else f"{generation:g}",
        }
        return {name: value for name, value in facts.items() if value}


def _fingerprint(described: DeviceAnnounced | None) -> tuple[object, ...]:
    """Return the fields of a description that are announced after a change."""
    if described is None:
        return ()
    return tuple(part.part for part in described.parts), described.name, described.facts, described.identifiers


_PLUGS = ("plug", "pstrip", "powerstrip", "outdoors")
