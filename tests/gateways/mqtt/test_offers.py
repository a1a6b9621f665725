"""What homebot offers to a Home Assistant on the same broker."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from typing import Any, TypeAlias

import anyio
import pytest

from homebot.devices.command import Command
from homebot.devices.offer import Offer, OfferReport
from homebot.devices.part import Capability, Part
from homebot.devices.report import Reading
from homebot.devices.value import Value
from homebot.graph import DurabilityPolicy, QoSProfile

pytestmark = pytest.mark.virtual_time

MakeHouse: TypeAlias = Callable[..., AbstractAsyncContextManager[Any]]
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
PUBLISHING = {"conventions": ("homeassistant",), "homeassistant": {"publish": True}}
ROBOT = Offer(
    id="robot1",
    name="Robot",
    parts=(Part(id="", service_type="x_robot", capabilities=(Capability(name="on_off", settable=True),)),),
)


class App:
    """Offers something on the graph."""

    def __init__(self, house: Any) -> None:
        names = house.gateway.names
        self.offers = house.watcher.create_publisher(Offer, names.offers, LATCHED)
        self.reports = house.watcher.create_publisher(OfferReport, names.offer_reports, LATCHED)
        self.commands = house.watcher.create_subscription(Command, names.offer_commands, qos_profile=10)

    def say(self, *, on: bool) -> None:
        reading = Reading(part="", capability="on_off", value=Value.of(on))
        self.reports.publish(OfferReport(id="robot1", readings=(reading,)))


async def test_an_offer_is_published_and_commanded_and_is_no_device_of_ours(make_house: MakeHouse) -> None:
    async with make_house(**PUBLISHING) as house:
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        app = App(house)
        app.offers.publish(ROBOT)
        app.say(on=True)
        config, state = await house.heard()
        fields = json.loads(config.payload)
        assert (state.topic, state.payload) == (fields["state_topic"], b"ON")

        await house.say(fields["command_topic"], "OFF")
        command = app.commands.take()
        assert (command.key, command.capability, command.value.plain()) == ("robot1", "on_off", False)
        await house.cut()
        assert house.sighted() == []


async def test_what_is_offered_is_published_anew_on_a_new_link_and_what_is_withdrawn_is_not(
    make_house: MakeHouse,
) -> None:
    async with make_house(**PUBLISHING) as house:
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        app = App(house)
        app.offers.publish(ROBOT)
        app.say(on=False)
        first = {one.topic: one.payload for one in await house.heard()}
        await house.cut()
        assert {one.topic: one.payload for one in await house.heard()} == first

        app.offers.publish(ROBOT.model_copy(update={"is_withdrawn": True}))
        (gone,) = await house.heard()
        assert (gone.topic in first, gone.payload) == (True, b"")
        await house.cut()
        assert await house.heard() == []


@pytest.mark.parametrize(
    "settings", [{"conventions": ("homeassistant",)}, {**PUBLISHING, "act": False}], ids=["not wanted", "only observes"]
)
async def test_nothing_is_published_unless_it_is_wanted(make_house: MakeHouse, settings: dict[str, object]) -> None:
    async with make_house(**settings) as house:
        await house.listen("homeassistant/#", "homebot/+/offers/#")
        house.watcher.create_publisher(Offer, house.gateway.names.offers, LATCHED).publish(ROBOT)
        await anyio.sleep(0.01)
        assert await house.heard() == []
