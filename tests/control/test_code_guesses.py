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


async def panel(home: Home, behaviour: Behaviour, *, is_silent: bool = False) -> AlarmPanel:
    before = {} if is_silent else {"alarm": "armed_away"}
    return await home.new(AlarmPanel, "alarm", "alarm", before=before, behaviour=behaviour, is_silent=is_silent)


async def disarm(home: Home, alarm: AlarmPanel, code: str, issuer: str = GUEST) -> Outcome:
    setting = Setting(capability="alarm", value=Value.of("disarmed"))
    request = CommandRequest(
        device=alarm.device.id, part="", settings=(setting,), issuer=issuer, scope=("act: all",), code=code
    )
    return await home.control.perform(request)


@pytest.mark.parametrize("is_silent", [False, True])
@pytest.mark.parametrize("behaviour", [only_with_the_right_code, say_nothing])
async def test_four_wrong_codes_are_tried_at_once_and_then_one_every_eight_seconds(
    home: Home,
    behaviour: Behaviour,
    is_silent: bool,  # noqa: FBT001 - the case
) -> None:
    """Also where the alarm does not answer a wrong one, and the next do not wait for that."""
    alarm = await panel(home, behaviour, is_silent=is_silent)
    for code in range(1000):
        home.begin(partial(disarm, home, alarm, str(code)))
        await anyio.sleep(0.1)
    assert len({one.code for one in home.commands}) == 4 + 12


@pytest.mark.parametrize(
    ("is_silent", "why"),
    [
        (False, "too many codes without a known effect by the client guest"),
        (True, "alarm reports no effect of a code, so the client guest may give one every 8 s"),
    ],
)
async def test_the_refusal_says_why_and_how_long_and_the_right_code_waits_as_long(
    home: Home,
    is_silent: bool,  # noqa: FBT001 - the case
    why: str,
) -> None:
    alarm = await panel(home, only_with_the_right_code, is_silent=is_silent)
    for _ in range(4):
        await disarm(home, alarm, "1")
    refused = await disarm(home, alarm, "4711")
    assert isinstance(refused, Refused)
    assert refused.text == f"refused (code): {why}; try again in 8.0 s"
    await anyio.sleep(8.1)
    assert isinstance(await disarm(home, alarm, "4711"), Confirmed)
    assert {one.name: one.count for one in (await home.control.health(HealthRequest())).counts}["codes_refused"] == 1


async def test_a_lock_that_only_acknowledges_takes_four_right_codes_again_after_half_a_minute(home: Home) -> None:
    alarm = await panel(home, only_with_the_right_code, is_silent=True)
    for _ in range(5):
        for _ in range(4):
            assert isinstance(await disarm(home, alarm, "4711"), Confirmed)
        await anyio.sleep(33)


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
