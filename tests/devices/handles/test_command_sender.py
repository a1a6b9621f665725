"""Which way commands go; in virtual time."""

import pytest
from tests.devices.handles.conftest import House

from homebot.devices import Route
from homebot.devices.command_sender import CommandSender
from homebot.devices.device import EVERYTHING
from homebot.devices.gateway_messages import Command, SendCommandResponse
from homebot.devices.handles import Handle, Light
from homebot.devices.value import Value
from homebot.errors import LinkError, RefusedError

pytestmark = pytest.mark.virtual_time


async def test_a_command_goes_by_the_best_way_that_can_do_it(house: House) -> None:
    """And by the next one where that turns out to be unable, which has sent nothing then."""
    ways = tuple(
        Route(gateway=gateway, key="k", part=gateway, takes=takes)
        for gateway, takes in (("native", ("on_off",)), ("other", ("on_off", "level")), ("third", EVERYTHING))
    )
    lamp = house.part("light", "on_off", "level")
    house.has(house.device("a", lamp.model_copy(update={"routes": ways})))
    for one in ("native", "other", "third"):
        house.gateway(one)
    (light,) = await house.devices.find(Light)
    await light.set_level(50)
    await light.turn_on()
    house.answers["native"] = SendCommandResponse(success=False, message="no such word", problem="refused", unable=True)
    await light.turn_off()
    assert [one[:4] for one in house.told] == [
        ("other", "other", "level", 50.0),
        ("native", "native", "on_off", True),
        ("other", "other", "on_off", False),
    ]
    house.answers["other"] = house.answers["native"].model_copy(update={"message": "no"})
    house.answers["third"] = house.answers["other"]
    assert "on_off of a was refused: no such word" in (await light.turn_on()).text
    house.answers["third"] = SendCommandResponse(success=False, message="no link", problem="unreachable")
    assert "on_off of a: no link" in (await light.turn_on()).text


async def test_a_command_that_had_no_effect_is_repeated_by_the_next_route(house: House) -> None:
    """The first accepted it: a hub that shows a device which it lost accepts everything."""
    ways = tuple(Route(gateway=one, key="k", part=one, takes=EVERYTHING) for one in ("hub", "radio"))
    lamp = house.part("light", "on_off").model_copy(update={"routes": ways})
    for one in ("hub", "radio"):
        house.gateway(one)
    sender = CommandSender(house.node)
    first = Command(key="", part="", capability="on_off", value=Value.of(True))
    again = first.model_copy(update={"repeated": True})
    for command in (first, again):
        await sender.send(house.device("a", lamp), lamp, [command])
    house.answers["radio"] = SendCommandResponse(success=False, message="it left", problem="unreachable")
    await sender.send(house.device("a", lamp), lamp, [again])
    assert [one[0] for one in house.told] == ["hub", "radio", "hub"]


async def test_a_route_that_could_take_a_command_is_named_for_approval(house: House) -> None:
    """The owner approved the lock before a second gateway found it, and the first only observes."""
    approved, late = (Route(gateway=one, key="k", part=one, approved="x" * (one == "mqtt")) for one in ("mqtt", "hub"))
    lock = house.part("lock", "lock").model_copy(update={"routes": (approved, late)})
    for one in ("mqtt", "hub"):
        house.gateway(one)
    house.answers["mqtt"] = SendCommandResponse(success=False, message="it observes", problem="refused", unable=True)
    command = Command(key="", part="", capability="lock", value=Value.of("locked"))
    with pytest.raises(RefusedError, match="it observes; `homebot approve front` lets another route take it"):
        await CommandSender(house.node).send(house.device("front", lock), lock, [command])
    assert not house.told


async def test_of_a_gateway_that_observes_and_one_that_is_down_the_latter_is_why_nothing_was_sent(house: House) -> None:
    ways = tuple(Route(gateway=one, key="k", part=one) for one in ("mqtt", "hub"))
    lamp = house.part("light", "on_off").model_copy(update={"routes": ways})
    house.gateway("mqtt")
    house.answers["mqtt"] = SendCommandResponse(success=False, message="it observes", problem="refused", unable=True)
    command = Command(key="", part="", capability="on_off", value=Value.of(True))
    with pytest.raises(LinkError, match="its gateway hub is not running"):
        await CommandSender(house.node).send(house.device("a", lamp), lamp, [command])


async def test_a_button_that_may_have_been_pressed_is_not_pressed_by_another_route(house: House) -> None:
    """A gateway that is not running pressed nothing; one that lost the device on the way may have."""
    ways = tuple(Route(gateway=one, key="k", part=one, takes=EVERYTHING) for one in ("away", "radio", "cable"))
    bell = house.part("button", "push")
    house.has(house.device("a", bell.model_copy(update={"routes": ways})))
    for one in ("radio", "cable"):
        house.gateway(one)
    (button,) = await house.devices.find(Handle)
    await button.command("push", True)
    assert [one[0] for one in house.told] == ["radio"]
    house.answers["radio"] = SendCommandResponse(success=False, message="it did not answer", problem="unreachable")
    assert "it did not answer" in (await button.command("push", True)).text
    assert [one[0] for one in house.told] == ["radio"]
