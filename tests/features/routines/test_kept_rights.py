"""The right that a kept routine lacks is told at once, with the command that gives it."""

import argparse
import re
import shlex

import pytest

from homebot.devices.app_messages import (
    ChangeRoutine,
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    ListRoutines,
    RoutineInfo,
    RoutinesRequest,
)
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES
from homebot.features.routines import command
from homebot.graph import Node
from homebot.house import World
from homebot.house.devices import SimulatedDoorLock
from homebot.testing import virtual_house_of

pytestmark = pytest.mark.virtual_time

TEXT = '[[routines]]\nname = "Let in"\nwhen = ["7:00"]\ndo = ["front door unlock"]\nact = {act}\n'
PARSER = argparse.ArgumentParser()
command.add_arguments(PARSER)


class Owner:
    """What the owner asks for, and types."""

    def __init__(self, node: Node) -> None:
        self._change = node.create_client(ChangeRoutine, CHANGE_ROUTINE)
        self._list = node.create_client(ListRoutines, LIST_ROUTINES)

    async def change(self, **fields: object) -> ChangeRoutineResponse:
        return await self._change.call(ChangeRoutineRequest.model_validate({"name": "Let in", **fields}))

    async def routine(self) -> RoutineInfo:
        return (await self._list.call(RoutinesRequest(check=True))).routines[0]

    async def types(self, line: str) -> ChangeRoutineResponse:
        """Carry out the line of a shell, as `homebot routine edit` would."""
        program, command, *words = shlex.split(line)
        assert (program, command, words[0]) == ("homebot", "routine", "edit")
        options = PARSER.parse_args(words)
        return await self.change(change="edit", name=options.name, act=tuple(options.act))


@pytest.mark.parametrize("act", ['"ordinary"', '["light"]', "[]"])
async def test_the_command_that_is_told_lets_it_do_what_it_could_not(act: str) -> None:
    world = World.of(SimulatedDoorLock("front_door"))
    async with virtual_house_of(world=world) as house, Node(house.runtime.graph, "owner") as node:
        owner = Owner(node)
        await house.run_for("1m")
        answer = await owner.change(change="new", text=TEXT.format(act=act))
        command = re.search(r"`(homebot routine edit .+)` gives one", answer.message)
        assert command is not None, answer.message
        assert (await owner.routine()).lacks == ('id="locks/front_door"',)
        assert not (await owner.change(change="run", unless_asks=True)).asks, "it is refused"
        await house.run_for("1m")

        wrong = await owner.change(change="edit", name="Let in", act=("lock in",))
        assert not wrong.success
        assert "line" not in wrong.message
        assert "lock in" in wrong.message
        assert (await owner.types(command[1])).message == "changed Let in"
        assert (await owner.routine()).lacks == (await owner.routine()).hints == ()
        asked = await owner.change(change="run", unless_asks=True)
        assert [(one.key, one.value) for one in asked.asks] == [("front_door", "it is a door lock")]
        await house.run_for("1m")
        assert world.devices["front_door"].device.state() == "locked"
        await owner.change(change="run")
        await house.run_for("1m")
        assert world.devices["front_door"].device.state() == "unlocked"

        await owner.change(change="edit", text=TEXT.format(act=act))
        assert (await owner.routine()).lacks, "what was taken away is told too"
