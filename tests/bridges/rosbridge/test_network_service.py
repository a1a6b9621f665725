"""The door says where it listens, for gateways that announce it to the network."""

from __future__ import annotations

import anyio
from pydantic import SecretStr

from homebot.bridges.rosbridge import Door, DoorSettings
from homebot.devices.network_service import NetworkService
from homebot.graph import Graph, Node


async def test_the_door_says_where_it_listens_and_that_it_no_longer_does() -> None:
    said: list[NetworkService] = []
    node = Node(Graph(), "rosbridge_websocket")
    door = Door(node, DoorSettings(host="0.0.0.0", port=0, token=SecretStr("secret")), said.append)  # noqa: S104
    async with anyio.create_task_group() as tasks:
        await tasks.start(door.run)
        (service,) = said
        assert (service.service_type, service.addresses, service.port) == ("_rosbridge._tcp", ("0.0.0.0",), door.port)  # noqa: S104
        assert "secret" not in repr(service)
        tasks.cancel_scope.cancel()
    assert said[1:] == [NetworkService(service_type="_rosbridge._tcp", is_withdrawn=True)]
