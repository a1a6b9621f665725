"""For how long a client of the door waits that does not say it; in virtual time."""

import json

import anyio
import pytest

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.protocol import CallService
from homebot.bridges.rosbridge.services import call_service
from homebot.bridges.time_slices import ServerTurns
from homebot.devices.client_rights import ALL_RIGHTS
from homebot.devices.names import COMMAND_DEVICES, HOLD_PART, PERFORM_COMMAND
from homebot.devices.robot_owners import RobotOwners
from homebot.graph import Graph, Node
from homebot.messages import Trigger
from homebot.messages.std_srvs import SuccessResponse, TriggerRequest

pytestmark = pytest.mark.virtual_time


async def answer_of(service: str, timeout: float = 0.0) -> object:
    """Return the values of the answer of a service that needs 21 seconds, as a blind does."""

    async def slow(_request: TriggerRequest) -> SuccessResponse:
        await anyio.sleep(21)
        return SuccessResponse(success=True, message="it is closed")

    frames: list[str] = []
    graph = Graph()
    async with Node(graph, "blind") as blind, Node(graph, "door") as door:
        blind.create_service(Trigger, service, slow)
        op = CallService(op="call_service", service=service, timeout=timeout)
        await call_service(door, op, ServerTurns(), ClientAccess("local", ALL_RIGHTS, RobotOwners()), frames.append)
    (frame,) = frames
    return json.loads(frame)["values"]


@pytest.mark.parametrize("service", [COMMAND_DEVICES, HOLD_PART, PERFORM_COMMAND])
async def test_the_outcome_of_a_command_is_waited_for_as_long_as_it_takes(service: str) -> None:
    assert await answer_of(service) == {"success": True, "message": "it is closed"}


async def test_any_other_service_has_five_seconds() -> None:
    assert "did not answer within 5 s" in str(await answer_of("/slow"))


async def test_a_client_may_set_a_limit_of_its_own() -> None:
    assert "did not answer within 3 s" in str(await answer_of(COMMAND_DEVICES, timeout=3))
