"""Which way commands go; in virtual time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from homebot.devices import Route
from homebot.devices.device import EVERYTHING
from homebot.devices.gateway_messages import SendCommandResponse
from homebot.devices.handles import Light
from homebot.errors import LinkError, RefusedError

if TYPE_CHECKING:
    from tests.devices.handles.conftest import House

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
    with pytest.raises(RefusedError, match="on_off of a was refused: no such word"):
        await light.turn_on()
    house.answers["third"] = SendCommandResponse(success=False, message="no link", problem="unreachable")
    with pytest.raises(LinkError, match="on_off was not sent to a: no link"):
        await light.turn_on()
