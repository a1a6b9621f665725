"""Houses in which simulated devices of one family come and go, with the gateway that finds them."""

from __future__ import annotations

import hashlib
import itertools
import sys
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

import anyio
from anyio.abc import TaskGroup, TaskStatus

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.graph import Graph
from homebot.house.connected_device import ConnectedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.family import dialects
from homebot.house.mqtt_device import HouseCounters, MqttDevice
from homebot.house.network import HouseNetwork
from homebot.log import LogLimit
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Will
from homebot.runtime import Runtime

sys.path.append(str(Path(__file__).parents[1]))
from tests.simulated.families import FAMILIES

__all__ = ["HOUSES", "House", "HouseSpec", "Joined", "house_of"]

HOME = "home425"
KEEP_ALIVE = 30
PAIRED = 120
"""HomeKit bridges that homebot is paired with before they come."""


@dataclass(frozen=True, slots=True)
class HouseSpec:
    """What devices come to a house.

    Attributes:
        gateway: The gateway that finds them.
        family: Their dialect or served family; ``tag`` for NFC tags.
        kind: Their kind.
        rule: When a device that died without a word is noticed, by the rules of its protocol and gateway.
    """

    gateway: str
    family: str
    kind: str
    rule: str


HOUSES: Mapping[str, HouseSpec] = MappingProxyType(
    {
        "mqtt, Home Assistant discovery": HouseSpec("mqtt", "homeassistant", "lamp", "last will; 1.5 x keep-alive"),
        "mdns, WLED": HouseSpec("mdns", "wled", "lamp", "connection lost, or silent for 24 s; SRV 120 s + 3 s"),
        "mdns, ESPHome": HouseSpec("mdns", "esphome", "lamp", "connection lost, or silent for 26 s; SRV 120 s + 3 s"),
        "ble, BTHome sensor": HouseSpec(
            "ble", "bthome", "lux", "3 intervals, at least 30 s; on a battery, as here, 5 min"
        ),
        "ble, connected light": HouseSpec("ble", "ble_light", "lamp", "3 intervals, at least 30 s"),
        "coap, resource directory": HouseSpec("coap", "coap", "lamp", "lifetime of the registration, here 60 s"),
        "matter, node of a server": HouseSpec("matter", "matter", "lamp", "as the Matter server says"),
        "thing_directory, thing": HouseSpec(
            "thing_directory", "thing_directory", "lamp", "its server no longer answers"
        ),
        "homeassistant, device": HouseSpec("homeassistant", "home_assistant", "lamp", "as Home Assistant says"),
        "homekit, lamp and its bridge": HouseSpec("homekit", "homekit", "lamp", "connection lost, or silent for 38 s"),
        "hue, lamp of a bridge": HouseSpec("hue", "hue", "lamp", "as the bridge says"),
        "nfc, tag at a reader": HouseSpec("nfc", "tag", "tag", "the reader polls"),
    }
)
"""Every house by the name that the table has for it."""


class Joined:
    """A device that has joined.

    Args:
        marks: Texts of which one is in the description of the device and of no other.
        cut_power: Lets it die without a word.
    """

    def __init__(self, marks: tuple[str, ...], cut_power: Callable[[], None]) -> None:
        self.marks = marks
        self.cut_power = cut_power


class House:
    """A house with homebot, which runs.

    Args:
        graph: homebot's graph.
        tasks: What devices live in.

    Attributes:
        is_for_one: Whether only one device can be there at a time.
    """

    is_for_one = False

    def __init__(self, graph: Graph, tasks: TaskGroup) -> None:
        self.graph = graph
        self._tasks = tasks

    def join(self, name: str) -> Joined:
        """Let a new device join."""
        raise NotImplementedError

    def live(self, device: ConnectedDevice, *marks: str) -> Joined:
        """Let *device* live, which can be told by its *marks*."""
        device.begin(DeviceState(text="off"), has_power=True)
        self._tasks.start_soon(device.live)
        return Joined(marks, partial(device.power, on=False))


class _ServedHouse(House):
    def __init__(self, graph: Graph, tasks: TaskGroup, network: HouseNetwork, spec: HouseSpec) -> None:
        super().__init__(graph, tasks)
        self._network = network
        self._spec = spec
        self._hosts = (f"127.0.{number // 250}.{number % 250 + 2}" for number in itertools.count())

    def join(self, name: str) -> Joined:
        options = {}
        if self._spec.family == "coap" and sys.platform == "linux":
            options["host"] = next(self._hosts)  # a directory bounds the registrations of one address
        device = self._network.connect(
            FAMILIES[self._spec.family], _info(self._spec, name), lambda _command: None, **options
        )
        mac: str = getattr(device, "mac", "")  # what a WLED announces instead of a name
        return self.live(device, name, *([mac[-6:].lower()] if mac else []))


class _MqttHouse(House):
    def __init__(self, graph: Graph, tasks: TaskGroup, url: str, spec: HouseSpec) -> None:
        super().__init__(graph, tasks)
        self._url = url
        self._spec = spec

    def join(self, name: str) -> Joined:
        info, dialect, clock = _info(self._spec, name), dialects()[self._spec.family], LoopClock()
        will = dialect.will(info)
        options = MqttOptions.from_url(
            self._url,
            client_id=name,
            keep_alive=KEEP_ALIVE,
            will=None if will is None else Will(will.topic, will.payload, will.qos, will.retain),
        )
        connection = MqttConnection(options, NativeClient, status_topic=None, clock=clock)
        device = MqttDevice(info, dialect, connection, lambda _command, _id: None, HouseCounters(), LogLimit(clock))
        return self.live(device, name)


