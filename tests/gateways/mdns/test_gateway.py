"""The mDNS gateway runs drivers, lists what it finds with its facts, and does not mind what breaks."""

import socket
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager

import anyio
import pytest
from tests.gateways.mdns.lamp import DRIVER, HOST, LOOPBACK, SERVICE_TYPE, LampServer, Publisher, publisher
from tests.gateways.mdns.packets import AAAA, address, answer, pointer, record, service, text
from tests.patience import PATIENCE
from tests.sizes import size

from homebot.conventions.dns_sd import FoundService
from homebot.conventions.ecosystem import Ecosystem
from homebot.devices import Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.value import Value
from homebot.errors import UsageError
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.gateways.mdns.gateway import MAX_ASLEEP
from homebot.gateways.mdns.services import CHANGE_EVERY, CHANGES_AT_ONCE
from homebot.gateways.mdns.zeroconf_network import MAX_ADDRESSES
from homebot.graph import Graph, Node, Subscription

KEY = f"Hall.{SERVICE_TYPE}"


class House:
    """A gateway, what it says, and a computer that announces services."""

    def __init__(self, gateway: MdnsGateway, watcher: Node, computer: Publisher) -> None:
        self.gateway = gateway
        self.computer = computer
        self.sightings: Subscription[Sighting] = watcher.create_subscription(
            Sighting, gateway.names.received_topics, qos_profile=1000
        )
        self._reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=1000)
        self._health = watcher.create_client(GetHealth, gateway.names.health)
        self._commands = watcher.create_client(SendCommand, gateway.names.send_command)

    async def seen(self, *, kind: str = "", port: str = "") -> Sighting:
        """Wait for a sighting of a kind, or one that names a port."""
        with anyio.fail_after(PATIENCE):
            while True:
                sighting = await self.sightings.receive()
                if (kind or sighting.kind) == sighting.kind and (port or facts(sighting)["port"]) == facts(sighting)[
                    "port"
                ]:
                    return sighting

    async def reported(self, capability: str, value: object) -> Report:
        """Wait for a report."""
        with anyio.fail_after(PATIENCE):
            while True:
                report = await self._reports.receive()
                if any(one.capability == capability and one.value.plain() == value for one in report.readings):
                    return report

    async def counted(self) -> dict[str, int]:
        """Return the counters of the health service."""
        return {one.name: one.count for one in (await self._health.call(HealthRequest())).counts}

    async def troubles(self) -> tuple[str, ...]:
        """Return what the health service says is wrong."""
        return (await self._health.call(HealthRequest())).troubles

    async def turn_on(self) -> SendCommandResponse:
        """Tell the lamp to be on."""
        return await self._commands.call(Command(key=KEY, part="", capability="on_off", value=Value.of(True)))


@contextmanager
def stranger() -> Iterator[Callable[..., None]]:
    """Give what sends records to all who listen on loopback, in one message."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(LOOPBACK))

        def send(*records: bytes) -> None:
            opened.sendto(answer(*records), ("224.0.0.251", 5353))

        yield send


def facts(sighting: Sighting) -> dict[str, str]:
    return {one.key: one.value for one in sighting.metadata}


@asynccontextmanager
async def house(**settings: object) -> AsyncIterator[House]:
    graph = Graph()
    table = {"interfaces": [LOOPBACK], "service_types": [SERVICE_TYPE], "announce": False, "drivers": {DRIVER: {}}}
    async with (
        publisher() as computer,
        Node(graph, "watcher") as watcher,
        Node(graph, "mdns", namespace="/gateway") as node,
    ):
        gateway = MdnsGateway(node, MdnsGatewaySettings.model_validate({**table, **settings}))
        found = House(gateway, watcher, computer)
        async with anyio.create_task_group() as tasks:
            await tasks.start(gateway.serve)
            yield found
            tasks.cancel_scope.cancel()


async def test_a_device_has_the_facts_of_its_driver_and_those_of_its_service() -> None:
    lamp = LampServer()
    async with lamp.listening(), house() as home:
        await home.computer.announce("Hall", lamp.port, {"mac": "A8032ABE54DC", "ver": "2.1", "model": "unknown"})
        sighting = await home.seen()
        assert sighting.service_type == "light"
        found = facts(sighting)
        assert (found["model"], found["sw_version"], found["txt_mac"]) == ("Lamp 1", "2.1", "A8032ABE54DC")
        assert (found["host"], found["port"], found["ip_address"]) == (HOST.removesuffix("."), str(lamp.port), LOOPBACK)
        assert "mac:a8032abe54dc" in sighting.identifiers
        assert sighting.expires_at.to_seconds() - sighting.seen_at.to_seconds() == pytest.approx(135, abs=1)


async def test_a_device_that_cannot_be_connected_to_is_listed_without_parts_and_refuses_commands() -> None:
    lamp = LampServer()
    async with lamp.listening():
        port = lamp.port
    async with house() as home:
        await home.computer.announce("Hall", port)
        sighting = await home.seen()
        assert (sighting.parts, sighting.service_type) == ((), SERVICE_TYPE.removesuffix(".local."))
        await home.reported("reachable", False)


@pytest.mark.parametrize("change", ["port", "txt"])
async def test_a_device_that_moved_or_says_something_else_is_connected_to_anew(change: str) -> None:
    lamp, other = LampServer(), LampServer()
    async with lamp.listening(), other.listening(), house() as home:
        await home.computer.announce("Hall", lamp.port, {"v": "1"})
        await home.reported("on_off", False)
        moved = other if change == "port" else lamp
        await home.computer.announce("Hall", moved.port, {"v": "1" if change == "port" else "2"})
        await home.reported("reachable", False)
        await home.reported("reachable", True)
        assert (lamp.connections, other.connections) == ((1, 1) if change == "port" else (2, 0))


async def test_a_service_without_a_driver_is_listed_with_its_facts() -> None:
    async with house(drivers={}) as home:
        await home.computer.announce("Hall", 80, {"serial": "GW-2026-0042"})
        sighting = await home.seen()
        assert (sighting.key, sighting.name, sighting.parts) == (KEY, "Hall", ())
        assert "id:GW-2026-0042" in sighting.identifiers


class Ours(Ecosystem):
    """Services of which some are homebot's."""

    @classmethod
    def is_own(cls, service: FoundService) -> bool:
        return service.properties.get("md") == "homebot"


