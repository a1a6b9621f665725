"""Locks, garage doors and coverings behind HomeKit wait for approval, and obey rights, quiet hours and leases."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import ClassVar

import anyio
import pytest
from tests.gateways.homekit.fake_accessories import (
    CODE,
    FakeMdns,
    FakePort,
    FakeServer,
    accessory,
    characteristic,
    service,
)

from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.approval_messages import ApproveDevice, ApproveDeviceRequest, GetUnapproved
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.handles import Handle
from homebot.devices.names import APPROVE_DEVICE, GET_UNAPPROVED, PERFORM_COMMAND, PairingNames
from homebot.devices.outcomes import Refused
from homebot.devices.pairing_messages import Pair, PairRequest
from homebot.gateways import GatewayContext
from homebot.gateways.homekit import HomekitGateway, HomekitGatewaySettings
from homebot.gateways.homekit.port import HomekitPort
from homebot.graph import Node
from homebot.runtime import Runtime

pytestmark = pytest.mark.virtual_time

PATIENCE = 600.0
READ = ["pr", "ev"]
LOCK, GARAGE, BLIND = "Front door", "Garage", "Blind"


def bridge() -> FakeServer:
    """A bridge with a lock, a garage door and a covering, each closed."""
    lock = service(20, "45", characteristic(21, "1D", 1, READ), characteristic(22, "1E", 1))
    garage = service(30, "41", characteristic(31, "E", 1, READ), characteristic(32, "32", 1))
    state = (characteristic(41, "6D", 0, READ), characteristic(42, "72", 2, READ))
    blind = service(40, "8C", *state, characteristic(43, "7C", 0, minValue=0, maxValue=100))
    things = (accessory(2, LOCK, lock), accessory(3, GARAGE, garage), accessory(4, BLIND, blind))
    server = FakeServer("AA:BB:CC:DD:EE:01", "Bridge", accessory(1, "Bridge"), *things)
    server.follows = {(2, 22): (2, 21), (3, 32): (3, 31), (4, 43): (4, 41)}
    return server


class HomekitInMemory(HomekitGateway):
    """The gateway, with accessories in memory."""

    server: ClassVar[FakeServer]

    def __init__(self, node: Node, settings: HomekitGatewaySettings, context: GatewayContext | None = None) -> None:
        port: dict[type[object], object] = {HomekitPort: FakePort(self.server)}
        super().__init__(node, settings, replace(context or GatewayContext(), services=port))


@asynccontextmanager
async def homebot(
    *, trusts_apps: bool = False, **control: object
) -> AsyncIterator[tuple[FakeServer, Node, Mapping[str, Handle]]]:
    """Run homebot until the block ends: the bridge, a node, and the handles of its devices by their names."""
    server = HomekitInMemory.server = bridge()
    gateway = {"class": f"{__name__}:HomekitInMemory"}
    tables = {"gateways": {"homekit": gateway}, "discovery": {"persist": False}, "control": control}
    async with (
        Runtime(parse_config(tables, "test"), with_door=False, trusts_apps=trusts_apps) as runtime,
        Node(runtime.graph, "watcher") as node,
    ):
        FakeMdns(runtime.graph).announce(server)
        await anyio.wait_all_tasks_blocked()
        pair = node.create_client(Pair, PairingNames("homekit").pair)
        await pair.call(PairRequest(device=server.key, code=CODE), timeout=PATIENCE)
        found: dict[str, Handle] = {}
        async for change in Devices(node).follow(Handle):
            found[change.handle.device.name] = change.handle
            if found.keys() >= {LOCK, GARAGE, BLIND}:
                break
        yield server, node, found


async def refusal(node: Node, device: Handle, opened: tuple[str, str], *scope: str) -> str:
    """Command *device* as a client with the rights of *scope*; return the policy that refuses, empty for none."""
    settings = (Setting.of(*opened),)
    request = CommandRequest(device=device.device.id, settings=settings, issuer="client:phone", scope=scope)
    outcome = await node.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=PATIENCE)
    return outcome.policy if isinstance(outcome, Refused) else ""


OPENED = {LOCK: ("lock", "unlocked"), GARAGE: ("movement", "open"), BLIND: ("movement", "open")}
HALVES = ("00:00", "12:00")
WRITTEN = {LOCK: ((2, 22), 0), GARAGE: ((3, 32), 0), BLIND: ((4, 43), 100)}


async def test_locks_and_garage_doors_wait_for_approval() -> None:
    async with homebot() as (server, node, found):
        waiting = await node.create_client(GetUnapproved, GET_UNAPPROVED).call(
            GetUnapproved.Request(), timeout=PATIENCE
        )
        assert {*waiting.devices} == {found[LOCK].device.id, found[GARAGE].device.id}
        approve = node.create_client(ApproveDevice, APPROVE_DEVICE)
        for name in (LOCK, GARAGE):
            assert await refusal(node, found[name], OPENED[name], "act: all") == "approval"
            assert server.written == []
            await approve.call(ApproveDeviceRequest(device=found[name].device.id), timeout=PATIENCE)
            assert await refusal(node, found[name], OPENED[name], "act: all") == ""
            assert server.written == [WRITTEN[name]]
            server.written.clear()


@pytest.mark.parametrize("name", [LOCK, GARAGE, BLIND])
async def test_a_client_without_the_right_is_refused(name: str) -> None:
    async with homebot(approvals=False) as (server, node, found):
        assert await refusal(node, found[name], OPENED[name], "act: light") == "rights"
        assert server.written == []
        assert await refusal(node, found[name], OPENED[name], "act: all") == ""
        assert server.written == [WRITTEN[name]]


@pytest.mark.parametrize("name", [LOCK, GARAGE, BLIND])
async def test_quiet_hours_hold(name: str) -> None:
    commands = ["unlock door lock", "open closure", "open window covering"]
    hours = [{"start": one, "end": other, "commands": commands} for one, other in (HALVES, HALVES[::-1])]
    async with homebot(trusts_apps=True, quiet_hours=hours) as (server, _, found):
        outcome = await found[name].command(*OPENED[name])
        assert isinstance(outcome, Refused)
        assert outcome.policy == "quiet_hours"
        assert server.written == []


@pytest.mark.parametrize("name", [LOCK, GARAGE, BLIND])
async def test_a_lease_holds(name: str) -> None:
    async with homebot(trusts_apps=True) as (server, node, found):
        async with found[name].hold("locked" if name == LOCK else "closed", by="guard"):
            assert await refusal(node, found[name], OPENED[name], "act: all") == "lease"
            assert WRITTEN[name] not in server.written
        assert await refusal(node, found[name], OPENED[name], "act: all") == ""
        assert WRITTEN[name] in server.written