@asynccontextmanager
async def house_of(spec: HouseSpec) -> AsyncIterator[House]:
    """Run homebot in a house of such devices inside the block; none is there yet.

    Raises:
        UsageError: A library is not installed.
    """
    if spec.family == "tag":
        async with _tag_house() as house:
            yield house
    elif spec.family == "matter":
        async with _matter_house(spec) as house:
            yield house
    elif spec.family == "thing_directory":
        async with _thing_house(spec) as house:
            yield house
    elif spec.family == "homekit":
        async with _homekit_house(spec) as house:
            yield house
    elif spec.family in dialects():
        async with _running({"mqtt": {"root": HOME}}) as runtime, anyio.create_task_group() as tasks:
            broker = runtime.service(HostedBroker)
            assert broker is not None
            yield _MqttHouse(runtime.graph, tasks, broker.url, spec)
            tasks.cancel_scope.cancel()
    else:
        network = HouseNetwork([FAMILIES[spec.family]])
        async with (
            network.running(None) as services,
            _running(network.gateways(), *services) as runtime,
            anyio.create_task_group() as tasks,
        ):
            yield _ServedHouse(runtime.graph, tasks, network, spec)
            tasks.cancel_scope.cancel()


def _running(gateways: Mapping[str, object], *services: object) -> Runtime:
    return Runtime(parse_config({"gateways": gateways}, "benchmark"), with_door=False, services=services)


@asynccontextmanager
async def _matter_house(spec: HouseSpec) -> AsyncIterator[House]:
    from tests.integrations.matter.simulated.node import ServedMatterNode  # noqa: PLC0415 - an extra
    from tests.integrations.matter.simulated.server import SimulatedMatterServer  # noqa: PLC0415 - an extra

    server = SimulatedMatterServer()

    class MatterHouse(House):
        def join(self, name: str) -> Joined:
            return self.live(ServedMatterNode(_info(spec, name), lambda _command: None, server), name)

    async with anyio.create_task_group() as tasks:
        await tasks.start(server.serve)
        async with _running({"matter": {"url": server.url}}) as runtime:
            yield MatterHouse(runtime.graph, tasks)
            tasks.cancel_scope.cancel()


@asynccontextmanager
async def _thing_house(spec: HouseSpec) -> AsyncIterator[House]:
    from tests.things.directory import ThingDirectoryServer  # noqa: PLC0415 - an extra
    from tests.things.thing import ServedThing  # noqa: PLC0415 - likewise

    directory = ThingDirectoryServer()

    class ThingHouse(House):
        def join(self, name: str) -> Joined:
            thing = ServedThing(_info(spec, name), lambda _command: None)
            tasks.start_soon(self._register, thing)
            return self.live(thing, name)

        async def _register(self, thing: ServedThing) -> None:
            while not thing.server.port:
                await anyio.sleep(0.001)
            directory.register(thing.description())

    async with anyio.create_task_group() as tasks:
        await tasks.start(directory.serve)
        async with _running({"thing_directory": {"url": directory.url}}) as runtime:
            yield ThingHouse(runtime.graph, tasks)
            tasks.cancel_scope.cancel()


@asynccontextmanager
async def _homekit_house(spec: HouseSpec) -> AsyncIterator[House]:
    from tests.integrations.homekit.simulated.bridge import ServedAccessory, SimulatedHomekitBridge  # noqa: PLC0415 - an extra

    network = HouseNetwork([FAMILIES[spec.family]])
    gateways = network.gateways()
    pairings = Path(str(gateways["homekit"]["pairings"]))
    paired: list[tuple[SimulatedHomekitBridge, anyio.CancelScope]] = []

    async def serve(*, task_status: TaskStatus[None]) -> None:
        number = len(paired)
        bridge = SimulatedHomekitBridge("127.0.0.1", pairings, f"02:48:42:01:{number // 100:02}:{number % 100:02}")
        with anyio.CancelScope() as scope:
            paired.append((bridge, scope))
            await bridge.serve(task_status=task_status)

    class HomekitHouse(House):
        def join(self, name: str) -> Joined:
            bridge, scope = paired.pop()
            self.live(ServedAccessory(_info(spec, name), lambda _command: None, bridge))
            return Joined((name,), scope.cancel)

    async with anyio.create_task_group() as tasks:
        for _ in range(PAIRED):
            await tasks.start(serve)
        async with _running(gateways) as runtime:
            yield HomekitHouse(runtime.graph, tasks)
            tasks.cancel_scope.cancel()


@asynccontextmanager
async def _tag_house() -> AsyncIterator[House]:
    from tests.simulated.nfc.field import TagField  # noqa: PLC0415 - likewise
    from tests.simulated.nfc.type4_card import Type4Card  # noqa: PLC0415 - likewise

    from homebot.conventions.nfc.ndef_message import NdefRecord, write_ndef  # noqa: PLC0415 - an extra

    field = TagField()

    class TagHouse(House):
        is_for_one = True

        def join(self, name: str) -> Joined:
            uid = "04" + hashlib.sha256(name.encode()).hexdigest()[:12]
            message = write_ndef(NdefRecord("uri", f"homebot:device/lights/{name}".encode()))
            field.card = Type4Card(bytes.fromhex(uid), message)
            return Joined((uid,), partial(setattr, field, "card", None))

    async with (
        field.served(),
        _running({"nfc": {"devices": [field.path]}}) as runtime,
        anyio.create_task_group() as tasks,
    ):
        yield TagHouse(runtime.graph, tasks)
        tasks.cancel_scope.cancel()


def _info(spec: HouseSpec, name: str) -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo(HOME, spec.kind, name, "lights" if spec.kind == "lamp" else "sensors", "hall")
