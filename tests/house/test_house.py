"""A world on MQTT: its devices speak, obey, lose their power, and come back with the broker.

In virtual time, but for the last tests; who listens is a client like any other.
"""

import asyncio
import tomllib
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import anyio
import pytest
import structlog.testing
from tests.patience import PATIENCE

from homebot.clock import LoopClock
from homebot.errors import UsageError
from homebot.house import SimulatedHouse, SimulatedLamp, WindowMotor, World
from homebot.house.description import parse_world
from homebot.house.devices import SimulatedDoorLock
from homebot.house.dialect import Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.family import dialects
from homebot.house.faults import Chatterbox, Unplugged
from homebot.house.mqtt_device import QUEUED
from homebot.house.rooms import DAY, Room, Rooms
from homebot.house.sensors import PowerMeter
from homebot.house.simulated_device import Placed, ScheduledCommand, SimulatedDevice
from homebot.integrations.thesis.simulated import ThesisDialect
from homebot.mqtt.broker import Broker, BrokerPolicy
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import ReasonCode
from homebot.testing import VirtualTimeLoop

pytestmark = pytest.mark.virtual_time

FAMILY = tomllib.loads((Path(__file__).parents[2] / "examples" / "houses" / "family.toml").read_text("utf-8"))


@dataclass
class Street:
    """A house, its broker, and somebody who listens before it: ``seconds topic payload``, the house's root left out."""

    broker: MemoryBroker
    house: SimulatedHouse
    listener: MqttConnection
    clock: LoopClock
    heard: list[str] = field(default_factory=list)

    async def tell(self, topic: str, payload: bytes) -> None:
        await self.listener.publish(f"villa/{topic}", payload, qos=1)

    async def listen(self) -> None:
        while True:
            messages = await self.listener.receive()
            for message in messages:
                self.note(message.topic, message.payload)
            self.listener.ack(messages)

    def note(self, topic: str, payload: bytes) -> None:
        self.heard.append(f"{self.clock.monotonic():g} {topic.removeprefix('villa/')} {payload.decode()}")

    async def settle(self) -> None:
        loop = asyncio.get_running_loop()
        assert isinstance(loop, VirtualTimeLoop)
        await loop.settled()

    async def heard_until(self, now: float) -> list[str]:
        """What was said until just before *now*, in seconds since the house was there."""
        await anyio.sleep(now - 0.001 - self.clock.monotonic())
        heard, self.heard = self.heard, []
        return heard


@asynccontextmanager
async def street(
    world: World,
    *,
    start: float = 0.0,
    heartbeat: float = 300.0,
    policy: BrokerPolicy | None = None,
    dialects: Mapping[str, Dialect] = dialects(),
) -> AsyncIterator[Street]:
    clock = LoopClock(start)
    async with (
        MemoryBroker(clock=clock, policy=policy, random=dice()) as broker,
        MqttConnection(
            MqttOptions.from_url(broker.url, session_expiry=3600),  # misses nothing, whoever is back first
            broker.make_client,
            status_topic=None,
            clock=clock,
            random=dice(),
        ) as listener,
        anyio.create_task_group() as tasks,
    ):
        await listener.subscribe(MqttSubscription("villa/+/+/out", qos=1), MqttSubscription("villa/+/status"))
        await listener.wait_connected()
        house = SimulatedHouse(
            broker.url,
            "villa",
            world,
            clock,
            make_client=broker.make_client,
            random=dice(),
            heartbeat=heartbeat,
            dialects=dialects,
        )
        there = Street(broker, house, listener, clock)
        tasks.start_soon(there.listen)
        await tasks.start(house.serve)
        await there.settle()
        yield there
        tasks.cancel_scope.cancel()


class SetClock:
    """A clock that somebody sets."""

    def __init__(self, clock: LoopClock) -> None:
        self._clock = clock
        self.ahead = 0.0

    def monotonic(self) -> float:
        return self._clock.monotonic()

    def now(self) -> float:
        return self._clock.now() + self.ahead


def dice() -> Random:
    return Random(0)  # noqa: S311 - a simulation has no secrets


def unplugged(device: SimulatedDevice, since: float, until: float) -> Unplugged:
    return Unplugged(device, dice(), since=since, until=until)


