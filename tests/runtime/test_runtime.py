"""The whole of homebot in one process: its order, its failures and its end."""

import socket
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import anyio
import pytest
import structlog
from anyio.abc import TaskStatus
from pydantic import BaseModel
from structlog.testing import capture_logs
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.apps import App
from homebot.clock import Clock
from homebot.config import Config, parse_config
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.names import PLACE_DEVICE
from homebot.devices.places_messages import PlaceDevice
from homebot.errors import ConfigError, LinkError
from homebot.feature import all_features
from homebot.gateways import HostService
from homebot.gateways.memory import MemoryGateway
from homebot.gateways.mqtt import MqttGateway
from homebot.gateways.mqtt.embedded_broker import embedded_broker
from homebot.graph import Graph, Node
from homebot.house import thesis_world
from homebot.messages import Log
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime


class Crashing(MemoryGateway):
    """Is ready, and crashes a second later."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        task_status.started()
        await anyio.sleep(1.0)
        raise RuntimeError("the gateway is ill")


def broker_url(runtime: Runtime) -> str:
    """Return the address of its embedded broker."""
    broker = runtime.service(HostedBroker)
    assert broker is not None
    return broker.url


class Journal:
    """What the apps under test write down, to be waited for."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._changed = anyio.Event()

    def write(self, line: str) -> None:
        self.lines.append(line)
        self._changed.set()

    async def wait_for(self, line: str, times: int = 1) -> None:
        with anyio.fail_after(PATIENCE):
            while self.lines.count(line) < times:
                self._changed = anyio.Event()
                await self._changed.wait()


JOURNAL = Journal()


@pytest.fixture(autouse=True)
def _empty_journal() -> None:
    JOURNAL.lines.clear()


class Broken(App):
    """Crashes before it is ready."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:  # noqa: ARG002
        raise RuntimeError("ouch")

    async def run(self) -> None: ...


class Steady(App):
    """Writes down when it starts and when it ends."""

    async def run(self) -> None:
        JOURNAL.write(f"{self.node.name} starts")
        try:
            await anyio.sleep_forever()
        finally:
            JOURNAL.write(f"{self.node.name} ends")


class Impossible(App):
    """Cannot be made as it is configured."""

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        raise ConfigError("test", "apps.impossible", "is impossible")

    async def run(self) -> None:
        """Never comes to this."""


class NeverReady(App):
    """Forgets to say that it is ready."""

    async def run(self) -> None:
        """Not used."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:  # noqa: ARG002  # forgotten
        JOURNAL.write("never ready")
        await anyio.sleep_forever()


class OnItsOwnPort(MqttGateway):
    """One whose broker has a port that no other homebot takes when it is free again."""

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:  # noqa: ARG003  # all the same
        return (HostService(HostedBroker, _broker_on_its_own_port),)


@asynccontextmanager
async def _broker_on_its_own_port(graph: Graph, clock: Clock) -> AsyncIterator[HostedBroker]:
    async with embedded_broker(graph, clock, ports=[reserve_port()]) as broker:
        yield HostedBroker(broker.url)


def config(**tables: object) -> Config:
    return parse_config({"door": {"port": 0}, **tables}, "test")


def app(kind: type[App]) -> dict[str, object]:
    return {"class": f"{__name__}:{kind.__name__}"}


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``module:Class`` is looked up: by the name of the module."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])


async def test_parts_start_in_order_and_stop_in_reverse() -> None:
    runtime = Runtime(config(gateways={"mqtt": {}}, apps={"first": app(Steady), "second": app(Steady)}))
    with runtime.graph.watch() as changes:
        async with runtime:
            assert not runtime.supervisor.crashes
        nodes: dict[str, list[str]] = {"added": [], "removed": []}
        while (change := changes.take()) is not None:
            if change.entity.kind.value == "node":
                nodes[change.change].append(change.entity.name)
    assert nodes["added"] == [
        "/homebot",
        "/broker",
        "/gateway/mqtt",
        "/discovery",
        "/control",
        *(f"/{feature.name}" for feature in all_features() if feature.server),
        "/first",
        "/second",
        "/rosbridge_websocket",
        "/rosapi",
    ]
    assert nodes["removed"] == nodes["added"][::-1]
    assert JOURNAL.lines == ["first starts", "second starts", "second ends", "first ends"]


@pytest.mark.virtual_time
async def test_a_gateway_an_app_and_a_part_of_homebot_with_one_name_crash_each_for_itself() -> None:
    gateways = {name: {"class": f"{__name__}:Crashing"} for name in ("control", "steady", "house")}
    tables = {"gateways": gateways, "apps": {name: app(Steady) for name in ("steady", "house")}}
    async with Runtime(config(**tables), with_door=False) as runtime:
        await anyio.sleep(30)
        crashes = runtime.supervisor.crashes
        assert sorted(crashes) == ["gateway/control", "gateway/house", "gateway/steady"]
        assert {crash.last for crash in crashes.values()} == {"RuntimeError: the gateway is ill"}


