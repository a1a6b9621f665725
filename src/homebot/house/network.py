"""The networks of a simulated house besides its broker: the loopback interface, and a virtual radio.

A device speaks MQTT in a dialect, or belongs to a *served family*: it is a server or a radio, found by the gateway of
its protocol. The house tells which gateways its devices need; the runtime adds missing ones.
"""

from __future__ import annotations

import importlib
import os
import secrets
import socket
import tempfile
from collections.abc import AsyncIterator, Callable, Iterable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

import anyio
from anyio import to_thread

from homebot.house.connected_device import ConnectedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.dialects import DIALECTS
from homebot.plugins import check_extra

if TYPE_CHECKING:
    from homebot.house.homeassistant import SimulatedHomeAssistant
    from homebot.house.homekit import SimulatedHomekitBridge
    from homebot.house.matter import SimulatedMatterServer

__all__ = ["FAMILIES", "HouseNetwork", "ServedFamily", "kinds_of"]

OnCommand: TypeAlias = Callable[[str], None]
LOOPBACK = "127.0.0.1"
TOKEN = "HOMEBOT_SIMULATED_TOKEN"  # noqa: S105 - the name of a variable
"""Environment variable with the token of the simulated Home Assistant."""


@dataclass(frozen=True, slots=True, eq=False)
class ServedFamily:
    """A family of devices that are servers or radios.

    Attributes:
        kinds: Its kinds of devices, as named in descriptions of houses.
        device: Module and class of its devices.
        options: Arguments of that class besides the name and the receiver of commands.
        gateway: The plug-in name of the gateway that finds them.
        extra: The extra that installs its libraries.
        libraries: Their top-level modules.
    """

    kinds: frozenset[str]
    device: str
    gateway: str
    extra: str
    libraries: tuple[str, ...]
    options: Mapping[str, object] = field(default_factory=dict)


def _family(
    kinds: frozenset[str], device: str, gateway: str, libraries: tuple[str, ...], **options: object
) -> ServedFamily:
    """Return a family whose libraries come from the extra of its gateway, or of another one."""
    extra = {"ble": "testing", "homeassistant": "matter", "homekit": "testing", "hue": "testing"}.get(gateway, gateway)
    return ServedFamily(kinds, f"homebot.house.{device}", gateway, extra, libraries, options)


_LAMP = frozenset({"lamp"})
_SHELLYS = frozenset({"cover", "lamp", "window"})
_HUE = frozenset({"contact", "lamp", "lux", "motion"})
_SENSORS = frozenset({"contact", "lux", "motion", "power_meter", "thermostat"})
_COAP = frozenset({"lamp", "lux", "motion", "thermostat"})
_ALL = frozenset({"contact", "cover", "lamp", "lock", "lux", "motion", "power_meter", "thermostat", "window"})
"""All kinds but robots and tags."""

FAMILIES: Mapping[str, ServedFamily] = MappingProxyType(
    {
        "ble_light": _family(_LAMP, "ble_devices:BluetoothLight", "ble", ("bleak", "bumble")),
        "bthome": _family(_SENSORS, "ble_devices:BroadcastingSensor", "ble", ("bleak", "bumble")),
        "coap": _family(_COAP, "coap_devices:CoapDevice", "coap", ("aiocoap",)),
        "esphome": _family(_ALL, "esphome:EsphomeServedDevice", "mdns", ("aioesphomeapi", "zeroconf"), announced=True),
        "home_assistant": _family(_ALL, "homeassistant:ServedEntity", "homeassistant", ("aiohttp",)),
        "homekit": _family(_ALL - {"power_meter"}, "homekit:ServedAccessory", "homekit", ("pyhap",)),
        "hue": _family(_HUE, "hue:HueHouseDevice", "hue", ("aiohttp", "trustme")),
        "matter": _family(_ALL, "matter:ServedMatterNode", "matter", ("aiohttp",)),
        "matter_bridge": _family(_ALL, "matter:BridgedMatterDevice", "matter", ("aiohttp",)),
        "matter_plug": _family(_LAMP, "matter:ServedMatterNode", "matter", ("aiohttp",), kind="plug"),
        "nfc": _family(frozenset({"tag"}), "nfc:ServedTag", "nfc", ("ndef", "nfc")),
        "shelly_http": _family(_SHELLYS, "http.shelly:ServedShelly", "mdns", ("aiohttp", "zeroconf"), announced=True),
        "wled": _family(_LAMP, "http.wled:ServedWled", "mdns", ("aiohttp", "zeroconf"), announced=True),
    }
)
"""The served families by their names in houses."""


def kinds_of(name: str) -> frozenset[str] | None:
    """Return the kinds of devices in the dialect or served family *name*, or None if it does not exist."""
    if name in DIALECTS:
        return DIALECTS[name].kinds
    return FAMILIES[name].kinds if name in FAMILIES else None


