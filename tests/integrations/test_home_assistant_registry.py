"""Devices that Home Assistant has by an integration, and homebot by a gateway of its own: each is one device.

The identifiers and connections of devices, and the unique ids of entities, are as the integrations of Home Assistant
write them into its registries. Source: Home Assistant core 2025.5, ``homeassistant/components``, in the files that the
functions of :data:`CASES` name, and Zigbee2MQTT 2.3, ``lib/extension/homeassistant.ts``.
"""

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio
import pytest
from tests.house.onlooker import house
from tests.integrations.homeassistant.simulated.entity import ServedEntity
from tests.integrations.homeassistant.simulated.server import Fields, SimulatedHomeAssistant
from tests.integrations.homekit.simulated.bridge import ID as PAIRING_ID
from tests.integrations.hue.simulated.resources import radio_address, resource_uuid
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.simulated.families import FAMILIES

from homebot.devices import Device, DevicePart, Devices
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import hardware_address

pytestmark = pytest.mark.slow

NODE = "112210F47DE98115-0000000000000001"
"""The compressed ID of the simulated fabric, and the first node there."""

DECIMAL = "lamp 88"
"""A lamp with a hardware address of decimal digits alone, which looks like a serial number."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A device in the registry of Home Assistant, with the unique id of its entity."""

    identifiers: tuple[tuple[str, ...], ...] = ()
    connections: tuple[tuple[str, str], ...] = ()
    unique_id: str = ""


def lamp_named(name: str) -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo("home425", "lamp", name, "lamp", "hall")


def mac_of(lamp: SimulatedDeviceInfo) -> str:
    digits = hardware_address(lamp)
    return ":".join(digits[at : at + 2] for at in range(0, 12, 2))


def zigbee2mqtt(lamp: SimulatedDeviceInfo) -> Entry:
    """``mqtt/entity.py``, as Zigbee2MQTT announces it."""
    ieee = f"0x{hardware_address(lamp, 16)}"
    return Entry((("mqtt", f"zigbee2mqtt_{ieee}"),), (), f"{ieee}_light_zigbee2mqtt")


def zha(lamp: SimulatedDeviceInfo) -> Entry:
    """``zha/entity.py``, of a device that Zigbee2MQTT had before."""
    ieee = radio_address(lamp)
    return Entry((("zha", ieee),), (("zigbee", ieee),), f"{ieee}-1")


def tasmota(lamp: SimulatedDeviceInfo) -> Entry:
    """``tasmota/__init__.py``."""
    return Entry((), (("mac", mac_of(lamp)),), f"{hardware_address(lamp).upper()}_light_light_0")


def shelly(lamp: SimulatedDeviceInfo) -> Entry:
    """``shelly/coordinator.py``, with the unique ids of ``shelly/entity.py``."""
    mac = hardware_address(lamp).upper()
    return Entry((("shelly", mac),), (("mac", mac_of(lamp)),), f"{mac}-light:0")


def esphome(lamp: SimulatedDeviceInfo) -> Entry:
    """``esphome/manager.py``, with the unique ids of ``esphome/entry_data.py``."""
    return Entry((), (("mac", mac_of(lamp)),), f"{mac_of(lamp).upper()}-light-lamp")


def wled(lamp: SimulatedDeviceInfo) -> Entry:
    """``wled/entity.py`` and ``wled/light.py``."""
    mac = hardware_address(lamp)
    return Entry((("wled", mac),), (("mac", mac_of(lamp)),), f"{mac}_0")


def hue(lamp: SimulatedDeviceInfo) -> Entry:
    """``hue/v2/device.py``."""
    rid = resource_uuid("home425", lamp.device_id)
    return Entry((("hue", rid),), (("mac", radio_address(lamp)),), resource_uuid("home425", lamp.device_id, "light"))


def hue_without_radio(lamp: SimulatedDeviceInfo) -> Entry:
    """``hue/v2/device.py``, before the bridge has told the address in the radio network."""
    return Entry(hue(lamp).identifiers, (), hue(lamp).unique_id)


