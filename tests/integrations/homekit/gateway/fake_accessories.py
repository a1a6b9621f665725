"""Accessories in memory, behind the port of the HomeKit gateway, and the mDNS gateway that finds them."""

from collections.abc import AsyncIterator, Iterable, Mapping
from contextlib import asynccontextmanager
from typing import cast

import anyio

from homebot.devices import GatewayNames, GatewayState, Sighting
from homebot.devices.device import KeyValue
from homebot.errors import LinkError, RefusedError, WrongCodeError
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile
from homebot.integrations.homekit.gateway.port import (
    FoundAccessory,
    HomekitLink,
    HomekitPort,
    HomekitValues,
    OnEvent,
    Pairing,
    StatusCodes,
)
from homebot.messages import Time

PERMS = ["pr", "pw", "ev"]
CODE = "031-45-154"
_KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_SECRET = "c0ffee"


def characteristic(
    iid: int, kind: str, value: object, perms: list[str] | None = None, **more: object
) -> dict[str, object]:
    """A characteristic as ``GET /accessories`` lists it."""
    shape = "bool" if isinstance(value, bool) else "float" if isinstance(value, float) else "uint8"
    return {"iid": iid, "type": kind, "perms": perms or PERMS, "format": shape, "value": value, **more}


def service(iid: int, kind: str, *characteristics: dict[str, object]) -> dict[str, object]:
    return {"iid": iid, "type": kind, "characteristics": list(characteristics)}


def accessory(aid: int, name: str, *services: dict[str, object], serial: str = "") -> dict[str, object]:
    facts = {"23": name, "20": "homebot", "21": "SIM", "30": serial, "52": "1.0"}
    texts = (
        characteristic(100 + at, kind, text, ["pr"], format="string") for at, (kind, text) in enumerate(facts.items())
    )
    return {"aid": aid, "services": [service(1, "3E", *texts), *services]}


def lamp_service() -> dict[str, object]:
    return service(
        8,
        "00000043-0000-1000-8000-0026BB765291",
        characteristic(9, "25", False),
        characteristic(10, "8", 50, minValue=0, maxValue=100),
        characteristic(11, "13", 0.0, minValue=0, maxValue=360),
        characteristic(12, "2F", 0.0, minValue=0, maxValue=100),
        characteristic(13, "CE", 300, minValue=140, maxValue=500),
    )


class FakeServer:
    """An accessory server: an accessory or a bridge.

    Attributes:
        accessories: What it lists.
        written: The writes that it got, in their order.
        status: The HAP status of all writes.
        is_there: Whether it can be reached.
        away: The accessories that the bridge does not reach.
        knows_homebot: Whether it accepts homebot's key.
        answers: Whether it answers requests.
        attempts: How often a connection was attempted.
        service_type: The type of its service.
    """

    def __init__(self, key: str, name: str, *accessories: dict[str, object]) -> None:
        self.key, self.name = key, name
        self.accessories = list(accessories)
        self.written: list[tuple[tuple[int, int], object]] = []
        self.timed: list[bool] = []
        self.status = 0
        self.is_there = True
        self.away: set[int] = set()
        self.service_type = "_hap._tcp"
        self.knows_homebot = False
        self.answers = anyio.Event()
        self.answers.set()
        self.attempts = 0
        self.links: list[FakeLink] = []

    def find(self, aid: int, iid: int) -> dict[str, object]:
        services = next(one for one in self.accessories if one["aid"] == aid)["services"]
        listed = [c for s in cast("list[dict[str, list[dict[str, object]]]]", services) for c in s["characteristics"]]
        return next(one for one in listed if one["iid"] == iid)

    def report(self, aid: int, iid: int, value: object) -> None:
        """Change a value, and send the event."""
        self.find(aid, iid)["value"] = value
        self.send({(aid, iid): {"value": value}})

    def send(self, event: HomekitValues) -> None:
        for link in self.links:
            link.on_event(event)

    def drop(self) -> None:
        """Lose all connections."""
        for link in self.links:
            link.lost.set()
        self.links.clear()