class HouseNetwork:
    """The networks of one house.

    Args:
        families: The dialects and served families of its devices.
    """

    def __init__(self, families: Iterable[str]) -> None:
        self._families = {name: FAMILIES[name] for name in families if name in FAMILIES}
        self._ports: dict[str, int] = {}
        self._options: dict[str, dict[str, object]] = {}
        self._pairings = Path(tempfile.gettempdir()) / f"homebot-{secrets.token_hex(8)}.pairings.json"

    @asynccontextmanager
    async def running(self, random: Random | None) -> AsyncIterator[tuple[object, ...]]:
        """Run the networks inside the block; yield the peers by gateway.

        Args:
            random: The source of random numbers; None for one of its own.
        """
        gateways = {family.gateway for family in self._families.values()}
        needed: tuple[object, ...] = ()
        async with AsyncExitStack() as stack:
            if "ble" in gateways:
                from homebot.house.virtual_bleak import backend_of  # noqa: PLC0415 - an extra
                from homebot.house.virtual_radio import VirtualRadio  # noqa: PLC0415 - an extra

                radio = VirtualRadio(random or Random())  # noqa: S311 - no secret
                await stack.enter_async_context(radio.running())
                self._options["ble"] = {"radio": radio}
                needed = (backend_of(radio),)
            if "coap" in gateways:
                self._options["coap"] = {"directory": f"coap://{LOOPBACK}:{self._port('coap')}"}
            if "matter" in gateways:
                from homebot.house.matter import SimulatedMatterServer  # noqa: PLC0415 - likewise

                server = SimulatedMatterServer(LOOPBACK, self._port("matter"))
                await stack.enter_async_context(_served(server))
                self._options["matter"] = {"server": server}
            if "homeassistant" in gateways:
                from homebot.house.homeassistant import SimulatedHomeAssistant  # noqa: PLC0415 - likewise

                home = SimulatedHomeAssistant(LOOPBACK, self._port("homeassistant"))
                home.token = os.environ.setdefault(TOKEN, home.token)
                await stack.enter_async_context(_served(home))
                self._options["homeassistant"] = {"server": home}
            if "homekit" in gateways:
                homekit = await to_thread.run_sync(importlib.import_module, "homebot.house.homekit")  # reads files
                bridge: SimulatedHomekitBridge = homekit.SimulatedHomekitBridge(LOOPBACK, self._pairings)
                await stack.enter_async_context(_served(bridge))
                self._options["homekit"] = {"bridge": bridge}
            if "hue" in gateways:
                from homebot.house.hue import paired_bridge  # noqa: PLC0415 - likewise

                paired = paired_bridge(LOOPBACK, self._port("hue"), self._pairings.with_suffix(".hue"))
                self._options["hue"] = {"bridge": await stack.enter_async_context(paired)}
            if "nfc" in gateways:
                from homebot.house.nfc import TagField  # noqa: PLC0415 - likewise

                tags = TagField(self._port("nfc"))
                await stack.enter_async_context(tags.served())
                self._options["nfc"] = {"field": tags}
            yield needed

    def gateways(self) -> dict[str, dict[str, object]]:
        """Return the tables of the gateways that find its devices, by the names of their plug-ins.

        Raises:
            UsageError: A library of a device is not installed; the message says how to install it.
        """
        found: dict[str, dict[str, object]] = {}
        for name, family in self._families.items():
            check_extra(f"a simulated device of {name!r}", family.extra, *family.libraries)
            found[family.gateway] = self._settings(family.gateway)
        if "homekit" in found:
            found["mdns"] = self._settings("mdns")  # which finds the accessories
        return found

    def connect(
        self, family: str, device: SimulatedDeviceInfo, on_command: OnCommand, **options: object
    ) -> ConnectedDevice:
        """Return a device of a served family, online while it lives; called inside :meth:`running`.

        Args:
            options: Further arguments of the class of the device.
        """
        spec = self._families[family]
        module, _, name = spec.device.partition(":")
        make: Callable[..., ConnectedDevice] = getattr(importlib.import_module(module), name)
        return make(device, on_command, **{**spec.options, **self._options.get(spec.gateway, {}), **options})

    def _settings(self, gateway: str) -> dict[str, object]:
        """Return the table of a gateway."""
        match gateway:
            case "mdns":
                return {"interfaces": [LOOPBACK], "announce": False}
            case "coap":
                return {"serve_directory": f"{LOOPBACK}:{self._port(gateway)}"}
            case "matter":
                return {"url": f"ws://{LOOPBACK}:{self._port(gateway)}/ws"}
            case "homekit":
                return {"pairings": str(self._pairings)}
            case "homeassistant":
                os.environ.setdefault(TOKEN, secrets.token_hex(16))
                return {"url": f"http://{LOOPBACK}:{self._port(gateway)}", "token_env": TOKEN}
            case "hue":
                return {"pairings": str(self._pairings.with_suffix(".hue"))}
            case "nfc":
                return {"backend": "nfcpy", "devices": [f"udp:{LOOPBACK}:{self._port(gateway)}"]}
            case _:
                return {}

    def _port(self, gateway: str) -> int:
        """Return the port shared by a gateway and its devices: one that was free when first asked for."""
        if gateway not in self._ports:
            kind = socket.SOCK_STREAM if gateway in {"homeassistant", "hue", "matter"} else socket.SOCK_DGRAM
            with socket.socket(socket.AF_INET, kind) as probe:
                probe.bind((LOOPBACK, 0))
                self._ports[gateway] = probe.getsockname()[1]
        return self._ports[gateway]


@asynccontextmanager
async def _served(
    server: SimulatedHomeAssistant | SimulatedHomekitBridge | SimulatedMatterServer,
) -> AsyncIterator[None]:
    async with anyio.create_task_group() as tasks:
        await tasks.start(server.serve)
        yield
        tasks.cancel_scope.cancel()
