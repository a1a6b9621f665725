"""The control layer is loaded with the first command, in a thread, while others wait."""

import asyncio

import anyio
from tests.control.conftest import opened_home

from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.handles import Light
from homebot.support.production_loop import ProductionLoop

LAMPS = [f"lamp{number}" for number in range(30)]


def test_the_first_commands_are_sent_in_the_order_in_which_they_were_given() -> None:
    async def commanded() -> list[str]:
        async with opened_home() as home:
            for name in LAMPS:
                await home.new(Light, name, "on_off", before={"on_off": False})

            async def turn_on(name: str) -> None:
                request = CommandRequest(device=name, settings=(Setting.of("on_off", True),), issuer="/app")
                await home.control.perform(request)

            async with anyio.create_task_group() as tasks:
                for name in LAMPS:
                    tasks.start_soon(turn_on, name)
            return [command.key for command in home.commands]

    with asyncio.Runner(loop_factory=ProductionLoop) as runner:
        assert runner.run(commanded()) == LAMPS
