"""Bluetooth devices behind a Shelly that is found by mDNS: each is listed, commanded and missed with it."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

import anyio
from tests.gateways.mdns.lamp import Publisher, publisher
from tests.gateways.served import served
from tests.integrations.shelly.formats.rpc_documents import ID
from tests.integrations.shelly.formats.test_gen2_bluetooth import DOOR, DOOR_PARTS, TRV, component, valve
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE
from tests.simulated.http.web_server import WebPeer, WebReply, WebRequest, WebServer

from homebot.devices import Sighting
from homebot.devices.gateway_messages import REACHABLE, Command, Report, SendCommand
from homebot.devices.value import PlainValue, Value
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile

TYPE = "_shelly._tcp.local."
KEPT = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PAGE = 4
"""Components in one answer."""

INFO = {"id": ID, "mac": "A8032ABE54DC", "model": "S3GW-1DBT001", "gen": 3, "app": "BluGwG3", "auth_en": False}


class ScriptedGateway:
    """A gateway without components of its own, which answers calls with what it has."""

    def __init__(self) -> None:
        self.components: tuple[Mapping[str, object], ...] = (valve(name="Bath"), *DOOR_PARTS)
        self.called: list[tuple[str, object]] = []
        self.peer: WebPeer | None = None

    def answer(self, request: WebRequest) -> WebReply:
        return WebReply(json.dumps(INFO).encode()) if request.path == "/shelly" else WebReply(b"", 404)

    def greet(self, peer: WebPeer, path: str) -> bool:
        self.peer = peer
        return path == "/rpc"

    def receive(self, peer: WebPeer, message: bytes) -> None:
        call = json.loads(message)
        self.called.append((call["method"], call.get("params")))
        offset = (call.get("params") or {}).get("offset", 0)
        listed = {
            "components": self.components[offset : offset + PAGE],
            "offset": offset,
            "total": len(self.components),
        }
        results = {
            "Shelly.GetDeviceInfo": INFO,
            "Shelly.GetConfig": {"sys": {"device": {"name": "Gateway"}}},
            "Shelly.GetStatus": {"sys": {"mac": INFO["mac"]}, "wifi": {}},
            "Shelly.GetComponents": listed,
        }
        peer.send(json.dumps({"id": call["id"], "src": ID, "result": results.get(call["method"], {})}).encode())

    def notify(self, method: str, params: object) -> None:
        assert self.peer is not None
        self.peer.send(json.dumps({"src": ID, "dst": "homebot", "method": method, "params": params}).encode())


class Watched:
    """The sightings and values of a gateway by device."""

    def __init__(self, watcher: Node, gateway: MdnsGateway) -> None:
        self.sightings: dict[str, Sighting] = {}
        self.gone: list[str] = []
        self.values: dict[tuple[str, str, str], PlainValue] = {}
        self._all = (
            watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=KEPT),
            watcher.create_subscription(Report, gateway.names.readings, qos_profile=KEPT),
        )
        self._client = watcher.create_client(SendCommand, gateway.names.send_command)

    async def until_value(self, key: str, part: str, capability: str, value: PlainValue) -> None:
        with anyio.fail_after(PATIENCE):
            while self.values.get((key, part, capability), "") != value:
                report = await self._all[1].receive()
                self.values |= {(report.key, one.part, one.capability): one.value.plain() for one in report.readings}

    async def until_sighted(self, key: str, kind: str = "") -> Sighting:
        with anyio.fail_after(PATIENCE):
            while key not in self.sightings or self.sightings[key].kind != (kind or self.sightings[key].kind):
                sighting = await self._all[0].receive()
                self.sightings[sighting.key] = sighting
                self.gone += [sighting.key] if sighting.kind == "removed" else []
        return self.sightings[key]

    async def command(self, key: str, part: str, capability: str, value: PlainValue) -> bool:
        request = Command(key=key, part=part, capability=capability, value=Value.of(value))
        return (await self._client.call(request, timeout=PATIENCE)).success


@asynccontextmanager
async def house() -> AsyncIterator[tuple[Watched, Publisher]]:
    graph = Graph()
    settings = MdnsGatewaySettings(interfaces=("127.0.0.1",), service_types=(TYPE,), announce=False)
    async with (
        alone_on_loopback(),
        publisher() as computer,
        Node(graph, "watcher") as watcher,
        Node(graph, "mdns", namespace="/gateway") as node,
        anyio.create_task_group() as tasks,
    ):
        gateway = MdnsGateway(node, settings)
        watched = Watched(watcher, gateway)
        await tasks.start(gateway.serve)
        yield watched, computer
        tasks.cancel_scope.cancel()


async def test_a_gateway_with_many_has_them_on_dozens_of_pages() -> None:
    shelly = ScriptedGateway()
    senders = [
        component(f"bthomedevice:{200 + number}", f"3c:2e:f5:71:d6:{number:02x}", {"rssi": -59}, model=2)
        for number in range(100)
    ]
    shelly.components = tuple(senders)
    server = WebServer(shelly)
    async with house() as (watched, computer), served(server):
        await computer.announce(ID, server.port, {"gen": "3"}, service_type=TYPE)
        await watched.until_sighted(f"{ID}/3c:2e:f5:71:d6:63")


async def test_each_is_listed_commanded_and_missed_with_the_shelly() -> None:
    shelly, door, trv = ScriptedGateway(), f"{ID}/{DOOR}", f"{ID}/{TRV}"
    server = WebServer(shelly)
    async with house() as (watched, computer):
        async with served(server):
            await computer.announce(ID, server.port, {"gen": "3"}, service_type=TYPE)
            await watched.until_value(door, "window", "contact", True)
            found = await watched.until_sighted(door)
            assert (found.name, found.identifiers) == ("Front door", (f"mac:{DOOR.replace(':', '')}",))
            assert await watched.command(trv, "thermostat", "heating_setpoint", 21.0)
            params = {"id": 200, "method": "TRV.SetTarget", "params": {"id": 0, "target_C": 21.0}}
            assert shelly.called[-1] == ("BluTRV.Call", params)
            shelly.notify("NotifyStatus", {"bthomesensor:202": {"id": 202, "value": False, "last_updated_ts": 9}})
            await watched.until_value(door, "window", "contact", False)
        await watched.until_value(trv, "", REACHABLE, False)
        shelly.components = shelly.components[:1]
        async with served(server):
            await watched.until_value(trv, "", REACHABLE, True)
            await watched.until_sighted(door, "removed")
            assert watched.gone == [door]
            await computer.withdraw(ID, TYPE)
            await watched.until_sighted(trv, "removed")
