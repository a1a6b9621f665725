"""Actions of the control layer: commands with progress, and values that are held until the goal is cancelled."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, obey_after, refusal

from homebot.devices.action_messages import (
    CommandDevicesAction,
    CommandDevicesFeedback,
    CommandDevicesGoal,
    CommandDevicesResult,
    HoldDevice,
    HoldDeviceFeedback,
    HoldDeviceGoal,
    HoldDeviceResult,
)
from homebot.devices.command_messages import Setting
from homebot.devices.handles import Closure
from homebot.devices.lease_messages import EndLeases
from homebot.devices.names import END_LEASES, HOLD_DEVICE, PERFORM_COMMANDS
from homebot.errors import GoalAbortedError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.graph import Node
from homebot.graph.actions import ActionClient, GoalState

pytestmark = pytest.mark.virtual_time


def hold_goal(value: str = "open", seconds: float = 0.0) -> HoldDeviceGoal:
    return HoldDeviceGoal(
        device="door",
        setting=Setting.of("movement", value),
        by="robot",
        seconds=seconds,
        issuer="client:robot",
        scope=("act: closure",),
    )


async def put_door(home: Home) -> None:
    home.put("door", "closure", "movement", "position")
    await home.report("door", "movement", "closed")
    await anyio.sleep(0.01)  # of virtual time, in which the directory takes everything in


HoldClient = ActionClient[HoldDeviceGoal, HoldDeviceResult, HoldDeviceFeedback]
CommandClient = ActionClient[CommandDevicesGoal, CommandDevicesResult, CommandDevicesFeedback]


def hold_client(node: Node) -> HoldClient:
    return ActionClient(node, HoldDevice, HOLD_DEVICE)


def command_client(node: Node) -> CommandClient:
    return ActionClient(node, CommandDevicesAction, PERFORM_COMMANDS)


async def test_actions_are_listed_before_anything_of_them_is_made(home: Home) -> None:
    listed = {one.name: (one.ros_type, one.servers) for one in home.graph.actions()}
    assert listed == {
        PERFORM_COMMANDS: ("homebot/action/CommandDevices", ("/control",)),
        HOLD_DEVICE: ("homebot/action/HoldDevice", ("/control",)),
    }
    assert not [one for one in home.graph.get_service_names_and_types() if "_action" in one]
    assert home.graph.get_action_type(HOLD_DEVICE) is HoldDevice
    assert [one.name for one in home.graph.actions()] == sorted(listed)


async def test_each_outcome_is_feedback_as_soon_as_it_is_known(home: Home) -> None:
    for key, seconds in (("slow", 5.0), ("fast", 1.0)):
        home.put(key, "light", "on_off", area="hall")
        home.behaviours[key] = obey_after(seconds)
    await anyio.sleep(0.01)
    feedback: list[tuple[str, int]] = []
    result = await command_client(home.app).perform(
        CommandDevicesGoal(target="light in hall", command="on"),
        lambda message: feedback.append((message.commanded.device, message.waiting)),
    )
    assert feedback == [("fast", 1), ("slow", 0)]
    assert (result.success, result.outcome, len(result.results)) == (True, "confirmed", 2)


async def test_a_command_without_success_is_an_aborted_goal_with_its_reason(home: Home) -> None:
    with pytest.raises(GoalAbortedError) as caught:
        await command_client(home.app).perform(CommandDevicesGoal(target="nothing", command="on"))
    assert isinstance(caught.value.result, CommandDevicesResult)
    assert "nothing" in caught.value.result.message


async def test_a_cancelled_command_is_not_repeated_and_returns_what_was_known(home: Home) -> None:
    for key, behaviour in (("silent", ignore), ("lamp", obey_after(0.5))):
        home.put(key, "light", "on_off", area="hall")
        home.behaviours[key] = behaviour
    await anyio.sleep(0.01)
    goal = await command_client(home.app).send_goal(CommandDevicesGoal(target="light in hall", command="on"))
    await anyio.sleep(1.0)
    await goal.cancel()
    state, result = await goal.result()
    assert (state, [one.device for one in result.results]) == (GoalState.CANCELED, ["lamp"])
    await anyio.sleep(60.0)
    assert sorted(one.key for one in home.commands) == ["lamp", "silent"]
    entries = (await home.read(device="silent")).entries
    texts = [one.results[0].text for one in entries if one.kind == "outcome"]
    assert texts == ["no answer within 1 s"]


async def test_a_hold_is_released_when_its_goal_is_cancelled(open_home: OpenHome) -> None:
    async with open_home(always_ask=False, rate_limit=False) as home:
        await put_door(home)
        home.behaviours["door"] = obey_after(2.0)
        phases: list[str] = []
        client = hold_client(home.app)
        goal = await client.send_goal(hold_goal(), lambda message: phases.append(message.phase))
        await anyio.sleep(10.5)
        assert (phases[0], phases[-1]) == ("commanding", "held")
        assert not (await (await home.handle(Closure)).close()).succeeded
        assert len(await home.leases()) == 1
        await goal.cancel()
        assert await goal.result() == (GoalState.CANCELED, HoldDeviceResult(success=True, message="released"))
        assert await home.leases() == ()


async def test_a_hold_names_its_device_as_people_do(open_home: OpenHome) -> None:
    async with open_home(always_ask=False, rate_limit=False) as home:
        await put_door(home)
        (door,) = await home.devices.find("closure")
        assert door.name != door.id
        goal = hold_goal(seconds=1.0).model_copy(update={"device": door.name.upper()})
        assert (await hold_client(home.app).perform(goal)).success


async def test_a_hold_without_a_name_of_its_holder_has_that_of_the_client(open_home: OpenHome) -> None:
    async with open_home(always_ask=False, rate_limit=False) as home:
        await put_door(home)
        fields = hold_goal().model_dump(exclude={"by", "setting"})
        goal = await hold_client(home.app).send_goal(HoldDeviceGoal(**fields, setting=hold_goal().setting))
        await anyio.sleep(1.0)
        ((holder,),) = (part.holders for part in await home.leases())
        assert (holder.by, holder.issuer) == ("robot", "client:robot")
        await goal.cancel()


async def test_a_hold_of_an_unknown_setting_is_refused_with_the_known_ones_and_sends_nothing(
    open_home: OpenHome,
) -> None:
    async with open_home(always_ask=False, rate_limit=False) as home:
        light = simple_part("light", settable=("on_off", "level")).model_copy(update={"id": "light"})
        home.gateway.devices.put(GatewayDevice("lamp", "Lamp", (light,)), "the test says so")
        await anyio.sleep(0.01)
        goal = HoldDeviceGoal(device="lamp", part="", setting=Setting.of("on", 1.0), by="me", issuer="/app")
        with pytest.raises(GoalAbortedError) as caught:
            await hold_client(home.app).perform(goal)
        assert isinstance(caught.value.result, HoldDeviceResult)
        assert "on of lamp: it has no such setting; it takes on_off, level" in caught.value.result.message
        assert (await home.leases(), list(home.commands)) == ((), [])


async def test_a_hold_ends_after_its_seconds_which_it_counts_from_the_first_success(open_home: OpenHome) -> None:
    async with open_home(always_ask=False, rate_limit=False) as home:
        await put_door(home)
        home.behaviours["door"] = obey_after(5.0)
        left: list[float] = []
        began = anyio.current_time()
        result = await hold_client(home.app).perform(
            hold_goal(seconds=3.0), lambda message: left.append(round(message.seconds_left))
        )
        assert result.success
        assert anyio.current_time() - began == pytest.approx(8.0, abs=0.2)
        assert left == [3, 3, 2, 1]
        assert await home.leases() == ()


async def test_a_hold_lasts_while_its_first_command_takes_long(open_home: OpenHome) -> None:
    """Its lease is short, so that others read when they may hope for the part."""
    async with open_home(always_ask=False, rate_limit=False, timeout=60) as home:
        await put_door(home)
        home.behaviours["door"] = obey_after(40.0)
        goal = await hold_client(home.app).send_goal(hold_goal())
        await anyio.sleep(50.0)
        assert await refusal((await home.handle(Closure)).close()) == "held open by robot until it is released"
        assert [one.until.sec for held in await home.leases() for one in held.holders] == [0]
        assert goal.status is GoalState.EXECUTING


async def test_a_hand_outranks_a_hold_and_an_owner_ends_it(open_home: OpenHome) -> None:
    async with open_home(always_ask=False, rate_limit=False, hand_time=20) as home:
        await put_door(home)
        phases: list[str] = []
        goal = await hold_client(home.app).send_goal(hold_goal(), lambda message: phases.append(message.phase))
        await anyio.sleep(20.0)
        await home.report("door", "movement", "closed")
        await anyio.sleep(5.0)
        assert phases[-1] == "outranked"
        await anyio.sleep(30.0)
        assert phases[-1] == "held"
        end = home.app.create_client(EndLeases, END_LEASES)
        await end.call(EndLeases.Request(device="door", issuer="client:owner"))
        state, result = await goal.result()
        assert (state, result.success) == (GoalState.ABORTED, False)
        assert "no such lease" in result.message


async def test_a_hold_that_is_refused_is_an_aborted_goal(open_home: OpenHome) -> None:
    async with open_home(always_ask=False) as home:
        await put_door(home)
        with pytest.raises(GoalAbortedError) as caught:
            await hold_client(home.app).perform(hold_goal("stopped"))
        assert isinstance(caught.value.result, HoldDeviceResult)
        assert "it does not last" in caught.value.result.message


async def test_a_hold_ends_with_the_node_of_its_client(open_home: OpenHome) -> None:
    async with open_home(always_ask=False, rate_limit=False) as home:
        await put_door(home)
        async with Node(home.graph, "robot") as robot:
            await hold_client(robot).send_goal(hold_goal())
            await anyio.sleep(10.0)
            assert len(await home.leases()) == 1
        await anyio.sleep(0.01)
        assert await home.leases() == ()