async def test_devices_say_how_they_are_and_obey() -> None:
    """A lamp at once; what it does not know it ignores."""
    async with street(World.of(SimulatedLamp("lamp", is_on=True))) as there:
        assert await there.heard_until(1.0) == ["0 lights/lamp/out on"]
        await there.tell("lights/lamp/in", b"\xff")
        await there.tell("lights/lamp/in", b"off")
        assert [line.partition(" ")[2] for line in await there.heard_until(2.0)] == ["lights/lamp/out off"]
        assert (there.house.counters.commands, there.house.counters.published) == (2, 2)


async def test_a_motor_takes_its_time_and_a_heartbeat_repeats_the_last_word_also_on_the_way() -> None:
    """A window that is opening is not open yet."""
    async with street(World.of(WindowMotor("motor", travel_time=15.0)), heartbeat=10.0) as there:
        await there.tell("windows/motor/in", b"open")
        assert await there.heard_until(25.0) == [
            "0 windows/motor/out closed",
            "0 windows/motor/out opening",
            "10 windows/motor/out opening",
            "15 windows/motor/out open",
            "20 windows/motor/out open",
        ]


async def test_a_heartbeat_has_the_power_again_as_its_message_also_has_the_energy() -> None:
    async with street(World.of(PowerMeter("meter")), heartbeat=10.0) as there:
        assert await there.heard_until(25.0) == [f"{seconds} power_meters/meter/out 0" for seconds in (0, 10, 20)]


async def test_the_world_goes_on_by_itself_and_hands_reach_it() -> None:
    """Timers of the house, and those who live there."""
    errands = [ScheduledCommand(7.0, "lamp", "on")]
    world = World(Rooms({"hall": Room()}, []), [Placed(SimulatedLamp("lamp"), "hall")], errands=errands)
    async with street(world) as there:
        await there.heard_until(1.0)
        assert await there.heard_until(8.0) == ["7 lights/lamp/out on"]
        there.house.press("lamp", "off")
        assert await there.heard_until(10.0) == ["7.999 lights/lamp/out off"]


async def test_a_house_begins_at_the_time_of_day_without_earlier_reports() -> None:
    """Its devices are as the morning left them."""
    errands = [ScheduledCommand(6 * 3600.0, "lamp", "on"), ScheduledCommand(8 * 3600.0, "lamp", "off")]
    world = World(Rooms({"hall": Room()}, []), [Placed(SimulatedLamp("lamp"), "hall")], errands=errands)
    async with street(world, start=20_000 * DAY + 7.5 * 3600.0, heartbeat=10_000.0) as there:
        assert await there.heard_until(3600.0) == ["0 lights/lamp/out on", "1800 lights/lamp/out off"]
        assert world.now > 8 * 3600.0


async def test_a_world_that_has_lived_goes_on_with_its_next_day() -> None:
    """Time does not go back."""
    world = World.of(SimulatedLamp("lamp"))
    world.run_until(2 * DAY + 5.0)
    async with street(world, start=20_000 * DAY + 3.0):
        assert world.now == 3 * DAY + 3.0


async def test_a_world_catches_up_after_its_clock_is_set_forward() -> None:
    """An hour at a time; a command that comes meanwhile does not wait for that. Set back, the world waits."""
    errands = [ScheduledCommand(6 * 3600.0, "lamp", "on"), ScheduledCommand(8 * 3600.0, "lamp", "off")]
    world = World(Rooms({"hall": Room()}, []), [Placed(SimulatedLamp("lamp"), "hall")], errands=errands)
    clock = SetClock(LoopClock(0.0))
    async with MemoryBroker(clock=clock) as broker, anyio.create_task_group() as tasks:
        house = SimulatedHouse(broker.url, "villa", world, clock, make_client=broker.make_client, random=dice())
        await tasks.start(house.serve)
        clock.ahead = 10 * DAY
        house.command("lamp", "0.5")
        assert world.now == 3600.0
        await anyio.sleep(1.0)
        assert world.now == pytest.approx(10 * DAY, abs=400.0)
        assert sum(event.what == "on" for event in world.event_log.since(0) if event.verb == "says") == 10
        clock.ahead = 0.0
        house.command("lamp", "on")
        assert world.now == pytest.approx(10 * DAY, abs=400.0)
        tasks.cancel_scope.cancel()