class FakeLink(HomekitLink):
    def __init__(self, server: FakeServer, on_event: OnEvent) -> None:
        self.lost = anyio.Event()
        self.on_event = on_event
        self.subscribed: set[tuple[int, int]] = set()
        self._server = server

    async def list_accessories(self) -> object:
        return self._server.accessories

    async def read(self, ids: Iterable[tuple[int, int]]) -> HomekitValues:
        await self._answer()
        values = {(aid, iid): {"value": self._server.find(aid, iid)["value"]} for aid, iid in ids}
        assert values, "an accessory on Thread cannot be asked for nothing"
        return {at: {"status": -70402} if at[0] in self._server.away else value for at, value in values.items()}

    async def write(self, values: Mapping[tuple[int, int], object], *, is_timed: bool) -> StatusCodes:
        await self._answer()
        self._server.timed.append(is_timed)
        if self._server.status:
            return dict.fromkeys(values, self._server.status)
        for at, value in values.items():
            self._server.written.append((at, value))
            self._server.find(*at)["value"] = value
        return {}

    async def subscribe(self, ids: Iterable[tuple[int, int]]) -> None:
        self.subscribed.update(ids)

    async def unpair(self) -> None:
        self._server.knows_homebot = False

    async def _answer(self) -> None:
        await self._server.answers.wait()
        if self.lost.is_set():
            raise LinkError(f"{self._server.name} cannot be reached: the connection was lost")


class FakePort(HomekitPort):
    """The network of the servers."""

    def __init__(self, *servers: FakeServer) -> None:
        self.servers = {one.key: one for one in servers}

    @asynccontextmanager
    async def connected(self, found: FoundAccessory, pairing: Pairing, on_event: OnEvent) -> AsyncIterator[HomekitLink]:
        server = self._reach(found)
        server.attempts += 1
        await server.answers.wait()
        if not server.knows_homebot or pairing["secret"] != _SECRET:
            raise RefusedError(f"the connection to {found.name}", "it does not know homebot any more")
        link = FakeLink(server, on_event)
        server.links.append(link)
        try:
            yield link
        finally:
            if link in server.links:
                server.links.remove(link)

    async def pair(self, found: FoundAccessory, digits: str) -> Pairing:
        server = self._reach(found)
        if digits != CODE:
            raise WrongCodeError(f"the connection to {found.name}", "the code is wrong")
        server.knows_homebot = True
        return {"secret": _SECRET}

    def _reach(self, found: FoundAccessory) -> FakeServer:
        server = self.servers.get(found.id)
        if server is None or not server.is_there:
            raise LinkError(f"{found.name} cannot be reached")
        return server


class FakeMdns:
    """The mDNS gateway on a graph."""

    def __init__(self, graph: Graph) -> None:
        names = GatewayNames("mdns")
        self.node = Node(graph, "mdns", namespace="/gateway")
        self._states = self.node.create_publisher(GatewayState, names.state, _KEPT)
        self._sightings = self.node.create_publisher(Sighting, names.received_topics, _KEPT)
        self.state()

    def state(self, reason: str = "") -> None:
        self._states.publish(GatewayState(state="unavailable" if reason else "active", reason=reason, acts=True))

    def announce(
        self, server: FakeServer, *, is_removed: bool = False, version: str = "1", state: str = "1", **facts: str
    ) -> None:
        flags = "0" if server.knows_homebot else "1"
        found = {"dns_sd_type": server.service_type, "ip_address": "127.0.0.1", "port": "51826", "txt_id": server.key}
        txt = {"txt_sf": flags, "txt_c#": version, "txt_s#": state}
        self.sight(server.name, is_removed=is_removed, **{**found, **txt, **facts})

    def sight(self, name: str, *, is_removed: bool = False, service_type: str = "_hap._tcp", **facts: str) -> None:
        self._sightings.publish(
            Sighting(
                gateway="mdns",
                key=f"{name}.{service_type}.local.",
                kind="removed" if is_removed else "updated",
                why="it is announced",
                name=name,
                service_type=service_type,
                address="",
                command_address="",
                metadata=tuple(KeyValue(key=key, value=value) for key, value in facts.items()),
                seen_at=Time.from_seconds(0),
                expires_at=Time.from_seconds(100),
                confirmed=True,
            )
        )
