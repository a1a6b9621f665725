"""A HomeKit bridge by HAP-python, with which homebot is paired from the start; the one file that imports it.

Source: HomeKit Accessory Protocol Specification R2, chapters 8 (services) and 9 (characteristics).
"""

import asyncio
import json
import socket
import uuid
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final

import anyio
from anyio import to_thread
from anyio.abc import TaskStatus
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from pyhap.accessory import Accessory, Bridge
from pyhap.accessory_driver import AccessoryDriver
from pyhap.loader import Loader
from tests.simulated.dns_sd import DnsSdService, announce_service

from homebot.house.connected_device import HubDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import device_orders, hardware_address, mired_kelvin, scaled

ID: Final = "02:48:42:00:00:01"
HAP_TYPE: Final = "_hap._tcp.local."
PIN: Final = "031-45-154"

SERVICES: Final[Mapping[str, tuple[str, ...]]] = {
    "lamp": ("Lightbulb", "Brightness", "ColorTemperature"),
    "window": ("Window", "HoldPosition"),
    "cover": ("WindowCovering", "HoldPosition"),
    "lock": ("LockMechanism",),
    "contact": ("ContactSensor",),
    "motion": ("MotionSensor",),
    "lux": ("LightSensor",),
    "thermostat": ("Thermostat",),
}
"""By kind: the service, and its optional characteristics."""

_MIREDS: Final = 1e6
_LOCKS: Final = {0: "unlock", 1: "lock"}


def orders_of(kind: str, values: Mapping[str, float]) -> tuple[str, ...]:
    """Return the orders that written characteristics give a device of this *kind*."""
    return device_orders(
        kind,
        is_on=bool(values["On"]) if "On" in values else None,
        brightness=scaled(values.get("Brightness"), 100),
        kelvin=mired_kelvin(values.get("ColorTemperature")),
        position=scaled(values.get("TargetPosition"), 100),
        action="stop" if values.get("HoldPosition") else _LOCKS.get(int(values.get("LockTargetState", -1)), ""),
        target=values.get("TargetTemperature"),
    )


def _lamp(lamp: DeviceState) -> Mapping[str, object]:
    mireds = min(max(round(_MIREDS / lamp.kelvin), 140), 500)
    return {"On": lamp.is_on, "Brightness": max(1, round(lamp.brightness * 100)), "ColorTemperature": mireds}


def _motor(motor: DeviceState) -> Mapping[str, object]:
    return {"CurrentPosition": round(motor.position * 100), "PositionState": {1: 1, -1: 0}.get(motor.way, 2)}


def _lock(lock: DeviceState) -> Mapping[str, object]:
    now = {"locked": 1, "unlocked": 0}.get(lock.text)
    return {"LockCurrentState": 3} if now is None else {"LockCurrentState": now, "LockTargetState": now}


def _thermostat(thermostat: DeviceState) -> Mapping[str, object]:
    return {
        "CurrentTemperature": thermostat.celsius,
        "TargetTemperature": thermostat.target,
        "CurrentHeatingCoolingState": int(thermostat.heats),
        "TargetHeatingCoolingState": 1,
    }


VALUES: Final[Mapping[str, Callable[[DeviceState], Mapping[str, object]]]] = {
    "lamp": _lamp,
    "window": _motor,
    "cover": _motor,
    "lock": _lock,
    "contact": lambda door: {"ContactSensorState": int(door.text == "open")},
    "motion": lambda room: {"MotionDetected": room.text == "motion"},
    "lux": lambda lux: {"CurrentAmbientLightLevel": max(0.0001, lux.value)},
    "thermostat": _thermostat,
}
"""By kind: the values of the characteristics that say how a device is."""


class _Driver(AccessoryDriver):  # type: ignore[misc]
    def persist(self) -> None:
        """Keep nothing: the house is made anew each time."""

    def add_accessory(self, accessory: Accessory) -> None:
        """Serve an accessory, without a file."""
        self.accessory, accessory.aid = accessory, 1


class _Advertiser:
    """The newest announcement of the driver, which would leave tasks behind if it announced by itself."""

    def __init__(self) -> None:
        self.changed = anyio.Event()
        self.service = DnsSdService(HAP_TYPE, "", "", 0)

    async def async_register_service(self, info: Any, **_: object) -> None:
        """Announce a service."""
        txt = {key: str(value) for key, value in info.decoded_properties.items()}
        label = info.name.removesuffix(f".{HAP_TYPE}")
        self.service = DnsSdService(HAP_TYPE, label, info.server.removesuffix(".local."), info.port, txt)
        self.changed.set()

    async_update_service = async_register_service


class _Bridge(Bridge):  # type: ignore[misc]
    def setup_message(self) -> None:
        """Print nothing."""


