"""The suite of a gateway's life: start, loss of the link, restart and stop."""

from __future__ import annotations

import anyio
from structlog.testing import capture_logs

from homebot.devices import GatewayState, Sighting
from homebot.gateways.base import UNAVAILABLE
from homebot.graph import Graph, Node
from homebot.testing.gateway_contract.steps import PATIENCE, announced, first, kept, listen, send
from homebot.testing.gateway_contract.world import GatewayWorld

__all__ = ["LinkSuite"]


class LinkSuite(GatewayWorld):
    """The gateway starts, loses its link, has it again, and stops."""

    async def test_it_is_ready_and_active_once_it_has_started(self) -> None:
        async with self.house() as (lamp, watcher):
            state = await first(listen(watcher, GatewayState, lamp.gateway.names.state))
            assert (state.state, state.reason, state.acts) == ("active", "", True)

    async def test_without_its_link_it_is_unavailable_keeps_its_devices_and_comes_back(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            states = listen(watcher, GatewayState, lamp.gateway.names.state)
            await first(states)
            await lamp.lose_link()
            lost = await first(states)
            assert lost.state == "unavailable"
            assert lost.reason
            if self.takes_commands:
                response = await send(lamp, watcher)
                assert (response.success, response.problem) == (False, "unreachable")
            assert [one.key for one in kept(listen(watcher, Sighting, lamp.gateway.names.received_topics))] == [
                lamp.key
            ]
            await lamp.mend_link()
            with anyio.fail_after(PATIENCE):
                while (await states.receive()).state != "active":
                    pass
            assert (await send(lamp, watcher)).success is self.takes_commands

    async def test_before_it_has_its_link_it_is_ready_and_unavailable_and_logs_it(self) -> None:
        graph = Graph()
        async with self.lamp() as lamp, Node(graph, "watcher") as watcher:
            await lamp.lose_link()
            with capture_logs() as lines:
                async with self.started(lamp, graph, {}):
                    states = listen(watcher, GatewayState, lamp.gateway.names.state)
                    state = await first(states)
                    assert state.state == "unavailable"
                    assert state.reason
                    (line,) = (line for line in lines if line["event"] == UNAVAILABLE)
                    assert state.reason in line["message"]
                    await lamp.mend_link()
                    with anyio.fail_after(PATIENCE):
                        while (await states.receive()).state != "active":
                            pass
                    await announced(lamp, watcher)

    async def test_after_a_restart_it_finds_its_devices_again_by_the_same_keys(self) -> None:
        # Its topics were empty; no other peer announces them
        graph = Graph()
        async with self.lamp() as lamp, Node(graph, "watcher") as watcher:
            async with self.started(lamp, graph, {}):
                before = await announced(lamp, watcher)
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            assert kept(sightings) == []
            async with self.started(lamp, graph, {}):
                await lamp.meet_again()
                again = await first(sightings)
                assert (again.key, again.name, again.parts) == (before.key, before.name, before.parts)
                assert (await send(lamp, watcher)).success is self.takes_commands

    async def test_it_stops_when_it_is_cancelled_and_leaves_nothing_on_the_graph(self) -> None:
        # Another one can be started on the same graph at once
        async with self.house() as (lamp, _):
            graph, name = lamp.gateway.node.graph, lamp.gateway.node.full_name
            lamp.gateway.node.close()
            assert not [one.name for one in graph.get_endpoints() if one.node == name]
