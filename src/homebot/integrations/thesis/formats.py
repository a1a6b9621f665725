"""The topic layout of the thesis: ``HOME/SERVICE_TYPE/DEVICE_ID/CHANNEL``, with the channels ``out`` and ``in``. Pure.

homebot began as the prototype of a thesis, with devices of plain text on such topics. Only state topics are
subscribed to, so that a command never returns as a state, in any MQTT version. Topics of the home with a wrong number
of levels are subscribed to as well, so that they can be reported.

Source: ``docs/house.md``, the table of devices. An ambiguous word means a controllable device, because every device of
the layout takes commands: ``windows`` are windows with a motor.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings
from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    DeviceWithdrawn,
    Publications,
    TextEndpoint,
)
from homebot.conventions.text_codec import TextCodec
from homebot.devices.device_types import wanted_types
from homebot.devices.part import Capability, Part
from homebot.errors import WireError

_OPENING = ("movement", "position")
_SETTABLE: Mapping[str, tuple[str, ...]] = {
    "light": ("on_off", "level", "color_temperature"),
    **dict.fromkeys(("plug", "switch", "siren", "pump"), ("on_off",)),
    "fan": ("on_off", "fan_speed"),
    "window_covering": _OPENING,
    "closure": _OPENING,
    "door_lock": ("lock",),
    "x_lift": ("floor", "movement"),
    "water_valve": ("valve", "position"),
    "thermostat": ("heating_setpoint",),
}
_READABLE: Mapping[str, str] = {
    "thermostat": "local_temperature",
    "contact_sensor": "contact",
    "occupancy_sensor": "occupancy",
    "temperature_sensor": "temperature",
    "humidity_sensor": "humidity",
    "light_sensor": "illuminance",
    "pressure_sensor": "pressure",
    "flow_sensor": "flow",
    "soil_sensor": "soil_moisture",
    "smoke_co_alarm": "smoke",
    "water_leak_detector": "water_leak",
    "rain_sensor": "rain",
    "water_freeze_detector": "freeze",
    "electrical_meter": "power",
    "x_battery": "battery",
    "x_robot": "value",
    "x_tracker": "place",
    "x_sensor": "value",
    "x_binary_sensor": "state",
}
"""Capabilities of a service type; the settable ones are readable too."""

_CLEARED: Mapping[frozenset[str], tuple[str, str]] = {
    wanted_types("window"): ("closure", "window"),
    wanted_types("door"): ("closure", "door"),
    wanted_types("climate"): ("thermostat", ""),
}
"""Type and tag of ambiguous words."""


def thesis_part(service_type: str, address: str, command_address: str) -> Part:
    """Return the part of a device by its *service_type*, for example ``lights``; an unknown one has no type."""
    name, tag, capabilities = _meaning(service_type)
    takes_commands = any(capability.settable for capability in capabilities)
    return Part(
        id="",
        service_type=name,
        advertised=service_type,
        tag=tag,
        guessed=True,
        capabilities=capabilities,
        reads=(address,),
        writes=(command_address,) if takes_commands else (),
    )


@lru_cache(maxsize=1000)
def _meaning(service_type: str) -> tuple[str, str, tuple[Capability, ...]]:
    meant = wanted_types(service_type)
    name, tag = _CLEARED.get(meant, (next(iter(meant)) if len(meant) == 1 else "", ""))
    if tag == "door" and "garage" in service_type.casefold():
        tag = "garage_door"
    capabilities = [Capability(name=capability, settable=True) for capability in _SETTABLE.get(name, ())]
    capabilities += [Capability(name=_READABLE[name])] if name in _READABLE else []
    return (name, tag, tuple(capabilities)) if capabilities else ("", "", ())


LEVELS = ("SERVICE_TYPE", "DEVICE_ID", "CHANNEL")


class ThesisSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        root: The home: the first level or levels. If it is empty, topics of another shape are ignored, because they may
            be foreign, and a device's key begins with its home.
        home: The first level if *root* is empty: the name of the home. Empty for every home.
    """

    root: str = ""
    home: str = ""


class Thesis:
    """Discovery of the devices of one home, or of every home on the broker, by their topics alone."""

    Settings: ClassVar[type[BaseModel]] = ThesisSettings
    name: ClassVar[str] = "thesis"

    def __init__(self, settings: ThesisSettings) -> None:
        self.rejected = 0
        self._root = settings.root
        self._home = settings.home

    def filters(self) -> tuple[str, ...]:
        """Return the filters of state topics, and of invalid topics of the home."""
        if not self._root:
            return (f"{self._home or '+'}/+/+/out",) if {"+", "#", "/"}.isdisjoint(self._home) else ()
        root = self._root
        return (f"{root}/+/+/out", root, f"{root}/+", f"{root}/+/+", f"{root}/+/+/+/+/#")

    def birth_messages(self) -> Publications:
        """Return nothing: devices of the layout do not answer requests."""
        return ()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the device that publishes on *topic*; an empty payload withdraws it.

        Raises:
            WireError: The topic has too few or too many levels, or an empty one.
        """
        del retained
        try:
            device = self.announced(topic)
        except WireError:
            self.rejected += 1
            raise
        if device is None:
            return ()
        if payload:
            return (device,)
        return (DeviceWithdrawn(device.key, "its retained message was deleted", is_final=True, device=device),)

    def announced(self, topic: str) -> DeviceAnnounced | None:
        """Return the device that publishes on *topic*; None for another home, or a channel that is not ``out``.

        Raises:
            WireError: The topic has too few or too many levels, or an empty one.
        """
        if not self._root:
            home, _, rest = topic.partition("/")
            if self._home not in ("", home):
                return None
            levels = rest.split("/")
        elif topic == self._root or topic.startswith(f"{self._root}/"):
            home, levels = self._root, topic.split("/")[self._root.count("/") + 1 :]
        else:
            return None
        if len(levels) != len(LEVELS):
            shape = "/".join((self._root or "HOME", *LEVELS))
            raise WireError(f"topic {topic!r} has {len(levels)} levels below the home, not {len(LEVELS)}: {shape}")
        for level, name in zip(levels, LEVELS, strict=True):
            if not level:
                raise WireError(f"topic {topic!r} has an empty level where {name} belongs")
        service_type, device_id, channel = levels
        if channel != "out":
            return None
        base = f"{home}/{service_type}/{device_id}"
        endpoint = TextEndpoint(service_type, topic, f"{base}/in")
        part = thesis_part(service_type, topic, endpoint.command_address)
        return DeviceAnnounced(
            key=f"{service_type}/{device_id}" if self._root else base,
            convention=self.name,
            native=True,
            identifiers=(),
            name=device_id,
            parts=(DescribedPart(part, TextCodec(part)),),
            topic=topic,
            facts={"home": home},
            owns=(base,),
            text=endpoint,
        )
