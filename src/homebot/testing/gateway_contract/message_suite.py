"""The suite of raw messages, of peers that break the rules, and of exposed devices."""

import pytest

from homebot.devices import RawMessage, Sighting
from homebot.devices.exposure import ExposedDevice, ExposedState
from homebot.devices.gateway_messages import Command, Report
from homebot.devices.health import Quarantine
from homebot.devices.value import Reading, Value
from homebot.gateways.base import Delivery
from homebot.testing.gateway_contract.steps import (
    KEPT,
    ROBOT,
    announced,
    becomes_seen,
    first,
    healthy,
    kept,
    listen,
    reported,
    subscribe,
    until,
)
from homebot.testing.gateway_contract.world import GatewayWorld, HeldClock


class MessageSuite(GatewayWorld):
    """Raw messages, misbehaving peers and exposed devices."""

    @pytest.mark.parametrize("delivery", ["inbox", "mirror"])
    async def test_raw_messages_come_to_the_inbox_of_who_asks_or_to_the_topic_of_the_device(
        self, delivery: Delivery
    ) -> None:
        async with self.house(delivery=delivery) as (lamp, watcher):
            await announced(lamp, watcher)
            response = await subscribe(lamp, watcher, lamp.address)
            mirror = lamp.gateway.names.received_data(lamp.name)
            assert response.data_topic == {"inbox": f"{watcher.full_name}/inbox", "mirror": mirror}[delivery]
            messages = watcher.create_subscription(RawMessage, response.data_topic)
            await lamp.report(on=True)
            wanted = "after Lamp.report() the message Lamp.raw(), by PublishedDevices.deliver_raw,"
            message = await until(messages, wanted, lambda received: received.payload == lamp.raw(on=True))
            assert (message.gateway, message.key) == (lamp.gateway.node.name, lamp.key)
            assert (message.address, message.retained) == (lamp.address, False)

    async def test_a_peer_that_breaks_the_rules_is_quarantined_and_the_others_are_read(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            quarantines = listen(watcher, Quarantine, lamp.gateway.names.quarantine)
            reports = listen(watcher, Report, lamp.gateway.names.readings)
            clock = watcher.graph.clock
            assert isinstance(clock, HeldClock)
            with clock.held():  # budgets get nothing back, however long the machine takes
                await lamp.misbehave()
                wanted = "after Lamp.misbehave() a quarantine, by `admits` and `reject`,"
                quarantine = await until(quarantines, wanted)
                await lamp.report(on=True)
                await reported(lamp, reports, on=True)
                health = await healthy(lamp, watcher)
            assert (quarantine.gateway, quarantine.is_over) == (lamp.gateway.node.name, False)
            assert quarantine.offender
            assert quarantine.why
            assert quarantine.until.to_seconds() > quarantine.since.to_seconds()
            assert [entry.offender for entry in health.quarantined] == [quarantine.offender]
            counts = {count.name: count.count for count in health.counts}
            assert counts["quarantines"] == 1
            assert counts["rejected"] + counts["announcements_rejected"] > 0

    async def test_a_quarantine_ends_when_the_peer_is_quiet(self) -> None:
        if not self.time_is_virtual:
            pytest.skip("it is quiet for ten seconds")
        async with self.house() as (lamp, watcher):
            quarantines = listen(watcher, Quarantine, lamp.gateway.names.quarantine)
            await lamp.misbehave()
            begun, over = await first(quarantines), await first(quarantines)
            assert (over.offender, over.is_over) == (begun.offender, True)
            assert (await healthy(lamp, watcher)).quarantined == ()
            assert kept(listen(watcher, Quarantine, lamp.gateway.names.quarantine)) == []

    async def test_what_homebot_exposes_is_seen_by_other_systems_and_commanded_by_them(self) -> None:
        async with self.house() as (lamp, watcher):
            neighbour = self.neighbour(lamp)
            if neighbour is None:
                pytest.skip("its protocol shows homebot's own devices to nobody")
            commands = watcher.create_subscription(Command, lamp.gateway.names.offer_commands)
            offers = watcher.create_publisher(ExposedDevice, lamp.gateway.names.offers, KEPT)
            states = watcher.create_publisher(ExposedState, lamp.gateway.names.offer_reports, KEPT)
            offers.publish(ROBOT)
            states.publish(
                ExposedState(id=ROBOT.id, readings=(Reading(part="", capability="on_off", value=Value.of(True)),))
            )
            await becomes_seen(neighbour, on=True)
            await neighbour.turn(ROBOT.name, on=False)
            command = await first(commands)
            assert (command.key, command.part, command.capability) == (ROBOT.id, "", "on_off")
            assert command.value.plain() is False
            offers.publish(ROBOT.model_copy(update={"is_withdrawn": True}))
            await becomes_seen(neighbour, on=None)
            assert kept(listen(watcher, Sighting, lamp.gateway.names.received_topics)) == []
