"""One entry of ``bridge/devices``: the device, its topic and its availability. Pure.

Source: zigbee2mqtt.io, Configuration > Device availability, and Usage > MQTT topics and messages >
zigbee2mqtt/bridge/devices and bridge/info; Zigbee2MQTT 2.14.1.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from homebot.conventions.description import Availability
from homebot.conventions.payload import as_fields, parse_json, shown, text_of
from homebot.errors import InvalidNameError, WireError
from homebot.mqtt.topics import validate_topic


@dataclass(frozen=True, slots=True)
class StateAvailability:
    """A topic with ``{"state":"online"}`` or ``{"state":"offline"}``; old bridges publish the plain text."""

    topic: str

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device is reachable; None for any other payload."""
        if payload in _STATES:
            return _STATES[payload]
        try:
            message = parse_json(payload, _MAX_BYTES)
        except WireError:
            return None
        state = as_fields(message).get("state")
        return _STATES.get(state.encode()) if isinstance(state, str) else None


@dataclass(frozen=True, slots=True)
class BridgeSettings:
    """Settings of a bridge for its devices.

    Attributes:
        has_availability: Whether devices report their availability; that of the others is the bridge's.
        exceptions: The same of single devices, by address.
        areas: The rooms that the user named for Home Assistant (``suggested_area``), by address.
    """

    has_availability: bool = True
    exceptions: Mapping[str, bool] = field(default_factory=dict)
    areas: Mapping[str, str] = field(default_factory=dict)

    def availability(self, base: str, ieee: str, topic: str) -> Availability:
        """Return the availability of the device at *topic*."""
        sources = (StateAvailability(f"{base}/bridge/state"), StateAvailability(f"{topic}/availability"))
        has_own = self.exceptions.get(ieee, self.has_availability)
        return Availability(sources if has_own else sources[:1], mode="all")


def read_bridge_settings(info: Mapping[str, object]) -> BridgeSettings:
    """Return the settings in the ``config`` of ``bridge/info``.

    Raises:
        WireError: It has no config.
    """
    config = info.get("config")
    if not isinstance(config, dict):
        raise WireError(f"bridge/info: config is {shown(config)}, not an object")
    devices = {
        ieee.lower(): options for ieee, options in as_fields(config.get("devices")).items() if isinstance(options, dict)
    }
    return BridgeSettings(
        _is_on(config.get("availability")),
        {
            ieee: _is_on(options["availability"])
            for ieee, options in devices.items()
            if options.get("availability") is not None
        },
        {ieee: area for ieee, options in devices.items() if (area := _area(options.get("homeassistant")))},
    )


_STATES = {b"online": True, b"offline": False}
_MAX_BYTES = 1_024


def _is_on(option: object) -> bool:
    """Return whether it is on; an object without ``enabled`` means on before 2.0."""
    return option.get("enabled", True) is True if isinstance(option, dict) else option is True


def _area(overrides: object) -> str:
    """Return the room among the *overrides* of what a device is announced with to Home Assistant."""
    return _fact_text(as_fields(as_fields(overrides).get("device")).get("suggested_area"))


@dataclass(frozen=True, slots=True)
class BridgeDevice:
    """A device in the bridge's list.

    Attributes:
        ieee: Its address, ``0x`` and 16 lower-case digits.
        is_coordinator: Whether it is the bridge's own radio.
        is_awake: Whether it receives at any time; a device with a battery does not.
        exposes: Its exposes, not yet checked; None if the bridge does not know them (yet).
        has_updates: Whether its firmware can be updated over the air.
        takes_transition: Whether the bridge lists a transition among the model's options.
        bare_endpoints: Numbers of its endpoints without a name.
        endpoint_names: The names of its endpoints, by number; empty for none.
        scenes: Names of the scenes that are stored in it, by number.
    """

    ieee: str
    name: str
    topic: str
    is_coordinator: bool
    is_disabled: bool
    is_awake: bool
    model: str
    exposes: object
    has_updates: bool
    takes_transition: bool
    bare_endpoints: frozenset[str]
    endpoint_names: Mapping[str, str]
    scenes: Mapping[int, str]
    facts: Mapping[str, str]