def matter(lamp: SimulatedDeviceInfo) -> Entry:
    """``matter/adapter.py`` and ``matter/helpers.py``."""
    serial = ("matter", f"serial_{hardware_address(lamp, 16)}")
    return Entry((*matter_without_serial(lamp).identifiers, serial), (), f"{NODE}-MatterNodeDevice-1-MatterLight-6-0")


def matter_without_serial(_: SimulatedDeviceInfo) -> Entry:
    """``matter/adapter.py``, of a node on the same server without a serial number."""
    return Entry((("matter", f"deviceid_{NODE}-MatterNodeDevice"),), (), f"{NODE}-MatterNodeDevice-1-MatterLight-6-0")


CASES: Mapping[str, tuple[str, str, Callable[[SimulatedDeviceInfo], Entry]]] = {
    "zigbee2mqtt": ("zigbee2mqtt", "lamp", zigbee2mqtt),
    "zha": ("zigbee2mqtt", "lamp", zha),
    "tasmota": ("tasmota", "lamp", tasmota),
    "shelly, first generation": ("shelly", "lamp", shelly),
    "shelly": ("shelly_rpc", "lamp", shelly),
    "shelly over HTTP": ("shelly_http", "lamp", shelly),
    "esphome": ("esphome", "lamp", esphome),
    "wled": ("wled", "lamp", wled),
    "hue": ("hue", "lamp", hue),
    "hue, without radio": ("hue", "lamp", hue_without_radio),
    "matter": ("matter", "lamp", matter),
    "matter, without serial number": ("matter", "lamp", matter_without_serial),
    "tasmota, in decimal digits": ("tasmota", DECIMAL, tasmota),
    "shelly, in decimal digits": ("shelly_rpc", DECIMAL, shelly),
    "shelly over HTTP, in decimal digits": ("shelly_http", DECIMAL, shelly),
    "wled, in decimal digits": ("wled", DECIMAL, wled),
}
"""By integration: the dialect of the house, the name of the lamp, and its entry."""


class RegisteredLamp(ServedEntity):
    """A lamp as an entity of Home Assistant by some integration."""

    registered = Entry()

    def entry(self) -> Fields:
        return {**super().entry(), "unique_id": self.registered.unique_id}

    def device_entry(self) -> Fields:
        found = {"identifiers": self.registered.identifiers, "connections": self.registered.connections}
        return {**super().device_entry(), **{key: list(map(list, pairs)) for key, pairs in found.items()}}


@asynccontextmanager
async def two_ways(tmp_path: Path, dialect: str, name: str, registered: Mapping[str, Entry]) -> AsyncIterator[Node]:
    """A house with one lamp, which is found first, and then a Home Assistant with lamps by their names."""
    home = SimulatedHomeAssistant(port=reserve_port())
    token = tmp_path / "token"
    token.touch(mode=0o600)
    token.write_text(home.token)
    table = {"url": f"http://127.0.0.1:{home.server.port}", "token_file": str(token)}
    tables = {name: {"kind": "lamp", "dialect": FAMILIES.get(dialect, dialect)}}
    gateways = {"homeassistant": table}
    async with alone_on_loopback(), house(tables, gateways) as (node, _), anyio.create_task_group() as tasks:
        await lamps(node, bool)
        await tasks.start(home.serve)
        for own_name, entry in registered.items():
            lamp = RegisteredLamp(lamp_named(own_name), _ignore, home)
            lamp.registered = entry
            lamp.begin(DeviceState(text="off"), has_power=True)
            await tasks.start(lamp.serve)
        yield node
        tasks.cancel_scope.cancel()


def _ignore(_: str) -> None:
    pass