async def test_devices_come_back_with_the_broker_and_say_how_they_are() -> None:
    """What they could not say meanwhile is counted; the world did not wait."""
    async with street(World.of(WindowMotor("motor", travel_time=5.0), SimulatedLamp("lamp"))) as there:
        await there.heard_until(1.0)
        there.house.press("motor", "open")
        await there.broker.stop(abrupt=True)
        assert await there.heard_until(10.0) == []
        await there.broker.start()
        assert sorted(line.partition(" ")[2] for line in await there.heard_until(60.0)) == [
            "lights/lamp/out off",
            "windows/motor/out open",
        ]
        assert there.house.counters.unsaid == 2


async def test_a_device_without_power_is_gone_from_the_broker_until_it_has_some() -> None:
    """It hears nothing, and its first word is how it is. Others live on."""
    async with street(
        World.of(unplugged(SimulatedLamp("lamp"), 10.0, 40.0), SimulatedLamp("other")), heartbeat=25.0
    ) as there:
        await there.tell("lights/lamp/in", b"on")
        await there.heard_until(11.0)
        with pytest.raises(UsageError, match=r"no client 'villa-lamp' is connected; there are: .*villa-other"):
            there.broker.link_of("villa-lamp")
        await there.tell("lights/lamp/in", b"off")
        assert await there.heard_until(49.0) == ["25 lights/other/out off", "40 lights/lamp/out on"]
        await there.tell("lights/lamp/in", b"off")
        assert await there.heard_until(49.5) == ["48.999 lights/lamp/out off"]


async def test_a_device_may_have_no_power_from_the_beginning() -> None:
    """Then it is not there at all."""
    async with street(World.of(unplugged(SimulatedLamp("lamp"), 0.0, 40.0))) as there:
        assert await there.heard_until(50.0) == ["40 lights/lamp/out off"]


async def test_an_unplugged_device_stops_no_other_and_keeps_its_newest_report() -> None:
    """The older ones go, and are counted."""
    box = Chatterbox(SimulatedLamp("box"), dice(), times=500, every=0.01)
    async with street(World.of(box, SimulatedLamp("other"))) as there:
        await there.heard_until(1.0)
        there.broker.link_of("villa-box").freeze()
        there.house.press("box", "on")
        await there.heard_until(6.5)
        assert there.house.counters.overflowed == 499 - QUEUED
        await there.tell("lights/other/in", b"on")
        assert await there.heard_until(7.0) == ["6.499 lights/other/out on"]
        there.broker.link_of("villa-box").thaw()
        assert len(await there.heard_until(8.0)) == QUEUED + 1


async def test_refusals_of_the_broker_are_counted_and_logged_with_a_limit() -> None:
    """The device goes on."""

    class NoLights:
        def subscribe(self, client_id: str, filter: str) -> ReasonCode:  # noqa: A002, ARG002 - fills the port
            return ReasonCode.NOT_AUTHORIZED if filter.endswith("/in") else ReasonCode.SUCCESS

        def publish(self, client_id: str, topic: str) -> ReasonCode:  # noqa: ARG002 - fills the port
            return ReasonCode.NOT_AUTHORIZED if "lights" in topic else ReasonCode.SUCCESS

    with structlog.testing.capture_logs() as lines:
        async with street(World.of(SimulatedLamp("lamp"), WindowMotor("motor")), policy=NoLights()) as there:
            for number in range(3):
                there.house.press("lamp", "on" if number % 2 else "off")
            assert await there.heard_until(5.0) == ["0 windows/motor/out closed"]
            assert there.house.counters.refused == 4
    assert [line["topic"] for line in lines if line["event"] == "house.publish_refused"] == ["villa/lights/lamp/out"]


class Loud(ThesisDialect):
    """The thesis's, with everything else that a dialect may have."""

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        return (*super().filters(device), "villa/all/in")

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        return (
            OutgoingMessage(
                f"villa/{device.device_id}/status", f"{device.kind} in {device.room}".encode(), retain=True
            ),
        )

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        return OutgoingMessage(f"villa/{device.device_id}/status", b"gone", retain=True)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:  # noqa: ARG002 - fills the port
        return tuple(payload.decode().split(","))


