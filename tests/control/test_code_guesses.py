"""Codes of alarms and locks cannot be guessed quickly, and nobody else has to wait for that; in virtual time."""

from functools import partial

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, obey

from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import AlarmPanel
from homebot.devices.health import HealthRequest
from homebot.devices.outcomes import AlreadySo, Confirmed, Outcome, Refused
from homebot.devices.value import Value
from homebot.errors import WrongCodeError

pytestmark = pytest.mark.virtual_time

OWNER, GUEST = "client:owner", "client:guest"


async def only_with_the_right_code(home: Home, command: Command) -> None:
    if command.code != "4711":
        raise WrongCodeError("the alarm", "the code is wrong")
    await obey(home, command)


async def say_nothing(home: Home, command: Command) -> None:
    if command.code == "4711":
        await obey(home, command)


async def panel(home: Home, behaviour: Behaviour, before: str = "armed_away") -> AlarmPanel:
    return await home.new(AlarmPanel, "alarm", "alarm", before={"alarm": before}, behaviour=behaviour)


async def disarm(home: Home, alarm: AlarmPanel, code: str, issuer: str = GUEST) -> Outcome:
    setting = Setting(capability="alarm", value=Value.of("disarmed"))
    request = CommandRequest(
        device=alarm.device.id, part="", settings=(setting,), issuer=issuer, scope=("act: all",), code=code
    )
    return await home.control.perform(request)


@pytest.mark.parametrize("behaviour", [only_with_the_right_code, say_nothing])
async def test_wrong_codes_are_soon_refused_for_up_to_eight_seconds(home: Home, behaviour: Behaviour) -> None:
    """Also where the alarm does not answer a wrong one, and the next do not wait for that."""
    alarm = await panel(home, behaviour)
    for code in range(1000):
        home.begin(partial(disarm, home, alarm, str(code)))
        await anyio.sleep(0.1)
    tried = {one.code for one in home.commands}
    assert len(tried) == 4 + 4 + 11  # at once; in the first eight seconds; then one every eight seconds


async def test_the_refusal_says_why_and_how_long_and_the_right_code_waits_as_long(home: Home) -> None:
    alarm = await panel(home, only_with_the_right_code)
    for _ in range(9):
        await disarm(home, alarm, "1")
        await anyio.sleep(8.1)
    await disarm(home, alarm, "1")
    refused = await disarm(home, alarm, "4711")
    assert isinstance(refused, Refused)
    assert (
        refused.text == "refused (code): too many codes without a known effect by the client guest; try again in 8.0 s"
    )
    await anyio.sleep(8.1)
    assert isinstance(await disarm(home, alarm, "4711"), Confirmed)
    assert {one.name: one.count for one in (await home.control.health(HealthRequest())).counts}["codes_refused"] == 1


async def test_the_owner_does_not_wait_for_the_guesses_of_others(home: Home) -> None:
    alarm = await panel(home, only_with_the_right_code)
    for _ in range(20):
        await disarm(home, alarm, "1")
    assert isinstance(await disarm(home, alarm, "4711", OWNER), Confirmed)


async def test_right_codes_are_never_delayed(home: Home) -> None:
    alarm = await panel(home, only_with_the_right_code)
    for _ in range(20):
        assert isinstance(await disarm(home, alarm, "4711"), Confirmed | AlreadySo)
        await home.report("alarm", "alarm", "armed_away")
