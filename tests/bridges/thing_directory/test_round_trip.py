"""Another homebot follows the directory of this one, and uses its devices."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.bridges.thing_directory.conftest import LAMP, OpenHouse, ServedHouse
from tests.patience import PATIENCE

from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.thing_directory import ThingDirectoryGateway, ThingDirectorySettings
from homebot.graph import Graph, Node
from homebot.testing.gateway_contract import running


@asynccontextmanager
async def follower(url: str, **settings: object) -> AsyncIterator[Devices]:
    """Give the devices of a homebot that knows nothing but the directory at *url*."""
    graph = Graph()
    async with (
        Node(graph, "things", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        known = {"url": url, "poll_every": 1.0, **settings}
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        async with running(ThingDirectoryGateway(gateway_node, ThingDirectorySettings.model_validate(known))):
            yield Devices(app)
            tasks.cancel_scope.cancel()


async def light_of(devices: Devices, name: str, *, on: bool) -> Light:
    with anyio.fail_after(PATIENCE):
        async for change in devices.follow(Light, name=name, on=on):
            if change.handle.level is not None:  # each value is read by itself
                return change.handle
    raise AssertionError("the query ended")


@pytest.mark.parametrize("token", [None, "sesame"])
async def test_a_lamp_is_found_read_and_commanded_through_the_directory(
    served_house: OpenHouse, monkeypatch: pytest.MonkeyPatch, token: str | None
) -> None:
    monkeypatch.setenv("DIRECTORY_TOKEN", "sesame")
    login = {"host": "127.0.0.1", "scheme": "bearer", "password_env": "DIRECTORY_TOKEN"}
    async with (
        served_house(token=token) as house,
        follower(house.url, credentials=[login] if token else []) as devices,
    ):
        lamp = await light_of(devices, "Hall lamp", on=True)
        assert (lamp.area, lamp.level) == ("Hall", 40.0)
        assert lamp.device.identifiers[0] == "mac:aabbccddeeff"
        await lamp.turn_off()
        assert [(one.capability, one.value.plain()) for one in house.gateway.commands] == [("on_off", False)]
        await light_of(devices, "Hall lamp", on=False)


async def test_devices_that_come_and_go_do_so_there_as_well(house: ServedHouse) -> None:
    async with follower(house.url) as devices:
        await light_of(devices, "Hall lamp", on=True)
        with anyio.fail_after(PATIENCE):
            async for change in devices.follow():
                if change.device.name == "Attic":
                    house.gateway.devices.put(GatewayDevice("desk", "Desk", LAMP.parts), "new")
                if change.device.name == "Desk" and change.kind == "appeared":
                    house.gateway.devices.remove("desk", "gone")
                if change.device.name == "Desk" and change.kind == "removed":
                    break