async def test_what_cannot_be_started_ends_the_start_and_everything_stops_again() -> None:
    """With its own error, in no group."""
    gateways = {"mqtt": {"class": f"{__name__}:{OnItsOwnPort.__name__}"}}
    runtime = Runtime(config(gateways=gateways, apps={"steady": app(Steady), "impossible": app(Impossible)}))
    with pytest.raises(ConfigError, match=r"test: apps\.impossible: is impossible"):
        async with runtime:
            pytest.fail("it must not start")
    assert runtime.graph.get_node_names() == ()
    assert JOURNAL.lines == ["steady starts", "steady ends"]
    assert not await listens(broker_url(runtime))


async def test_a_start_can_be_cut_short() -> None:
    """Somebody wants to stop before everything is there: nothing more is waited for, and what runs is stopped."""
    runtime = Runtime(config(apps={"never": app(NeverReady), "steady": app(Steady)}))

    async def cut() -> None:
        await JOURNAL.wait_for("never ready")
        runtime.cut_start_short()

    with anyio.fail_after(PATIENCE):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(cut)
            async with runtime:
                assert runtime.rosbridge is None
    assert JOURNAL.lines == ["never ready"]
    assert runtime.graph.get_node_names() == ()


async def test_a_start_that_is_cancelled_stops_what_it_started() -> None:
    runtime = Runtime(config(gateways={"mqtt": {}}, apps={"steady": app(Steady), "never": app(NeverReady)}))

    async def start() -> None:
        async with runtime:
            pytest.fail("it cannot be ready")

    with anyio.fail_after(PATIENCE):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(start)
            await JOURNAL.wait_for("never ready")
            tasks.cancel_scope.cancel()
    assert runtime.graph.get_node_names() == ()
    assert JOURNAL.lines == ["steady starts", "never ready", "steady ends"]


async def test_a_program_that_is_cancelled_stops_everything_at_once() -> None:
    """However its task group and ours lie in each other."""
    runtime = Runtime(config(gateways={"mqtt": {}}, apps={"steady": app(Steady)}))
    with anyio.fail_after(PATIENCE):
        async with anyio.create_task_group() as tasks:

            async def program() -> None:
                async with runtime:
                    tasks.cancel_scope.cancel()
                    await anyio.sleep_forever()

            tasks.start_soon(program)
    assert runtime.graph.get_node_names() == ()


async def test_an_error_of_the_program_passes_as_it_is() -> None:
    with pytest.raises(KeyError, match="mine"):
        async with Runtime(config(apps={"steady": app(Steady)})):
            raise KeyError("mine")
    assert JOURNAL.lines == ["steady starts", "steady ends"]


async def test_the_log_is_on_rosout_too_while_it_runs() -> None:
    before = structlog.get_config()["processors"]
    async with Runtime(config()) as runtime, Node(runtime.graph, "watcher") as watcher:
        lines = watcher.create_subscription(Log, "/rosout", qos_profile=10)
        structlog.get_logger(node="/somebody").warning("a.b", message="hear me")
        with anyio.fail_after(PATIENCE):
            line = await lines.receive()
        assert (line.name, line.msg, line.level) == ("somebody", "hear me", 30)
    assert structlog.get_config()["processors"] == before


def has_ipv6() -> bool:
    try:
        with socket.create_server(("::1", 0), family=socket.AF_INET6):
            return True
    except OSError:
        return False


@pytest.mark.parametrize(
    ("home", "host", "shown"),
    [
        ("villa", "127.0.0.1", "villa is running; listening for rosbridge clients on ws://127.0.0.1:"),
        ("", "127.0.0.1", "homebot is running; listening"),
        pytest.param(
            "villa",
            "::1",
            "villa is running; listening for rosbridge clients on ws://[::1]:",
            marks=pytest.mark.skipif(not has_ipv6(), reason="this machine has no IPv6"),
        ),
    ],
)
async def test_the_greeting_says_where_tools_come_in(home: str, host: str, shown: str) -> None:
    with capture_logs() as lines:
        async with Runtime(config(home={"name": home} if home else {}, door={"host": host, "port": 0})):
            pass
    (greeting,) = [line["message"] for line in lines if line["event"] == "runtime.running"]
    assert greeting.startswith(shown)
    assert greeting.endswith("; no device is found without a table such as [gateways.mqtt]")


@pytest.mark.parametrize(
    ("apps", "words"),
    [
        ({}, "no app is running; add one with --app NAME or a table [apps.NAME] (installed: follow_me, "),
        ({"light_service": {}}, "running the app light_service"),
        ({"light_service": {}, "two": {"class": "light_service"}}, "running the apps light_service, two"),
        ({"broken": app(Broken), "steady": app(Steady)}, "running the app steady"),
        ({"broken": app(Broken)}, "no app is running yet: broken crashed at the start"),
    ],
)
async def test_the_start_says_which_apps_run(apps: dict[str, object], words: str) -> None:
    with capture_logs() as lines:
        async with Runtime(config(apps=apps)):
            pass
    (told,) = [line["message"] for line in lines if line["event"] == "runtime.apps"]
    assert told.startswith(words)


