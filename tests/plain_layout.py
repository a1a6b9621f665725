"""Stands in for the thesis's layout in a copy of the project without integrations, so that the core has devices.

A simulated world speaks ``thesis`` where nothing else is said: :mod:`tests.packages.test_taking_out` offers this by
that name. Topics are ``HOME/SERVICE_TYPE/DEVICE_ID/out`` and ``…/in``; payloads are words.
"""

from homebot.conventions.convention import ConventionSettings
from homebot.conventions.description import (
    AnnouncementEvent,
    DescribedPart,
    DeviceAnnounced,
    Publications,
    TextEndpoint,
)
from homebot.conventions.text_codec import TextCodec
from homebot.devices.device_types import wanted_types
from homebot.devices.part import Capability, Part
from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.kinds import KINDS

_CAPABILITIES = {
    "contact_sensor": ("contact",),
    "door_lock": ("lock",),
    "light": ("on_off", "level"),
    "light_sensor": ("illuminance",),
    "occupancy_sensor": ("occupancy",),
    "thermostat": ("heating_setpoint",),
    "window_covering": ("movement",),
}
_SETTABLE = {"heating_setpoint", "level", "lock", "movement", "on_off"}


class PlainSettings(ConventionSettings):
    root: str = ""
    home: str = ""


class PlainLayout:
    Settings = PlainSettings
    name = "thesis"
    rejected = 0

    def __init__(self, settings: PlainSettings) -> None:
        self._home = settings.root or settings.home or "+"

    def filters(self) -> tuple[str, ...]:
        return (f"{self._home}/+/+/out",)

    def birth_messages(self) -> Publications:
        return ()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        del payload, retained
        return (self.announced(topic),)

    def announced(self, topic: str) -> DeviceAnnounced:
        home, service_type, name, _ = topic.split("/")
        base = f"{home}/{service_type}/{name}"
        known = wanted_types(service_type) & _CAPABILITIES.keys()
        kind = max(known, default="")  # a window is one with a motor
        part = Part(
            id="",
            service_type=kind,
            advertised=service_type,
            guessed=True,
            capabilities=tuple(Capability(name=one, settable=one in _SETTABLE) for one in _CAPABILITIES.get(kind, ())),
            reads=(topic,),
            writes=(f"{base}/in",),
        )
        return DeviceAnnounced(
            key=f"{service_type}/{name}" if self._home != "+" else base,
            convention=self.name,
            native=True,
            identifiers=(),
            name=name,
            parts=(DescribedPart(part, TextCodec(part)),),
            topic=topic,
            facts={"home": home},
            owns=(base,),
            text=TextEndpoint(service_type, topic, f"{base}/in"),
        )


class PlainDialect(Dialect):
    announces = False
    kinds = frozenset(KINDS)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        return (f"{device.home}/{device.service_type}/{device.device_id}/in",)

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        (topic,) = self.filters(device)
        return (OutgoingMessage(f"{topic.removesuffix('in')}out", state.text.encode(errors="replace")),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        del device, topic
        return (payload.decode(errors="replace"),)