async def test_what_an_ecosystem_knows_for_homebot_itself_is_not_listed() -> None:
    async with house(drivers={}) as home:
        home.gateway._ecosystems[SERVICE_TYPE] = Ours
        await home.computer.announce("Bridge", 81, {"md": "homebot"})
        await home.computer.announce("Hall", 80, {"md": "lamp"})
        assert (await home.seen()).key == KEY


async def test_a_txt_record_that_breaks_the_rules_is_counted_and_read_as_far_as_it_goes() -> None:
    async with house(drivers={}) as home:
        with stranger() as send:
            send(
                pointer(SERVICE_TYPE, KEY),
                service(KEY, HOST, 80),
                text(KEY, b"\x07model=x\x04=abc\x03a\xff=\x05bin=\xfe\xffcut"),
                address(HOST, LOOPBACK),
            )
        found = facts(await home.seen())
        assert (found["model"], found["txt_bin"]) == ("x", "\\xfe")
        assert home.gateway.devices.counters.rejected == 1


async def test_a_service_with_foreign_addresses_is_not_listed() -> None:
    async with house(drivers={}) as home:
        evil = f"Evil.{SERVICE_TYPE}"
        with stranger() as send:
            send(
                pointer(SERVICE_TYPE, evil),
                service(evil, "evil.local.", 80),
                text(evil, b"\0"),
                address("evil.local.", "224.0.0.1"),
            )
        await home.computer.announce("Hall", 80)
        assert (await home.seen()).key == KEY
        assert home.gateway.devices.keys == (KEY,)


async def test_the_health_service_counts_the_dropped_addresses_of_a_host() -> None:
    async with house(drivers={}) as home:
        many = (
            record(HOST, AAAA, socket.inet_pton(socket.AF_INET6, f"2001:db8::{one:x}"), unique=False)
            for one in range(1, MAX_ADDRESSES + 10)
        )
        with stranger() as send:
            send(pointer(SERVICE_TYPE, KEY), service(KEY, HOST, 80), text(KEY, b"\0"), *many)
        await home.seen()
        assert (await home.counted())["addresses_refused"] == 9


async def test_a_device_that_does_not_answer_by_multicast_is_kept_only_while_it_is_connected() -> None:
    lamp = LampServer()
    async with house() as home:
        async with lamp.listening():
            await home.computer.announce("Hall", lamp.port)
            await home.reported("reachable", True)
            assert home.gateway.confirm_connected(KEY)
        await lamp.hang_up()
        await home.reported("reachable", False)
        assert not home.gateway.confirm_connected(KEY)
        assert not home.gateway.confirm_connected(f"Attic.{SERVICE_TYPE}")


async def test_a_device_that_sleeps_stays_listed_and_is_connected_to_when_it_is_back() -> None:
    lamp = LampServer()
    async with house(sleeping={"Hall": 3600.0}) as home:
        async with lamp.listening():
            await home.computer.announce("Hall", lamp.port)
            await home.reported("reachable", True)
            awake = await home.seen()
            assert facts(awake)["sleep"] == "awake"
            assert awake.expires_at.to_seconds() - awake.seen_at.to_seconds() == pytest.approx(3600, abs=1)
        await home.computer.withdraw("Hall")
        await home.reported("reachable", None)
        while facts(asleep := await home.seen())["sleep"] != "asleep":
            pass
        assert (asleep.kind, asleep.confirmed, home.gateway.devices.keys) == ("updated", False, (KEY,))
        refused = await home.turn_on()
        assert (refused.success, refused.message) == (False, f"{KEY} is asleep; try again once it is awake")
        async with lamp.listening():
            await home.computer.announce("Hall", lamp.port)
            await home.reported("reachable", True)
            assert lamp.connections == 2
            assert (await home.turn_on()).success


