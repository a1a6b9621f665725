"""Where a device that can hurt waits for approval: wherever a real one may be found."""

import pytest

from homebot.config import parse_config
from homebot.devices import FIND_DEVICES, Devices, FindDevices
from homebot.devices.approval_messages import GetUnapproved
from homebot.devices.handles import Light
from homebot.devices.names import GET_UNAPPROVED
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import IsUnapproved
from homebot.devices.services import FindDevicesRequest
from homebot.graph import Node
from homebot.house import thesis_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime

LAMP = "lights/philips165"
REAL = {"class": "homebot.gateways.memory:MemoryGateway"}


@pytest.mark.virtual_time
@pytest.mark.parametrize(
    ("has_real_gateway", "trusts_apps", "waits"), [(False, False, False), (True, False, True), (True, True, False)]
)
async def test_no_device_waits_in_a_simulated_house_without_real_gateways_nor_in_tests(
    *, has_real_gateway: bool, trusts_apps: bool, waits: bool
) -> None:
    tables = {
        "gateways": {"mqtt": {"root": "home425"}} | ({"real": REAL} if has_real_gateway else {}),
        "places": {"devices": {LAMP: {"tags": ["always_ask"]}}},
    }
    config = parse_config(tables, "homebot.toml")
    async with (
        MemoryBroker() as broker,
        Runtime(
            config,
            house=thesis_world(),
            with_door=False,
            services=[HostedBroker.in_memory(broker)],
            trusts_apps=trusts_apps,
        ) as runtime,
        Node(runtime.graph, "asker") as asker,
    ):
        async for change in Devices(asker).follow(Light):
            if change.handle.device.id == LAMP:
                break
        ask = asker.create_client(GetUnapproved, GET_UNAPPROVED)
        assert (await ask.call(GetUnapproved.Request(device=LAMP))).devices == ((LAMP,) if waits else ())
        assert (LAMP in await unapproved(asker)) is waits


@pytest.mark.virtual_time
@pytest.mark.parametrize("approvals", [True, False])
async def test_a_query_finds_no_device_that_waits_where_none_has_to(*, approvals: bool) -> None:
    tables = {
        "gateways": {"mqtt": {"root": "home425"}, "real": REAL},
        "places": {"devices": {LAMP: {"tags": ["always_ask"]}}},
        "control": {"approvals": approvals},
    }
    async with (
        MemoryBroker() as broker,
        Runtime(
            parse_config(tables, "homebot.toml"),
            house=thesis_world(),
            with_door=False,
            services=[HostedBroker.in_memory(broker)],
        ) as runtime,
        Node(runtime.graph, "asker") as asker,
    ):
        async for change in Devices(asker).follow(Light):
            if change.handle.device.id == LAMP:
                break
        assert (LAMP in await unapproved(asker)) is approvals


async def unapproved(asker: Node) -> list[str]:
    """The devices that `homebot find unapproved` lists."""
    find = asker.create_client(FindDevices, FIND_DEVICES)
    found = await find.call(FindDevicesRequest(query=query_terms(IsUnapproved())))
    return [one.id for one in found.devices]
