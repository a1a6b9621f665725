"""The suites of commands, carried out, refused and counted, of raw messages, of bad peers, and of exposed devices."""

import anyio
import pytest

from homebot.devices import RawCommand, RawMessage, Sighting
from homebot.devices.capabilities import LIGHTS_UP
from homebot.devices.exposure import ExposedDevice, ExposedState
from homebot.devices.gateway_messages import Command, Report
from homebot.devices.health import Quarantine
from homebot.devices.names import SENDS_NOTHING, text_address
from homebot.devices.value import Reading, Value
from homebot.gateways.base import Delivery
from homebot.testing.gateway_contract.steps import (
    KEPT,
    PATIENCE,
    ROBOT,
    announced,
    becomes_seen,
    becomes_set,
    becomes_told,
    first,
    healthy,
    kept,
    listen,
    reported,
    send,
    subscribe,
)
from homebot.testing.gateway_contract.world import GatewayWorld, HeldClock

__all__ = ["CommandSuite", "MessageSuite"]


class CommandSuite(GatewayWorld):
    """Commands reach the device, or are refused."""

    async def test_a_command_reaches_the_device(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            response = await send(lamp, watcher)
            if not self.takes_commands:
                assert (response.success, response.problem, response.unable) == (False, "refused", True)
                assert lamp.capability in response.message
                return
            assert (response.success, response.message, response.problem) == (True, "", "")
            await becomes_told(lamp, on=True)

    async def test_the_suite_sets_every_capability_that_the_part_takes_and_it_reaches_the_device(self) -> None:
        async with self.house() as (lamp, watcher):
            (part,) = (await announced(lamp, watcher)).parts
            taken = {one.name for one in part.capabilities if one.settable}
            assert taken == ({lamp.capability, *lamp.settings} if self.takes_commands else set())
            for capability, value in lamp.settings.items():
                response = await send(lamp, watcher, capability=capability, value=Value.of(value))
                assert (response.success, response.message) == (True, "")
                await becomes_set(lamp, capability, value)

    async def test_a_brightness_or_a_colour_turns_a_light_on_and_no_brightness_turns_it_off(self) -> None:
        # As ``turn_on(level=…)``, ``turn_on(kelvin=…)`` and ``turn_on(color=…)`` send nothing else
        async with self.house() as (lamp, watcher):
            if lamp.service_type != "light" or lamp.settings.keys().isdisjoint(LIGHTS_UP):
                pytest.skip("its lamp has neither")
            await announced(lamp, watcher)
            for capability in lamp.settings.keys() & LIGHTS_UP:
                await send(lamp, watcher, value=Value.of(False))
                await becomes_told(lamp, on=False)
                await send(lamp, watcher, capability=capability, value=Value.of(lamp.settings[capability]))
                await becomes_told(lamp, on=True)
            if "level" in lamp.settings:
                await send(lamp, watcher, capability="level", value=Value.of(0.0))
                await becomes_told(lamp, on=False)

    async def test_a_gateway_that_only_observes_refuses_and_sends_nothing(self) -> None:
        async with self.house(act=False) as (lamp, watcher):
            await announced(lamp, watcher)
            response = await send(lamp, watcher)
            assert (response.success, response.problem, response.unable) == (False, "refused", True)
            assert lamp.gateway.observes_because in response.message
            assert await lamp.told() is None

    async def test_in_a_dry_run_no_command_comes_to_it_although_it_would_act(self) -> None:
        # As a gateway of another project may, which ignores `act`
        async with self.house(is_muted=True) as (lamp, watcher):
            await announced(lamp, watcher)
            assert lamp.gateway.acts
            response = await send(lamp, watcher)
            assert (response.success, response.problem, response.message) == (False, "refused", SENDS_NOTHING)
            out = watcher.create_publisher(RawCommand, lamp.gateway.names.out)
            assert out.reaches(lamp.gateway.names.node)
            await out.send(RawCommand(address=text_address(lamp.key, lamp.part), payload="on"))
            offers = watcher.create_publisher(ExposedDevice, lamp.gateway.names.offers, KEPT)
            offers.publish(ROBOT)
            await anyio.wait_all_tasks_blocked()
            assert await lamp.told() is None
            counts = {one.name: one.count for one in (await healthy(lamp, watcher)).counts}
            assert not {name: count for name, count in counts.items() if name.startswith("commands") and count}
            if (neighbour := self.neighbour(lamp)) is not None:
                assert await neighbour.seen(ROBOT.name) is None

    @pytest.mark.parametrize(
        ("change", "named"),
        [
            ({"capability": "volume"}, "volume"),
            ({"part": "cellar"}, "cellar"),
            ({"key": "nobody"}, "nobody"),
            ({"value": Value.of("loud")}, "loud"),
            ({"value": Value.of(5.0)}, "5"),
        ],
        ids=["capability", "part", "device", "text", "number"],
    )
    async def test_a_command_that_no_part_can_do_is_refused_with_a_reason_and_nothing_is_sent(
        self, change: dict[str, object], named: str
    ) -> None:
        if not self.takes_commands and "value" in change:
            pytest.skip("no value is right")
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            response = await send(lamp, watcher, **change)
            assert (response.success, response.problem, response.unable) == (False, "refused", True)
            assert named in response.message
            assert await lamp.told() is None

    async def test_its_health_counts_commands(self) -> None:
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            await send(lamp, watcher)
            await send(lamp, watcher, capability="volume")
            health = await healthy(lamp, watcher)
            counts = {one.name: one.count for one in health.counts}
            done, refused = (1, 1) if self.takes_commands else (0, 2)
            assert (counts["commands"], counts["commands_refused"], counts["commands_failed"]) == (done, refused, 0)
            assert counts["reports"] >= 1
            assert (health.troubles, health.quarantined) == ((), ())

    async def test_a_part_is_listened_to_and_told_as_text(self) -> None:
        # As the light service does it
        if not self.takes_commands:
            pytest.skip("nobody tells it anything")
        async with self.house() as (lamp, watcher):
            await announced(lamp, watcher)
            address = text_address(lamp.key, lamp.part)
            response = await subscribe(lamp, watcher, address)
            texts = watcher.create_subscription(RawMessage, response.data_topic)
            await lamp.report(on=True)
            with anyio.fail_after(PATIENCE):
                while (text := await texts.receive()).text() != "on":
                    pass
            assert (text.gateway, text.key, text.address) == (lamp.gateway.node.name, lamp.key, address)
            out = watcher.create_publisher(RawCommand, lamp.gateway.names.out, 10)
            out.publish(RawCommand(address=address, payload="on"))
            await becomes_told(lamp, on=True)


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
            with anyio.fail_after(PATIENCE):
                while (message := await messages.receive()).payload != lamp.raw(on=True):
                    pass
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
                quarantine = await first(quarantines)
                await lamp.report(on=True)
                await reported(lamp, reports, on=True)
                health = await healthy(lamp, watcher)
            assert (quarantine.gateway, quarantine.is_over) == (lamp.gateway.node.name, False)
            assert quarantine.offender
            assert quarantine.why
            assert quarantine.until.to_seconds() > quarantine.since.to_seconds()
            assert [one.offender for one in health.quarantined] == [quarantine.offender]
            counts = {one.name: one.count for one in health.counts}
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