async def test_a_command_to_a_device_that_fell_asleep_before_it_was_connected_to_says_so() -> None:
    async with house(sleeping={"Hall": 3600.0}) as home:
        await home.computer.announce("Hall", 9)  # nothing listens there
        await anyio.sleep(0.5)
        await home.computer.withdraw("Hall")
        while facts(await home.seen())["sleep"] != "asleep":
            pass
        refused = await home.turn_on()
        assert not refused.success
        assert "may be asleep: wake it, and try again" in refused.message


async def test_a_device_that_sleeps_for_too_long_is_removed() -> None:
    async with house(drivers={}, sleeping={"Hall": 3600.0}, forget_sleeping_after=0.5) as home:
        await home.computer.announce("Hall", 80)
        await home.seen()
        await home.computer.withdraw("Hall")
        gone = await home.seen(kind="removed")
        assert gone.why == "it did not come back from sleep within 0.5 s"


async def test_a_device_that_sleeps_with_too_many_others_is_removed() -> None:
    names = [f"Hall {number}" for number in range(MAX_ASLEEP + 1)]
    async with house(drivers={}, sleeping=dict.fromkeys(names, 3600.0)) as home:
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(home.computer.announce, name, 80)
        seen: set[str] = set()
        while len(seen) < len(names):  # some are told more than once
            seen.add((await home.seen()).key)
        async with anyio.create_task_group() as tasks:
            for name in names:
                tasks.start_soon(home.computer.withdraw, name)
        gone = await home.seen(kind="removed")
        assert gone.why == "more than 100 devices are asleep"


async def test_records_that_change_all_the_time_cause_few_connections() -> None:
    """And the changes that have to wait are counted."""
    lamp = LampServer()
    async with lamp.listening(), house() as home:
        begun = anyio.current_time()
        for number in range(20):
            await home.computer.announce("Hall", lamp.port, {"v": str(number)})
        await home.reported("reachable", True)
        assert home.gateway.devices.counters.rejected >= 1
        assert lamp.connections <= CHANGES_AT_ONCE + (anyio.current_time() - begun) / CHANGE_EVERY + 1


async def test_a_flood_of_services_is_bounded_and_the_lamp_is_not_affected() -> None:
    lamp = LampServer()
    async with lamp.listening(), house(max_services=200) as home:
        await home.computer.announce("Hall", lamp.port)
        await home.reported("on_off", False)
        with stranger() as send:
            for number in range(size(2_000, 10_000)):
                fake, host = f"fake {number}.{SERVICE_TYPE}", f"fake{number}.local."
                send(pointer(SERVICE_TYPE, fake), service(fake, host, 9), text(fake, b"\0"), address(host, LOOPBACK))
                if number % 20 == 0:
                    await anyio.sleep(0.001)
        assert len(home.gateway.devices.keys) <= 200
        await lamp.switch(on=True)
        await home.reported("on_off", True)
        assert (await home.turn_on()).success
        assert KEY in home.gateway.devices.keys


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"drivers": {"nobody": {}}}, "drivers.nobody"),
        ({"drivers": {DRIVER: {"colour": 1}}}, "colour"),
        ({"drivers": {"homebot.gateways.memory:MemoryGateway": {}}}, "is not a Driver"),
    ],
    ids=["unknown", "wrong key", "no driver"],
)
def test_a_table_of_a_driver_that_cannot_be_used_is_an_error_before_anything_starts(
    table: dict[str, object], problem: str
) -> None:
    with pytest.raises(UsageError, match=problem):
        MdnsGateway.check(MdnsGatewaySettings.model_validate(table))


@pytest.mark.parametrize("wrong", ["shelly", "_a_b._tcp", "_http._sctp", "_toolongforaservice._tcp", ""])
def test_an_invalid_service_type_is_refused(wrong: str) -> None:
    with pytest.raises(ValueError, match="is not a service type"):
        MdnsGatewaySettings(service_types=(wrong,))


def test_without_service_types_those_of_drivers_and_all_on_the_network_are_looked_for() -> None:
    types = MdnsGatewaySettings().types_with(frozenset({"_lamp._tcp.local."}))
    assert {"_lamp._tcp.local.", "_airplay._tcp.local.", "_services._dns-sd._udp.local."} <= types
    assert MdnsGatewaySettings(service_types=("_HTTP._tcp",)).types_with(frozenset({"_lamp._tcp.local."})) == {
        "_http._tcp.local."
    }