class BridgedAccessory(Accessory):  # type: ignore[misc]
    """An accessory behind the bridge; *on_write* gets values that a controller wrote, by names of characteristics."""

    def __init__(
        self, driver: AccessoryDriver, device: SimulatedDeviceInfo, on_write: Callable[[Mapping[str, float]], None]
    ) -> None:
        super().__init__(driver, device.device_id)
        self.set_info_service("1.0", "homebot", f"SIM-{device.kind}", hardware_address(device, 16))
        name, *optional = SERVICES[device.kind]
        self._service = self.add_preload_service(name, chars=optional)
        self._service.setter_callback = on_write
        self.is_there = False

    @property
    def available(self) -> bool:
        """True while the bridge reaches it."""
        return self.is_there

    def show(self, values: Mapping[str, object]) -> None:
        """Set the values of characteristics, and send events for those that changed."""
        for name, value in values.items():
            self._service.get_characteristic(name).set_value(value)


class SimulatedHomekitBridge:
    """The bridge of a house.

    Args:
        pairings: The file with homebot's key, as the HomeKit gateway keeps it; it is there while it is served. A
            further bridge adds itself.
    """

    def __init__(self, address: str, pairings: Path, bridge_id: str = ID) -> None:
        self._address = address
        self._pairings = pairings
        self._id = bridge_id
        self._own_key, self._client_key = Ed25519PrivateKey.generate(), Ed25519PrivateKey.generate()
        self._client_id = str(uuid.uuid4())
        self._devices: list[tuple[SimulatedDeviceInfo, Callable[[Mapping[str, float]], None]]] = []
        self._accessories: dict[SimulatedDeviceInfo, BridgedAccessory] = {}
        self._is_needed, self._is_ready = anyio.Event(), anyio.Event()

    def add(self, device: SimulatedDeviceInfo, on_write: Callable[[Mapping[str, float]], None]) -> None:
        """Add a device, before any is reached."""
        self._devices.append((device, on_write))

    async def reach(self, device: SimulatedDeviceInfo) -> BridgedAccessory:
        """Return the accessory that a device is; the bridge announces itself once the first is reached."""
        self._is_needed.set()
        await self._is_ready.wait()
        return self._accessories[device]

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve homebot until cancelled; then vanish without a goodbye."""
        await to_thread.run_sync(self._write_pairings)
        try:
            task_status.started()
            await self._is_needed.wait()
            await self._serve(await to_thread.run_sync(Loader))
        finally:
            with anyio.CancelScope(shield=True):
                await to_thread.run_sync(partial(self._pairings.unlink, missing_ok=True))

    async def _serve(self, loader: Loader) -> None:
        with socket.socket() as probe:
            probe.bind((self._address, 0))
            port = probe.getsockname()[1]
        advertiser = _Advertiser()
        driver = _Driver(
            address=self._address,
            port=port,
            persist_file="",
            pincode=PIN.encode(),
            loop=asyncio.get_running_loop(),
            mac=self._id,
            async_zeroconf_instance=advertiser,
            loader=loader,
        )
        bridge = _Bridge(driver, "Simulated bridge")
        for device, on_write in self._devices:
            self._accessories[device] = accessory = BridgedAccessory(driver, device, on_write)
            bridge.add_accessory(accessory)
        driver.add_accessory(bridge)
        driver.state.private_key, driver.state.public_key = self._own_key, self._own_key.public_key()
        client_key = self._client_key.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw)
        driver.state.add_paired_client(self._client_id.encode(), client_key, b"\x01")
        await driver.async_start()
        self._is_ready.set()
        try:
            while True:
                advertiser.changed = anyio.Event()
                async with anyio.create_task_group() as tasks:
                    await tasks.start(announce_service, advertiser.service, self._address)
                    await advertiser.changed.wait()
                    tasks.cancel_scope.cancel()
        finally:
            driver.aio_stop_event.set()
            driver.http_server.async_stop()

    def _write_pairings(self) -> None:
        keys = {
            "AccessoryPairingID": self._id,
            "AccessoryLTPK": _public(self._own_key),
            "iOSPairingId": self._client_id,
            "iOSDeviceLTSK": self._client_key.private_bytes_raw().hex(),
            "iOSDeviceLTPK": _public(self._client_key),
        }
        self._pairings.touch(0o600)
        kept = json.loads(self._pairings.read_text() or "{}")
        self._pairings.write_text(json.dumps({**kept, self._id: keys}))


def _public(key: Ed25519PrivateKey) -> str:
    return key.public_key().public_bytes(Encoding.Raw, PublicFormat.Raw).hex()


class ServedAccessory(HubDevice):
    """A lamp, window, cover, lock, thermostat or sensor behind the bridge of the house."""

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], bridge: SimulatedHomekitBridge
    ) -> None:
        super().__init__(device, on_command)
        self._bridge = bridge
        self._accessory: BridgedAccessory | None = None
        bridge.add(device, self._on_write)

    async def join(self) -> None:
        """Have the bridge reach it, and report its state."""
        self._accessory = await self._bridge.reach(self.device)
        self._accessory.is_there = True
        self.show()

    def leave(self) -> None:
        """Have the bridge miss it."""
        if self._accessory is not None:
            self._accessory.is_there = False

    def show(self) -> None:
        """Report the characteristics that have changed."""
        if self.is_there and self._accessory is not None:
            self._accessory.show(VALUES[self.device.kind](self.state))

    def _on_write(self, values: Mapping[str, float]) -> None:
        for order in orders_of(self.device.kind, values) if self.is_there else ():
            self.on_command(order)
