"""A Matter server that goes away while it is told something."""

from __future__ import annotations

import json

import anyio
from anyio.abc import TaskStatus
from tests.gateways.matter.test_gateway import House
from tests.gateways.watched_gateway import reading
from tests.patience import PATIENCE

from homebot.devices import GatewayState
from homebot.gateways.matter import MatterGateway, MatterGatewaySettings
from homebot.graph import Graph, Node
from homebot.house.dialect import DeviceState
from homebot.house.http.web_server import WebPeer
from homebot.house.matter import SimulatedMatterServer
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import KEPT


class LeavingServer(SimulatedMatterServer):
    """A server that loses its power with the first command for a device."""

    def __init__(self) -> None:
        super().__init__()
        self._power = anyio.CancelScope()

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        with self._power:
            await super().serve(task_status=task_status)

    def receive(self, peer: WebPeer, message: bytes) -> None:
        if json.loads(message).get("command") == "device_command":
            self._power.cancel()
            return
        super().receive(peer, message)


async def test_a_server_that_leaves_while_it_is_told_did_not_answer_and_its_devices_stay() -> None:
    graph, server = Graph(), LeavingServer()
    async with (
        anyio.create_task_group() as tasks,
        Node(graph, "matter", namespace="/gateway") as node,
        Node(graph, "watcher") as watcher,
    ):
        await tasks.start(server.serve)
        gateway = MatterGateway(node, MatterGatewaySettings(url=server.url))
        async with running(gateway):
            home = House(gateway, server, watcher, tasks)
            reports = home.reports()
            states = watcher.create_subscription(GatewayState, gateway.names.state, qos_profile=KEPT)
            await home.commission("lamp", DeviceState(text="off"))
            await reading(reports, "on_off", lambda one: one is False)
            with anyio.fail_after(PATIENCE):
                response = await home.send("node-1", "on_off", True)
                while (await states.receive()).state != "unavailable":
                    pass
            assert (response.success, response.problem) == (False, "unanswered")
            assert gateway.devices.keys == ("node-1",)
        tasks.cancel_scope.cancel()
