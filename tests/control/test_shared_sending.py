"""One message in place of several commands: sent once, when all are there and none is outdated; in virtual time."""

from collections.abc import Awaitable, Callable

import anyio
import pytest
from tests.control.conftest import Home

from homebot.control.shared_sending import SharedSending
from homebot.control.timeline.facts import Order
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.command_sender import CommandSender
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import AlreadySo, Refused
from homebot.devices.value import Value

pytestmark = pytest.mark.virtual_time

ORDERS = (Command(key="", part="", capability="on_off", value=Value.of(True)),)


def progress() -> CommandProgress:
    return CommandProgress(Order("command", {"on_off": True}, {}), 0.0, {}, {}, DeviceProfile())


async def may_send() -> bool:
    return True


async def refuse() -> bool:
    return False


async def sharing(home: Home, awaited: int = 2, may_send: Callable[[], Awaitable[bool]] = may_send) -> SharedSending:
    """Put a group, and share a message to it between *awaited* commands."""
    home.put("group", "light", "on_off")
    device = (await home.handle(Light, "group")).device
    return SharedSending(home.app, CommandSender(home.app), (device, device.parts[0]), awaited, may_send)


async def carried(shared: SharedSending, *given: CommandProgress) -> list[bool]:
    found: list[bool] = []

    async def carry(one: CommandProgress) -> None:
        found.append(await shared.send_with_group(ORDERS, one, lambda: None))

    async with anyio.create_task_group() as tasks:
        for one in given:
            tasks.start_soon(carry, one)
    return found


async def test_a_message_is_sent_once_for_all(home: Home) -> None:
    shared = await sharing(home)
    assert await carried(shared, progress(), progress()) == [True, True]
    assert [one.key for one in home.commands] == ["group"]


async def test_a_command_that_a_newer_one_replaced_while_it_waited_keeps_the_message_back(home: Home) -> None:
    """Else the lamps would be as the older commands want."""
    outdated = progress()
    outdated.superseded_by = "newer"
    assert await carried(await sharing(home), outdated, progress()) == [False, False]
    assert home.commands == []


async def test_a_command_that_is_refused_keeps_it_back_at_once_and_one_that_is_so_does_not(home: Home) -> None:
    shared = await sharing(home, 3)
    shared.leave(AlreadySo())
    assert await carried(shared, progress(), progress()) == [True, True]
    shared = await sharing(home, 3)
    shared.leave(Refused("policy", "no"))
    assert await carried(shared, progress(), progress()) == [False, False]


async def test_a_command_that_never_comes_is_waited_for_half_a_second(home: Home) -> None:
    shared, began = await sharing(home, 3), home.graph.clock.monotonic()
    assert await carried(shared, progress(), progress()) == [False, False]
    assert home.graph.clock.monotonic() - began == pytest.approx(0.6, abs=0.1)


async def test_a_message_that_may_not_be_sent_any_more_leaves_each_to_itself(home: Home) -> None:
    shared = await sharing(home, may_send=refuse)
    assert await carried(shared, progress(), progress()) == [False, False]
    assert home.commands == []
