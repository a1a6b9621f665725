"""The suite of commands: those that are carried out, refused and counted, in values and as text."""

import anyio
import pytest

from homebot.devices import RawCommand, RawMessage
from homebot.devices.capabilities import LIGHTS_UP
from homebot.devices.command_messages import Setting
from homebot.devices.exposure import ExposedDevice
from homebot.devices.names import SENDS_NOTHING, text_address
from homebot.devices.value import Value
from homebot.testing.gateway_contract.steps import (
    KEPT,
    ROBOT,
    announced,
    becomes_set,
    becomes_told,
    healthy,
    send,
    subscribe,
    until,
)
from homebot.testing.gateway_contract.world import GatewayWorld


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
            taken = {capability.name for capability in part.capabilities if capability.settable}
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

    async def test_one_message_sets_all_that_its_protocol_can_set_in_one(self) -> None:
        async with self.house() as (lamp, watcher):
            if "level" not in lamp.settings or lamp.service_type != "light":
                pytest.skip("it has no level")
            await announced(lamp, watcher)
            hue = {"color"} if "color_temperature" in lamp.settings else set()
            wanted = {name: lamp.settings[name] for name in ("level", *(lamp.settings.keys() & LIGHTS_UP - hue))}
            wanted[lamp.capability] = True
            await send(lamp, watcher, value=Value.of(False))
            await becomes_told(lamp, on=False)
            also = tuple([Setting.of(name, value) for name, value in wanted.items() if name != "level"])
            response = await send(lamp, watcher, capability="level", value=Value.of(wanted["level"]), also=also)
            assert (response.success, response.message) == (True, "")
            assert {*response.along} - {"level"} == lamp.together & wanted.keys() - {"level"}
            for name in wanted.keys() & {"level", *response.along} - {lamp.capability}:
                await becomes_set(lamp, name, wanted[name])
            await becomes_told(lamp, on=True)

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
            counts = {count.name: count.count for count in (await healthy(lamp, watcher)).counts}
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
            counts = {count.name: count.count for count in health.counts}
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
            text = await until(
                texts, f"after Lamp.report() the text `on` of {address}", lambda message: message.text() == "on"
            )
            assert (text.gateway, text.key, text.address) == (lamp.gateway.node.name, lamp.key, address)
            out = watcher.create_publisher(RawCommand, lamp.gateway.names.out, 10)
            out.publish(RawCommand(address=address, payload="on"))
            await becomes_told(lamp, on=True)