async def lamps(node: Node, is_wanted: Callable[[Sequence[Device]], bool]) -> Sequence[Device]:
    """Wait until the lamps of the house are as wanted; return them."""
    with anyio.fail_after(PATIENCE):
        while True:
            found = [one for one in await Devices(node).find() if any(map(is_lamp, one.parts))]
            if is_wanted(found):
                return found
            await anyio.sleep(0.05)


def is_lamp(part: DevicePart) -> bool:
    return part.part.service_type == "light" and not part.part.is_group


def routes(device: Device) -> list[list[str]]:
    return [[route.gateway for route in part.routes] for part in device.parts if is_lamp(part)]


def of_home_assistant(found: Sequence[Device]) -> list[Device]:
    return [one for one in found if any(endpoint.gateway == "homeassistant" for endpoint in one.endpoints)]


@pytest.mark.parametrize("case", CASES)
async def test_a_device_of_another_gateway_is_one_with_that_of_home_assistant(case: str, tmp_path: Path) -> None:
    """With one lamp in it, which takes commands by its own protocol first."""
    dialect, name, entry_of = CASES[case]
    registered = {name: entry_of(lamp_named(name))}
    async with two_ways(tmp_path, dialect, name, registered) as node:
        found = await lamps(node, lambda found: bool(of_home_assistant(found)))
    assert [device.name for device in found] == [name]
    ((first, second),) = routes(found[0])
    assert (first != "homeassistant", second) == (True, "homeassistant")


async def test_an_accessory_that_is_paired_with_home_assistant_is_one_with_it(tmp_path: Path) -> None:
    """``homekit_controller/connection.py`` has the pairing ID in lower case, and one for each bridged accessory."""
    server = f"{PAIRING_ID.lower()}:aid"
    aids = {"bridge": 1, "lamp": 2, "desk": 3}
    registered = {
        name: Entry((("homekit_controller:accessory-id", f"{server}:{aid}"),), (), f"1_{aid}_8")
        for name, aid in aids.items()
    }
    async with two_ways(tmp_path, "homekit", "lamp", registered) as node:
        found = await lamps(node, lambda found: len(of_home_assistant(found)) == len(registered))
    assert {one.name: {place.gateway for place in one.endpoints} for one in found} == {
        "lamp": {"homekit", "homeassistant"},
        "Simulated bridge 000001": {"homekit", "homeassistant", "mdns"},
        "desk": {"homeassistant"},
    }


ALIKE: Mapping[str, Mapping[str, Entry]] = {
    "zigbee2mqtt": {
        "another radio": Entry((("mqtt", "zigbee2mqtt_0x022cb50703db19b8"),), (), "1"),
        "group": Entry((("mqtt", "zigbee2mqtt_1221051039810110150109113116116_1"),), (), "2"),
        "first of three texts": Entry((("gateway", "0x022cb50703db19b7", "1"),), (), "3"),
        "second of three texts": Entry((("gateway", "0x022cb50703db19b7", "2"),), (), "4"),
        "of a name": Entry((("cloud", "99438b99-a3a3-5e6a-8e56-022cb50703db"),), (), "5"),
        "by the same name": Entry((("cloud", "9943aaaa-a3a3-5e6a-8e56-022cb50703db"),), (), "6"),
    },
    "matter": {
        "behind it": Entry((("matter", f"deviceid_{NODE}-3"),), (), f"{NODE}-3-MatterLight-6-0"),
        "beside it": Entry((("matter", f"deviceid_{NODE[:-1]}2-MatterNodeDevice"),), (), "2"),
    },
}
"""By the dialect of the house's own lamp: devices of Home Assistant."""


@pytest.mark.parametrize("dialect", ALIKE)
async def test_devices_with_identifiers_that_are_alike_stay_apart(dialect: str, tmp_path: Path) -> None:
    registered = ALIKE[dialect]
    async with two_ways(tmp_path, dialect, "lamp", registered) as node:
        found = await lamps(node, lambda found: len(of_home_assistant(found)) == len(registered))
    assert {one.name: len(one.endpoints) for one in found} == {"lamp": 1, **dict.fromkeys(registered, 1)}
