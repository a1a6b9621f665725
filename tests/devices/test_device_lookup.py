"""Look-up of devices, also by the addresses of raw commands, in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home

from homebot.devices import FIND_DEVICES, FindDevices
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.handles import Light
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.graph import Graph, Node

pytestmark = pytest.mark.virtual_time


async def test_a_device_is_found_by_what_its_parts_take(home: Home) -> None:
    part = simple_part("light", settable=("on_off",)).model_copy(update={"writes": ("kettle/set",)})
    home.gateway.devices.put(GatewayDevice("kettle", "Kettle", (part,)), "the test says so")
    kettle = (await home.handle(Light)).device
    addresses = DeviceLookup(home.app)
    assert await addresses.device_at("memory", "kettle/set") == kettle.id
    assert await addresses.device_at("mqtt", "kettle/set") == ""


async def test_an_address_that_another_device_has_now_is_that_of_this_one(home: Home) -> None:
    """Raw commands were recorded for a device that was gone, and their effect was a person's."""
    part = simple_part("light", settable=("on_off",)).model_copy(update={"writes": ("kettle/set",)})
    addresses = DeviceLookup(home.app)
    home.gateway.devices.put(GatewayDevice("kettle", "Kettle", (part,)), "the test says so")
    kettle = (await home.handle(Light)).device
    assert await addresses.device_at("memory", "kettle/set") == kettle.id
    home.gateway.devices.remove("kettle", "the test says so")
    home.gateway.devices.put(GatewayDevice("pot", "Pot", (part,)), "the test says so")
    pot = (await home.handle(Light, "pot")).device
    await anyio.sleep(1)
    assert await addresses.device_at("memory", "kettle/set") == pot.id


async def test_a_device_that_appears_later_is_found_a_second_later(home: Home) -> None:
    addresses = DeviceLookup(home.app)
    await addresses.device_at("memory", "nowhere")
    lamp = (await home.lamp("on_off")).device
    await anyio.sleep(1)
    assert await addresses.device_at("memory", lamp.endpoints[0].command_address) == lamp.id


async def test_a_flood_of_unknown_addresses_reads_the_devices_once_a_second() -> None:
    requests: list[FindDevicesRequest] = []

    def find(request: FindDevicesRequest) -> FindDevicesResponse:
        requests.append(request)
        return FindDevicesResponse(devices=(), sequence=0)

    graph = Graph()
    async with Node(graph, "directory") as directory, Node(graph, "control") as control:
        directory.create_service(FindDevices, FIND_DEVICES, find)
        addresses = DeviceLookup(control)
        for number in range(1000):  # within ten seconds
            assert await addresses.device_at("memory", f"nowhere/{number}") == ""
            await anyio.sleep(0.01)
    assert 1 < len(requests) <= 11


async def test_no_device_is_known_without_an_answer_of_the_directory(home: Home) -> None:
    lamp = (await home.lamp("on_off")).device
    lookup = DeviceLookup(home.app)
    assert (await lookup.known(lamp.id), await lookup.known("gone")) == (lamp, None)
    assert await lookup.all_known() == (lamp,)
    async with Node(Graph(), "control") as control:
        lookup = DeviceLookup(control)
        assert (await lookup.known(lamp.id), await lookup.all_known(), await lookup.members(lamp, lamp.parts[0])) == (
            None,
            (),
            [],
        )