async def test_a_dialect_defines_the_messages_on_the_wire() -> None:
    """Several topics, a birth before the state, a will, and commands out of any payload."""
    world = World(Rooms({"hall": Room()}, []), [Placed(SimulatedLamp("lamp"), "hall", dialect="loud")])
    async with street(world, dialects={"loud": Loud()}) as there:
        await there.tell("all/in", b"on,0.5")
        assert await there.heard_until(10.0) == [
            "0 lamp/status lamp in hall",
            "0 lights/lamp/out off",
            "0 lights/lamp/out on",
            "0 lights/lamp/out 0.5",
        ]
        there.broker.link_of("villa-lamp").abort()
        assert (await there.heard_until(20.0))[:2] == ["9.999 lamp/status gone", "9.999 lamp/status lamp in hall"]


async def test_a_power_failure_leaves_the_will() -> None:
    """Nobody says good-bye; with the power the device announces itself again."""
    lamp = Placed(unplugged(SimulatedLamp("lamp"), 10.0, 20.0), "hall", dialect="loud")
    async with street(World(Rooms({"hall": Room()}, []), [lamp]), dialects={"loud": Loud()}) as there:
        assert (await there.heard_until(15.0))[2:] == ["10 lamp/status gone"]
        assert (await there.heard_until(25.0))[0] == "20 lamp/status lamp in hall"


@pytest.mark.parametrize(
    ("world", "heartbeat", "words"),
    [
        (World.of(), 0.0, "heartbeat of 0 s"),
        (World.of(), float("nan"), "heartbeat of nan s"),
        (World.of(SimulatedLamp("a/b")), 1.0, "'a/b' cannot be a level of a topic"),
        (World.of(SimulatedLamp("a\ud800")), 1.0, "cannot be encoded as UTF-8"),
        (
            World(Rooms({"hall": Room()}, []), [Placed(SimulatedLamp("lamp"), "hall", dialect="x")]),
            1.0,
            "'lamp' speaks 'x'",
        ),
        pytest.param(
            World(Rooms({"hall": Room()}, []), [Placed(SimulatedDoorLock("bolt"), "hall", dialect="tasmota")]),
            1.0,
            "'bolt' speaks 'tasmota', which has no lock",
            marks=pytest.mark.rooms("tasmota"),
        ),
    ],
)
async def test_an_invalid_device_of_a_house_is_refused(world: World, heartbeat: float, words: str) -> None:
    """Before anything is connected."""
    with pytest.raises(UsageError, match=words):
        SimulatedHouse("mqtt://127.0.0.1", "villa", world, LoopClock(), heartbeat=heartbeat)


@pytest.mark.real_time
async def test_the_family_home_lives_on_sockets() -> None:
    """All of its devices appear, at the time of day that it is, and a lamp obeys."""
    world = parse_world(FAMILY, "family.toml")
    said: dict[str, str] = {}
    async with (
        Broker() as broker,
        MqttConnection(MqttOptions.from_url(broker.url), AiomqttClient, status_topic=None) as listener,
        anyio.create_task_group() as tasks,
    ):
        await listener.subscribe(MqttSubscription("villa/+/+/out", qos=1))
        await listener.wait_connected()
        clock = LoopClock(12 * 3600.0)
        house = SimulatedHouse(broker.url, "villa", world, clock)
        await tasks.start(house.serve)
        with anyio.fail_after(PATIENCE):
            while len(said) < len(world.devices):
                said |= await _received(listener)
            await listener.publish("villa/lights/living_lamp/in", b"0.25", qos=1)
            while said["villa/lights/living_lamp/out"] != "0.25":
                said |= await _received(listener)
        tasks.cancel_scope.cancel()
    assert {topic.split("/")[2] for topic in said} == set(world.devices)
    assert float(said["villa/light_levels/living_lux/out"]) > 0


async def _received(listener: MqttConnection) -> dict[str, str]:
    messages = await listener.receive()
    listener.ack(messages)
    return {message.topic: message.payload.decode() for message in messages}
