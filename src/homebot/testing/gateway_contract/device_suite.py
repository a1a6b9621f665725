"""The suite of a gateway's life and of its devices: start, sightings, reports, loss of the link, restart and end."""

import anyio
import pytest
from structlog.testing import capture_logs

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import Report
from homebot.gateways.base import UNAVAILABLE
from homebot.graph import Graph, Node
from homebot.testing.gateway_contract.steps import (
    active,
    announced,
    changed,
    directory,
    first,
    kept,
    listen,
    reported,
    send,
    until,
    value,
)
from homebot.testing.gateway_contract.world import GatewayWorld


class DeviceSuite(GatewayWorld):
    """Devices come, report and go; the gateway starts, loses its link, has it again, and stops."""

    async def test_a_device_is_sighted_with_its_parts_and_when_it_counts_as_silent(self) -> None:
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            await lamp.announce()
            sighting = await first(sightings)
            assert (sighting.gateway, sighting.key, sighting.name) == (lamp.gateway.node.name, lamp.key, "Hall")
            assert sighting.kind in {"appeared", "updated"}
            assert sighting.expires_at.to_seconds() > sighting.seen_at.to_seconds()
            assert sighting.why
            (part,) = sighting.parts
            assert (part.id, part.service_type) == (lamp.part, lamp.service_type)
            (on_off,) = (capability for capability in part.capabilities if capability.name == lamp.capability)
            assert on_off.readable
            assert on_off.settable is self.takes_commands

    async def test_a_report_has_the_values_of_the_vocabulary(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            report = await reported(lamp, reports, on=True)
            assert (report.gateway, report.key, report.retained) == (lamp.gateway.node.name, lamp.key, False)
            assert report.stream
            assert {reading.part for reading in report.readings} == {lamp.part}

    async def test_a_late_joiner_gets_the_newest_sighting_and_report_of_each_device(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            await reported(lamp, reports, on=True)
            assert (await first(listen(watcher, Sighting, lamp.gateway.names.received_topics))).key == lamp.key
            late = listen(watcher, Report, lamp.gateway.names.readings)
            assert [value(lamp, report) for report in kept(late) if value(lamp, report) is not None] == [True]

    async def test_a_device_that_reports_again_is_sighted_with_a_later_expiry(self) -> None:
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            before = await announced(lamp, watcher)
            await anyio.sleep(1.1)
            await lamp.report(on=True)
            later = "after Lamp.report() a sighting with a later expiry"
            sighting = await until(sightings, later, lambda change: change.expires_at != before.expires_at)
            assert sighting.expires_at.to_seconds() >= before.expires_at.to_seconds() + 1
            assert sighting.confirmed

    async def test_a_device_that_is_gone_is_removed_and_late_joiners_hear_nothing_of_it(self) -> None:
        if not self.tells_goodbye:
            pytest.skip("its protocol does not say that a device was taken away")
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            await announced(lamp, watcher)
            await lamp.report(on=True)
            await lamp.withdraw()
            removed = "after Lamp.withdraw() a sighting of the kind `removed`, by PublishedDevices.remove,"
            sighting = await until(sightings, removed, lambda change: change.kind == "removed", lamp.gone_within)
            assert sighting.key == lamp.key
            assert kept(listen(watcher, Sighting, lamp.gateway.names.received_topics)) == []
            assert kept(listen(watcher, Report, lamp.gateway.names.readings)) == []

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
            assert [change.key for change in kept(listen(watcher, Sighting, lamp.gateway.names.received_topics))] == [
                lamp.key
            ]
            await lamp.mend_link()
            await active(states)
            assert (await send(lamp, watcher)).success is self.takes_commands

    async def test_without_its_link_its_devices_are_unreachable_until_it_comes_back(self) -> None:
        async with self.house() as (lamp, watcher), directory(watcher) as changes:
            await announced(lamp, watcher)
            await changed(changes, lamp, is_lost=False)
            await lamp.lose_link()
            lost = await changed(changes, lamp, is_lost=True)
            assert {endpoint.reachable for endpoint in lost.endpoints} == {"no"}
            assert lost.reachable.why
            await lamp.mend_link()
            await changed(changes, lamp, is_lost=False)

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
                    await active(states)
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
            assert not [endpoint.name for endpoint in graph.get_endpoints() if endpoint.node == name]
