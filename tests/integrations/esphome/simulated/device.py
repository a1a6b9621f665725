"""A simulated ESPHome device: a server of the native API, with one entity by kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import anyio
from anyio.abc import SocketStream
from tests.integrations.esphome.simulated.wire import (
    ApiMessage,
    ClientRefusedError,
    NativeApiStream,
    ServerIdentity,
    accept,
)
from tests.simulated.dns_sd import DnsSdService, announce_service

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.simulated_device import number_text
from homebot.house.wire import hardware_address, lamp_order, node_name

Fields: TypeAlias = Mapping[str, Any]
MIRED = 1e6
_COLOR_TEMPERATURE = 11


@dataclass(frozen=True, slots=True)
class EntityTemplate:
    """The entity of a kind of device.

    Attributes:
        component: The middle of the names of its messages: ``Light``.
        listed: The fields with which it is listed.
        commands: The commands in the fields of a command; sensors take none.
    """

    component: str
    listed: Fields
    state: Callable[[DeviceState], Fields]
    commands: Callable[[Fields], tuple[str, ...]] = lambda _fields: ()


def _lamp_state(lamp: DeviceState) -> Fields:
    return {
        "state": lamp.is_on,
        "brightness": lamp.brightness,
        "color_mode": _COLOR_TEMPERATURE,
        "color_temperature": MIRED / lamp.kelvin,
    }


def _lamp_commands(fields: Fields) -> tuple[str, ...]:
    mired = fields["color_temperature"] if fields["has_color_temperature"] else 0.0
    return lamp_order(
        is_on=fields["state"] if fields["has_state"] else None,
        brightness=fields["brightness"] if fields["has_brightness"] else None,
        kelvin=MIRED / mired if mired > 0 else None,
    )


def _motor_commands(fields: Fields) -> tuple[str, ...]:
    if fields["stop"]:
        return ("stop",)
    return (number_text(fields["position"]),) if fields["has_position"] else ()


def _motor(device_class: str) -> EntityTemplate:
    return EntityTemplate(
        "Cover",
        {"supports_position": True, "supports_stop": True, "device_class": device_class},
        lambda motor: {"position": motor.position, "current_operation": {1: 1, -1: 2}.get(motor.way, 0)},
        _motor_commands,
    )


def _binary_sensor(device_class: str, text: str) -> EntityTemplate:
    return EntityTemplate("BinarySensor", {"device_class": device_class}, lambda state: {"state": state.text == text})


def _sensor(device_class: str, unit: str) -> EntityTemplate:
    listed = {"device_class": device_class, "unit_of_measurement": unit, "state_class": 1}
    return EntityTemplate("Sensor", listed, lambda sensor: {"state": sensor.value})


_LOCK_STATES = {"locked": 1, "unlocked": 2, "jammed": 3, "locking": 4, "unlocking": 5}
_HEAT = 3
_MEASURES_AND_ACTS = 1 | 32

ENTITIES: Mapping[str, EntityTemplate] = {
    "lamp": EntityTemplate(
        "Light",
        {"supported_color_modes": [_COLOR_TEMPERATURE], "min_mireds": 25.0, "max_mireds": 666.0},
        _lamp_state,
        _lamp_commands,
    ),
    "window": _motor("window"),
    "cover": _motor("shutter"),
    "lock": EntityTemplate(
        "Lock",
        {},
        lambda lock: {"state": _LOCK_STATES.get(lock.text, 0)},
        lambda fields: ({0: "unlock", 1: "lock"}.get(fields["command"], ""),),
    ),
    "switch": EntityTemplate(
        "Switch",
        {"device_class": "outlet"},
        lambda switch: {"state": switch.text == "on"},
        lambda fields: ("on" if fields["state"] else "off",),
    ),
    "contact": _binary_sensor("door", "open"),
    "motion": _binary_sensor("motion", "motion"),
    "lux": _sensor("illuminance", "lx"),
    "power_meter": _sensor("power", "W"),
    "thermostat": EntityTemplate(
        "Climate",
        {
            "feature_flags": _MEASURES_AND_ACTS,
            "supports_current_temperature": True,
            "supports_action": True,
            "supported_modes": [_HEAT],
            "visual_min_temperature": 5.0,
            "visual_max_temperature": 30.0,
        },
        lambda state: {
            "mode": _HEAT,
            "action": _HEAT if state.heats else 4,
            "current_temperature": round(state.celsius, 1),
            "target_temperature": state.target,
        },
        lambda fields: (number_text(fields["target_temperature"]),) if fields["has_target_temperature"] else (),
    ),
}
"""By kind; a switch is no kind of the simulated house, but of tests."""


OUTBOX = 100
"""Messages that wait to be sent to a client; one that reads more slowly is disconnected, as firmware does."""

_KEY = 1
_VERSION = {"api_version_major": 1, "api_version_minor": 12, "server_info": "homebot's simulated house"}


class EsphomeServedDevice(ServedDevice):
    """A device with one entity, that of its kind.

    Args:
        device: Its name and kind, one of :data:`tests.integrations.esphome.simulated.device.ENTITIES`.
        on_command: Gets each command for it, as text such as ``on``.
        port: Its port; 0 for any, which it then keeps.
        key: Its encryption key in base64; empty for no encryption.
        password: The password that it wants; empty for none.

    Attributes:
        port: The port; 0 before it has begun to listen.
        mac: Its hardware address, twelve digits.
        listening: Is set when it listens for the first time.
        sleeps: Whether it says that it sleeps most of the time.
        logins: How many clients have tried to connect, in vain or not.
    """

    def __init__(
        self,
        device: SimulatedDeviceInfo,
        on_command: Callable[[str], None],
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        announced: bool = False,
        key: str = "",
        password: str = "",
    ) -> None:
        super().__init__(device, on_command)
        self.host = host
        self.port = port
        self.name = node_name(device).lower().replace("_", "-")
        self.mac = hardware_address(device)
        self.listening = anyio.Event()
        self.sleeps = False
        self.logins = 0
        self._entity = ENTITIES[device.kind]
        self._identity = ServerIdentity(self.name, self.mac, key)
        self._password = password
        self._is_announced = announced
        self._watchers: set[_ApiClient] = set()

    @property
    def txt(self) -> dict[str, str]:
        """The TXT record with which it would be announced as ``_esphomelib._tcp``."""
        encryption = {"api_encryption": "Noise_NNpsk0_25519_ChaChaPoly_SHA256"} if self._identity.key else {}
        return {"mac": self.mac, "friendly_name": self.device.device_id, "version": "2026.10.0", **encryption}

    async def serve(self) -> None:
        """Serve clients until cancelled."""
        listener = await anyio.create_tcp_listener(local_host=self.host, local_port=self.port, reuse_port=False)
        self.port = listener.extra(anyio.abc.SocketAttribute.local_port)  # noqa: S610 - no Django
        self.listening.set()
        async with listener, anyio.create_task_group() as tasks:
            if self._is_announced:
                service = DnsSdService("_esphomelib._tcp.local.", self.name, self.name, self.port, self.txt)
                await tasks.start(announce_service, service, self.host)
            await listener.serve(self._serve_client)

    def show(self) -> None:
        """Push the state to all clients that have asked for states."""
        for watcher in tuple(self._watchers):
            watcher.put(self._state())

    def sleep(self) -> None:
        """Disconnect all clients with a good-bye, as a device does that goes to sleep."""
        for watcher in tuple(self._watchers):
            watcher.put(("DisconnectRequest", {}))

    async def _serve_client(self, stream: SocketStream) -> None:
        self.logins += 1
        async with stream:
            try:
                messages = await accept(stream, self._identity)
                await self._talk(_ApiClient(messages))
            except (ClientRefusedError, anyio.EndOfStream, anyio.IncompleteRead, OSError, anyio.BrokenResourceError):
                return

    async def _talk(self, client: _ApiClient) -> None:
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(client.write)
                while client.is_open:
                    name, fields = await client.messages.receive()
                    if name == "SubscribeStatesRequest":
                        self._watchers.add(client)
                    for message in self._responses(name, fields):
                        client.put(message)
                    if name == f"{self._entity.component}CommandRequest":
                        for command in self._entity.commands(fields):
                            self.on_command(command)
        except* (ClientRefusedError, anyio.EndOfStream, anyio.IncompleteRead, OSError, anyio.BrokenResourceError):
            pass
        finally:
            self._watchers.discard(client)

    def _responses(self, name: str, fields: Mapping[str, Any]) -> tuple[ApiMessage, ...]:
        match name:
            case "HelloRequest":
                return (("HelloResponse", {**_VERSION, "name": self.name}),)
            case "DeviceInfoRequest":
                pairs = [self.mac[at : at + 2].upper() for at in range(0, 12, 2)]
                info = {
                    "name": self.name,
                    "friendly_name": self.device.device_id,
                    "mac_address": ":".join(pairs),
                    "model": f"simulated {self.device.kind}",
                    "manufacturer": "homebot",
                    "esphome_version": "2026.10.0",
                    "suggested_area": self.device.room,
                    "has_deep_sleep": self.sleeps,
                    "uses_password": bool(self._password),
                    "api_encryption_supported": bool(self._identity.key),
                }
                return (("DeviceInfoResponse", info),)
            case "ListEntitiesRequest":
                entity = {"object_id": self.device.kind, "name": "", "key": _KEY, **self._entity.listed}
                return (f"ListEntities{self._entity.component}Response", entity), ("ListEntitiesDoneResponse", {})
            case "SubscribeStatesRequest":
                return (self._state(),)
            case "PingRequest" | "DisconnectRequest":
                return ((name.replace("Request", "Response"), {}),)
            case "AuthenticationRequest":
                return (("AuthenticationResponse", {"invalid_password": fields.get("password") != self._password}),)
            case _:
                return ()

    def _state(self) -> ApiMessage:
        return f"{self._entity.component}StateResponse", {"key": _KEY, **self._entity.state(self.state)}


class _ApiClient:
    def __init__(self, messages: NativeApiStream) -> None:
        self.messages = messages
        self.is_open = True
        self._outbox, self._sent = anyio.create_memory_object_stream[ApiMessage](OUTBOX)

    def put(self, message: ApiMessage) -> None:
        """Have a message sent, or the connection closed where too many wait."""
        try:
            self._outbox.send_nowait(message)
        except (anyio.WouldBlock, anyio.BrokenResourceError, anyio.ClosedResourceError):
            self.is_open = False
            self._outbox.close()

    async def write(self) -> None:
        """Send the queued messages until the farewell is sent."""
        with self._outbox, self._sent:
            async for message in self._sent:
                await self.messages.send(message)
                if message[0].startswith("Disconnect"):
                    break
        raise ClientRefusedError("good-bye")