async def test_a_client_that_floods_does_not_delay_the_stop() -> None:
    """Fifty thousand messages on their way when the end comes, which does not wait for half of them."""
    flood = _Flood()
    async with anyio.create_task_group() as tasks:
        async with Runtime(config(gateways={"mqtt": {"root": "h"}}, apps={"light_service": {}})) as runtime:
            tasks.start_soon(flood.run, broker_url(runtime))
            await flood.is_rising.wait()
        sent = flood.sent
        tasks.cancel_scope.cancel()
    assert sent < flood.DEVICES * flood.MESSAGES / 2


class _Flood:
    """A client in whose name many devices talk at once."""

    DEVICES = 50
    MESSAGES = 1000

    def __init__(self) -> None:
        self.is_rising = anyio.Event()
        self.sent = 0

    async def run(self, url: str) -> None:
        async with MqttConnection(MqttOptions.from_url(url), AiomqttClient, status_topic=None) as field:
            await field.wait_connected()
            async with anyio.create_task_group() as tasks:
                for number in range(self.DEVICES):
                    tasks.start_soon(self._talk, field, f"h/lights/{number}/out")

    async def _talk(self, field: MqttConnection, topic: str) -> None:
        with suppress(LinkError):  # the broker has stopped
            for number in range(self.MESSAGES):
                await field.publish(topic, b"on", qos=number % 2)
                self.sent += 1
                if self.sent == 20 * self.DEVICES:
                    self.is_rising.set()


async def test_two_embedded_brokers_take_two_ports_and_each_says_which() -> None:
    with capture_logs() as lines:
        async with Runtime(config(gateways={"mqtt": {}})) as first, Runtime(config(gateways={"mqtt": {}})) as second:
            assert broker_url(first) != broker_url(second)
    told = [line["url"] for line in lines if line["event"] == "runtime.broker_started"]
    assert told == [broker_url(first), broker_url(second)]


async def listens(url: str) -> bool:
    options = MqttOptions.from_url(url)
    try:
        stream = await anyio.connect_tcp(options.host, options.port)
    except OSError:
        return False
    await stream.aclose()
    return True


@pytest.mark.virtual_time
async def test_a_whole_home_runs_in_memory_and_in_virtual_time() -> None:
    async with MemoryBroker() as broker:
        tables = config(gateways={"mqtt": {"root": "home425"}}, apps={"light_service": {}})
        async with (
            Runtime(
                tables, house=thesis_world(), with_door=False, services=[HostedBroker.in_memory(broker)]
            ) as runtime,
            Node(runtime.graph, "witness") as witness,
        ):
            assert (broker_url(runtime), runtime.rosbridge) == ("mqtt://memory:1883", None)
            log = witness.create_subscription(Log, "/rosout", qos_profile=100)
            with anyio.fail_after(60):
                while not (await log.receive()).msg.startswith("lights/roomlights405 → off, by light_service"):
                    pass
            await anyio.sleep(600)
            assert broker.stats.messages_received >= 3 * 600 / 2


@pytest.mark.virtual_time
async def test_what_the_owner_states_is_there_from_the_first_and_after_a_restart(tmp_path: Path) -> None:
    """By the configuration, before the lamp is known, and by a service, kept in the index file."""
    tables = config(
        home={"name": "villa"},
        gateways={"mqtt": {"root": "home425"}},
        places={
            "rooms": {"Hall": {"floor": "Downstairs"}},
            "devices": {"lights/philips165": {"room": "Hall", "tags": ["night"]}},
        },
    )
    for is_again in (False, True):
        async with (
            MemoryBroker() as broker,
            Runtime(
                tables,
                house=thesis_world(),
                with_door=False,
                services=[HostedBroker.in_memory(broker)],
                index_file=tmp_path / "index.sqlite",
            ) as runtime,
            Node(runtime.graph, "asker") as asker,
        ):
            devices, lamps = Devices(asker), set[str]()
            async for change in devices.follow(Light):
                lamps.add(change.handle.device.id)
                if len(lamps) == 2:
                    break
            stated = await devices.find(Light, area="downstairs", tag="night")
            assert [one.device.id for one in stated] == ["lights/philips165"]
            found = await devices.find(Light, area="villa")
            if is_again:
                assert sorted(one.device.id for one in found) == ["lights/philips165", "lights/roomlights405"]
                break
            assert [one.device.id for one in found] == ["lights/philips165"]
            place = asker.create_client(PlaceDevice, PLACE_DEVICE)
            assert (await place.call(PlaceDevice.Request(device="lights/roomlights405", room="hall"))).room == "Hall"
