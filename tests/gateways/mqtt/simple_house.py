"""A house on a broker in memory, in virtual time, whose devices announce themselves by a small convention."""

import json
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from random import Random
from typing import ClassVar, TypeVar

import anyio
import anyio.abc
from pydantic import BaseModel, ConfigDict

from homebot.clock import Clock, LoopClock
from homebot.conventions.description import (
    AnnouncementEvent,
    AutoExpiry,
    Availability,
    DescribedPart,
    DeviceAnnounced,
    DeviceRequest,
    DeviceWithdrawn,
    Publication,
)
from homebot.conventions.payload import parse_object
from homebot.devices import RawMessage, Sighting, SubscribeToTopic
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse, Quarantine
from homebot.devices.identity import identifiers
from homebot.devices.part import Capability, Part
from homebot.devices.services import SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.value import PlainValue, Value
from homebot.errors import RefusedError, WireError
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile, Subscription
from homebot.messages import Time
from homebot.messages.message import Message
from homebot.mqtt.broker import BrokerPolicy
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions

MessageT = TypeVar("MessageT", bound=Message)

LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class SimpleSettings(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    prefix: str = "hello"
    birth: str = ""


@dataclass(frozen=True)
class OnlineWord:
    topic: str

    def read(self, payload: bytes) -> bool | None:
        return {b"online": True, b"offline": False}.get(payload)


@dataclass(frozen=True)
class SimpleCodec:
    """Says ``CAPABILITY=on|off|<text>``, several parted by blanks; ``crash`` raises :attr:`crash`."""

    crash: ClassVar[BaseException] = RuntimeError("crash")

    state: str
    command: str

    def topics(self) -> tuple[str, ...]:
        return (self.state,)

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        del topic, retained
        if payload == b"crash":
            raise self.crash
        told: dict[str, PlainValue] = {}
        for pair in payload.decode(errors="replace").split():
            name, mark, value = pair.partition("=")
            if mark:
                told[name] = {"on": True, "off": False, "?": None}.get(value, value)
        return told

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        del transition
        if capability == "crash":
            raise self.crash
        if capability != "on_off" or not isinstance(value, bool):
            raise RefusedError(capability, "this part takes on_off")
        return (Publication(self.command, b"ON" if value else b"OFF"),)


class SimpleConvention:
    """``PREFIX/ID`` announces in JSON: name, parts, ids, online, latest, mode, asks, fade, is_live, blind."""

    Settings: ClassVar[type[BaseModel]] = SimpleSettings
    name: ClassVar[str] = "simple"

    def __init__(self, settings: SimpleSettings) -> None:
        self.rejected = 0
        self._settings = settings

    def filters(self) -> tuple[str, ...]:
        return (f"{self._settings.prefix}/+", "covered/#")

    def birth_messages(self) -> tuple[Publication, ...]:
        return (Publication(self._settings.birth, b"who"),) if self._settings.birth else ()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        del retained
        prefix, _, key = topic.partition("/")
        if prefix != self._settings.prefix:
            return ()
        match payload:
            case b"":
                return (DeviceWithdrawn(key, "it was withdrawn"),)
            case b"bye":
                return (DeviceWithdrawn(key, "it left", is_final=True),)
            case b"who?":
                return (DeviceRequest(key, (Publication(f"ask/{key}", b"who are you"),)),)
            case b"crash":
                raise SimpleCodec.crash
        try:
            told = parse_object(payload)
        except WireError:
            self.rejected += 1
            raise
        return (_described(topic, key, told),)


def _described(topic: str, key: str, told: dict[str, object]) -> DeviceAnnounced:
    def text(name: str, otherwise: str) -> str:
        return str(told.get(name, otherwise))

    names = text("parts", "lamp").split()
    states = text("state", f"{key}/state").split()
    fades = (AutoExpiry("on_off", 5.0, value=False, only=True),) if "fade" in told else ()
    parts = tuple(
        DescribedPart(
            Part(
                id=name,
                service_type="light",
                capabilities=(Capability(name="on_off", settable=True, readable="blind" not in told),),
                reads=(state,),
                writes=(f"{key}/{name}/set",),
            ),
            SimpleCodec(state, f"{key}/{name}/set"),
            state_requests=(Publication(f"{key}/get", b""),) if "asks" in told else (),
            expiries=fades,
        )
        for name, state in zip(names, states * len(names), strict=False)
    )
    online = text("online", "").split()
    return DeviceAnnounced(
        key=key,
        convention=SimpleConvention.name,
        identifiers=identifiers(text("ids", key).split()),
        name=text("name", key),
        parts=parts,
        topic=topic,
        area=text("area", ""),
        facts={"model": text("model", "simple")},
        availability=Availability(tuple(OnlineWord(one) for one in online), "all") if online else None,
        implies_alive="is_live" in told,
    )


@dataclass
class House:
    """A gateway, a node that watches it, and a client on the devices' side of the broker."""

    broker: MemoryBroker
    graph: Graph
    gateway: MqttGateway
    watcher: Node
    devices: MqttConnection
    sightings: Subscription[Sighting]
    reports: Subscription[Report]
    quarantine: Subscription[Quarantine]

    async def say(self, topic: str, payload: str | bytes | Mapping[str, object] = "", *, retain: bool = False) -> None:
        """Publish, and wait until everybody is done with it."""
        words = json.dumps(payload) if isinstance(payload, Mapping) else payload
        await self.devices.publish(topic, words.encode() if isinstance(words, str) else words, qos=1, retain=retain)
        await settled()

    async def announce(self, key: str, *, retain: bool = True, **fields: object) -> None:
        await self.say(f"hello/{key}", fields, retain=retain)

    def sighted(self) -> list[Sighting]:
        """The sightings since the last call."""
        return _drain(self.sightings)

    def told(self) -> list[tuple[str, dict[str, PlainValue], bool]]:
        """The reports since the last call: key, values by ``part.capability``, and whether they were kept ones."""
        return [
            (one.key, {f"{r.part}.{r.capability}": r.value.plain() for r in one.readings}, one.retained)
            for one in _drain(self.reports)
            if not one.unreadable
        ]

    async def command(
        self,
        key: str,
        part: str,
        capability: str,
        value: PlainValue,
        expires_after: float = 0.0,
        kept_for: float = 0.0,
    ) -> SendCommandResponse:
        client = self.watcher.create_client(SendCommand, self.gateway.names.send_command)
        wanted = Value.of(value)
        return await client.call(
            Command(
                key=key,
                part=part,
                capability=capability,
                value=wanted,
                expires_after=expires_after,
                kept_for=kept_for,
            )
        )

    async def subscribe(self, topic: str, listener: str = "/watcher") -> SubscribeToTopicResponse:
        """Ask for the raw messages of *topic*, those since the start as well."""
        client = self.watcher.create_client(SubscribeToTopic, self.gateway.names.subscribe)
        start = Time(sec=0, nanosec=0)
        return await client.call(SubscribeToTopicRequest(topic=topic, listener=listener, since=start))

    def raw(self, response: SubscribeToTopicResponse) -> Subscription[RawMessage]:
        return self.watcher.create_subscription(RawMessage, response.data_topic, qos_profile=10)

    async def health(self) -> HealthResponse:
        return await self.watcher.create_client(GetHealth, self.gateway.names.health).call(HealthRequest())

    async def heard(self) -> list[MqttMessage]:
        """What came on the topics that the devices' side subscribed to."""
        await settled()
        with anyio.move_on_after(0.001):
            return await self.devices.receive()
        return []

    async def cut(self) -> None:
        """Cut the gateway's link, and wait until it has a new one."""
        self.broker.links[-1].abort()
        await anyio.sleep(5)

    async def listen(self, *filters: str) -> None:
        await self.devices.subscribe(*(MqttSubscription(one) for one in filters))


async def settled() -> None:
    """Wait until nothing is left to do at this moment: virtual time goes on only then."""
    await anyio.sleep(0.001)


def _drain(subscription: Subscription[MessageT]) -> list[MessageT]:
    found: list[MessageT] = []
    while (one := subscription.take()) is not None:
        found.append(one)
    return found


@asynccontextmanager
async def simple_house(
    before: Callable[[MqttConnection], Awaitable[None]] | None = None,
    clock: Callable[[], Clock] = LoopClock,
    policy: BrokerPolicy | None = None,
    **settings: object,
) -> AsyncIterator[House]:
    """Run a house; *settings* are those of its gateway, *before* is done before that starts, by *clock*.

    Args:
        policy: What the broker refuses.
    """
    table = {"root": "home425", "act": True, "conventions": (f"{__name__}:SimpleConvention",), **settings}
    graph = Graph(clock())
    async with (
        MemoryBroker(policy=policy, random=Random(1)) as broker,  # noqa: S311 - the same run each time
        Node(graph, "mqtt", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
        MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as devices,
        anyio.create_task_group() as tasks,
    ):
        await devices.wait_connected()
        if before is not None:
            await before(devices)
        gateway = MqttGateway(
            node,
            MqttGatewaySettings.model_validate({"url": broker.url, **table}),
            GatewayContext.of(
                HostedBroker.in_memory(broker),
                random=Random(1),  # noqa: S311 - the same run each time
            ),
        )
        house = House(
            broker,
            graph,
            gateway,
            watcher,
            devices,
            watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=LATCHED),
            watcher.create_subscription(Report, gateway.names.readings, qos_profile=LATCHED),
            watcher.create_subscription(Quarantine, gateway.names.quarantine, qos_profile=LATCHED),
        )
        await tasks.start(gateway.serve)
        await settled()
        yield house
        tasks.cancel_scope.cancel()
