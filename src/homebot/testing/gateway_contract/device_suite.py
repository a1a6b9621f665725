"""The suite of devices: sightings, reports, and their end."""

from __future__ import annotations

import anyio
import pytest

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report
from homebot.testing.gateway_contract.steps import PATIENCE, announced, first, kept, listen, reported, value
from homebot.testing.gateway_contract.world import GatewayWorld

__all__ = ["DeviceSuite"]


class DeviceSuite(GatewayWorld):
    """Devices come, report and go."""

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
            (on_off,) = (one for one in part.capabilities if one.name == lamp.capability)
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
            assert {one.part for one in report.readings} == {lamp.part}

    async def test_a_late_joiner_gets_the_newest_sighting_and_report_of_each_device(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            await lamp.report(on=True)
            await reported(lamp, reports, on=True)
            assert (await first(listen(watcher, Sighting, lamp.gateway.names.received_topics))).key == lamp.key
            late = listen(watcher, Report, lamp.gateway.names.readings)
            assert [value(lamp, one) for one in kept(late) if value(lamp, one) is not None] == [True]

    async def test_a_device_that_reports_again_is_sighted_with_a_later_expiry(self) -> None:
        async with self.house() as (lamp, watcher):
            sightings = listen(watcher, Sighting, lamp.gateway.names.received_topics)
            before = await announced(lamp, watcher)
            await anyio.sleep(1.1)
            await lamp.report(on=True)
            with anyio.fail_after(PATIENCE):
                while (sighting := await sightings.receive()).expires_at == before.expires_at:
                    pass
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
            with anyio.fail_after(PATIENCE):
                while (sighting := await sightings.receive()).kind != "removed":
                    pass
            assert sighting.key == lamp.key
            assert kept(listen(watcher, Sighting, lamp.gateway.names.received_topics)) == []
            assert kept(listen(watcher, Report, lamp.gateway.names.readings)) == []