def ieee_address(entry: object) -> str:
    """Return the address of an entry; empty for none."""
    address = as_fields(entry).get("ieee_address")
    return address.lower() if isinstance(address, str) and _ADDRESS.fullmatch(address.lower()) else ""


def read_bridge_device(base: str, entry: Mapping[str, object]) -> BridgeDevice:
    """Return the device of an entry with an address.

    Raises:
        WireError: It has no friendly name, or one that cannot be a topic of its own.
    """
    ieee, name = ieee_address(entry), entry.get("friendly_name")
    if not isinstance(name, str) or not 0 < len(name) <= _MAX_NAME:
        raise WireError(f"{ieee}: friendly_name is {shown(name)}, not a name of at most {_MAX_NAME} characters")
    levels = name.split("/")
    if levels[0] == "bridge" or levels[-1] in _COMMANDS:
        raise WireError(f"{ieee}: friendly_name {shown(name)} gives one of the bridge's own topics")
    topic = f"{base}/{name}"
    try:
        validate_topic(topic)
    except InvalidNameError as error:
        raise WireError(f"{ieee}: friendly_name {shown(name)} cannot be a topic: {error}") from None
    definition = as_fields(entry.get("definition"))
    listed = as_fields(entry.get("endpoints"))
    called = {number: _fact_text(as_fields(endpoint).get("name")) for number, endpoint in listed.items()}
    options = definition.get("options")
    takes_transition = True  # of an old bridge, which lists no options
    if isinstance(options, list):
        takes_transition = any(as_fields(option).get("name") == "transition" for option in options[:_MAX_OPTIONS])
    database_facts = {fact: _fact_text(entry.get(key)) for fact, key in {**_ENTRY_FACTS, **_MORE_FACTS}.items()}
    known = {fact: _fact_text(definition.get(key)) for fact, key in _DEFINITION_FACTS.items()}
    interview = _fact_text(entry.get("interview_state"))
    states = {
        "interview": "" if interview in _INTERVIEWED else interview.lower(),
        "supported": "no" if entry.get("supported") is False else "",
    }
    return BridgeDevice(
        ieee=ieee,
        name=name,
        topic=topic,
        is_coordinator=entry.get("type") == "Coordinator",
        is_disabled=entry.get("disabled") is True,
        is_awake=entry.get("power_source") != "Battery",
        model=_fact_text(definition.get("model")),
        exposes=definition.get("exposes"),
        has_updates=definition.get("supports_ota") is True,
        takes_transition=takes_transition,
        bare_endpoints=frozenset(listed.keys() - called.values()),
        endpoint_names=called,
        scenes=_scenes(listed),
        facts={fact: text for facts in (database_facts, known, states) for fact, text in facts.items() if text},
    )


_ADDRESS = re.compile("0x[0-9a-f]{16}")
_COMMANDS = ("get", "set", "availability")
_MAX_NAME = 512
_MAX_FACT = 255


def _scenes(endpoints: Mapping[str, object]) -> dict[int, str]:
    """Return the scenes of all *endpoints*; each is recalled by its number alone."""
    listed = (as_fields(endpoint).get("scenes") for endpoint in endpoints.values())
    scenes = [as_fields(scene) for scenes in listed if isinstance(scenes, list) for scene in scenes[:_MAX_SCENES]]
    return {number: _fact_text(scene.get("name")) for scene in scenes if type(number := scene.get("id")) is int}


_MAX_SCENES = 256
_MAX_OPTIONS = 1_000
_DEFINITION_FACTS = {"manufacturer": "vendor", "model": "description", "model_id": "model"}
_ENTRY_FACTS = {"manufacturer": "manufacturer", "model_id": "model_id"}
_MORE_FACTS = {"sw_version": "software_build_id", "power_source": "power_source", "zigbee_type": "type"}
_INTERVIEWED = ("", "SUCCESSFUL")


def _fact_text(value: object) -> str:
    return text_of(value, _MAX_FACT)
