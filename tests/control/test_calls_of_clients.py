"""What a person does through an app: a client of the door calls its service."""

import json
from collections.abc import Awaitable, Callable

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, hold_request

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.rosbridge.protocol import CallService
from homebot.bridges.rosbridge.services import call_service
from homebot.bridges.time_slices import ServerTurns
from homebot.devices.client_rights import LOCAL_RIGHTS, ClientRights
from homebot.devices.handles import Light
from homebot.devices.robot_owners import RobotOwners
from homebot.devices.trigger import Trigger as Cause
from homebot.devices.wording.journal_words import trigger_text
from homebot.graph import Node
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.words.rights import read_scope

pytestmark = pytest.mark.virtual_time

SERVICE = "/app/dark"
Dark = Callable[[Light], Awaitable[str]]


async def now(lamp: Light) -> str:
    return (await lamp.turn_off()).text


async def two_minutes_later(lamp: Light) -> str:
    await anyio.sleep(120)
    return await now(lamp)


async def call(home: Home, rights: ClientRights = LOCAL_RIGHTS, dark: Dark = now) -> str:
    """Call the service of the app in an occupied hall, as a client does; return the outcome of its command."""
    home.put("lamp", "light", "on_off", area="hall")
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
    await home.report("lamp", "on_off", True)
    await home.report("motion", "occupancy", True)
    lamp = await home.handle(Light, "lamp")

    async def answer(_: TriggerRequest) -> SuccessResponse:
        return SuccessResponse(success=True, message=await dark(lamp))

    home.app.create_service(Trigger, SERVICE, answer)
    frames: list[str] = []
    async with Node(home.graph, "door") as door:
        op = CallService(op="call_service", service=SERVICE, timeout=600.0)
        access = ClientAccess("tablet", rights, RobotOwners())
        await call_service(door, op, ServerTurns(), access, frames.append)
    text = json.loads(frames[0])["values"]["message"]
    assert isinstance(text, str)
    return text


async def test_the_call_of_a_client_turns_off_the_light_of_an_occupied_room(open_home: OpenHome) -> None:
    async with open_home(presence_guard=True) as home:
        assert (await call(home)).startswith("confirmed")


@pytest.mark.parametrize(
    ("rights", "dark"), [(read_scope(["act: light in hall"]), now), (LOCAL_RIGHTS, two_minutes_later)]
)
async def test_a_client_with_few_rights_and_a_later_command_are_no_wish(
    open_home: OpenHome, rights: ClientRights, dark: Dark
) -> None:
    """The app may command more than such a client."""
    async with open_home(presence_guard=True) as home:
        assert "somebody is in hall" in await call(home, rights, dark)


async def test_the_journal_names_the_client_and_the_service(open_home: OpenHome) -> None:
    async with open_home(presence_guard=True) as home:
        await call(home)
        entries = (await home.read()).entries
        (asked,) = (one for one in entries if one.kind == "requested")
        assert asked.issuer == "/app"
        assert trigger_text(asked.trigger, {}) == "the client tablet called /app/dark"


async def test_a_lease_names_the_client_whose_call_is_its_cause(home: Home) -> None:
    """So do the refusal of another command, and the commands and steps of the lease in the journal."""

    async def hold(lamp: Light) -> str:
        async with lamp.hold("on", by="party"):
            ((holder,),) = (one.holders for one in await home.leases())
            return f"{trigger_text(holder.trigger, {})}; {(await lamp.turn_off()).text}"

    cause = "the client tablet called /app/dark"
    assert await call(home, dark=hold) == f"{cause}; refused (lease): held on by party ({cause}) for 10 s more"
    entries = (await home.read()).entries
    causes = [(one.kind, trigger_text(one.trigger, {})) for one in entries if one.trigger.kind]
    assert causes == [("held", cause), ("requested", f"party ({cause}) holds it"), ("requested", cause)]


async def test_a_client_names_no_other_as_the_cause_of_its_lease(home: Home) -> None:
    await home.lamp("on_off")
    cause = Cause(kind="client", text="client:owner called /app/dark")
    await home.hold(hold_request("lamp", "on_off", True, scope=("act: all",), trigger=cause))
    (held,) = await home.leases()
    assert [one.trigger.kind for one in held.holders] == [""]
