"""Changes that come along with commands to other parts: of groups, scenes, one relay or one room; in virtual time."""

import gc
from functools import partial

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, answer_requests, ignore, obey
from tests.control.kept_store import KeptStore
from tests.control.test_explanations import explain

from homebot.control import durations
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle, Light
from homebot.devices.journal_messages import GetCauses, GetCausesRequest
from homebot.devices.names import GET_CAUSES, PERFORM_COMMAND
from homebot.devices.outcomes import Confirmed, Evidence, Refused, Superseded
from homebot.devices.part import Part
from homebot.devices.wording.journal_words import finding_text
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time

LAMPS = ("left", "right")


async def put_group(home: Home, *members: str, area: str = "", room: str = "", delay: float = 0.2) -> Handle:
    """Put a group, and two lamps that report after it; return the handle of the group."""
    for name in LAMPS:
        home.gateway.devices.put(_device(name, simple_part("light", settable=("on_off",)), room), "it was found")
    group = simple_part("light", settable=("on_off",)).model_copy(update={"members": members})
    home.gateway.devices.put(_device("group", group, area), "it was found")
    for name in (*LAMPS, "group"):
        await home.report(name, "on_off", False)
    await anyio.sleep(1.0)
    home.behaviours["group"] = partial(_tell_lamps, delay)
    return await home.handle(Handle, "group")


def _device(key: str, part: Part, area: str) -> GatewayDevice:
    return GatewayDevice(key, key.title(), (part,), area=area, identifiers=(f"id:{key}",))


async def _tell_lamps(delay: float, home: Home, command: Command) -> None:
    await obey(home, command)
    for name in LAMPS:
        home.later(delay, name, "on_off", command.value.plain())


async def told(home: Home, *names: str) -> list[str]:
    """Return the causes that the journal tells of the changes of devices, oldest first."""
    await anyio.sleep(1)
    entries = (await home.read()).entries
    return [one.cause for one in entries if one.kind in {"changed", "reported"} and one.device in names]


async def test_a_lamp_of_a_group_changes_by_the_command_to_the_group(home: Home) -> None:
    group = await put_group(home, *(f"id:{name}" for name in LAMPS))
    assert isinstance(await group.command("on_off", True), Confirmed)
    assert await told(home, *LAMPS) == ["command", "command"]
    why = await explain(home, "left")
    names = {one.key: one.value for one in why.names}
    assert finding_text(why, names, home.graph.clock.now()).endswith(
        "app asked Group for on; it changed along with that."
    )


@pytest.mark.parametrize("name", ["id:left", "id:left#", "#"])
async def test_a_member_is_named_by_its_device_or_its_part(home: Home, name: str) -> None:
    group = await put_group(home, name)
    await group.command("on_off", True)
    assert (await told(home, "left"))[0] == "command"
    assert await told(home, "right") == ["command" if name == "#" else "person"]


async def test_a_lamp_of_a_group_in_a_group_is_a_member_too(home: Home) -> None:
    """Even if the groups contain each other; a lease on it was no reason against a command to the outer one."""
    inner = await put_group(home, "id:left", "id:house")
    outer = simple_part("light", settable=("on_off",)).model_copy(update={"members": ("id:group",)})
    home.gateway.devices.put(_device("house", outer, ""), "it was found")
    house = await home.handle(Handle, "house")
    found = await DeviceLookup(home.app).members(house.device, house.device.parts[0])
    assert sorted(one.id for one, _ in found) == sorted(("left", inner.device.id))
    async with (await home.handle(Light, "left")).hold("on", by="robot"):
        refused = await house.command("on_off", False)
    assert isinstance(refused, Refused)
    assert (refused.policy, refused.reason.partition(":")[0]) == ("lease", "its member left is refused it")


async def test_a_person_at_a_lamp_of_a_group_is_named_seconds_later(home: Home) -> None:
    group = await put_group(home, "id:left", "id:right")
    await group.command("on_off", True)
    await anyio.sleep(20)
    await home.report("left", "on_off", False)
    await anyio.sleep(20)
    await home.report("left", "on_off", True)
    assert await told(home, "left") == ["command", "person", "person"]


async def test_the_members_of_a_silent_group_are_asked_and_a_person_at_one_is_not_overridden(home: Home) -> None:
    group = await put_group(home, "id:left", "id:right")
    home.behaviours["group"] = ignore

    async def answer(key: str) -> None:
        """The right lamp obeyed; the left one did too, and a person has turned it off since."""
        await home.report("right", "on_off", True)
        await home.report("left", "on_off", True)
        await home.report("left", "on_off", False)

    asked = answer_requests(home, answer)
    await group.command("on_off", True)
    assert asked == ["group"]
    assert [one.key for one in home.commands] == ["group"]


async def test_a_group_is_confirmed_by_its_members(home: Home) -> None:
    group = await put_group(home, "id:left", "id:right")

    async def tell_lamps(home: Home, command: Command) -> None:
        for name in LAMPS:
            home.later(0.2, name, "on_off", command.value.plain())

    home.behaviours["group"] = tell_lamps
    outcome = await group.command("on_off", True)
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency, 1), outcome.evidence) == (0.2, Evidence.REPORTED)


async def test_a_command_to_a_group_replaces_that_to_its_lamp(home: Home) -> None:
    group = await put_group(home, "id:left", "id:right")
    await home.report("left", "on_off", True)
    home.behaviours["left"] = ignore
    outcomes = home.begin((await home.handle(Light, "left")).turn_off)
    await anyio.sleep(0.1)
    await group.command("on_off", True)
    await anyio.sleep(1)
    assert [type(one) for one in outcomes] == [Superseded]


async def command_in_turn(group: Handle, times: int) -> None:
    """Turn *group* on, off, on, and so on."""
    for number in range(times):
        await group.command("on_off", number % 2 == 0)
        await anyio.sleep(30)


async def test_a_lamp_in_the_room_of_a_command_is_no_person_and_is_learnt_after_three_times(home: Home) -> None:
    await command_in_turn(await put_group(home, area="hall", room="hall"), 5)
    assert await told(home, "left") == ["unknown"] * 3 + ["command"] * 2


async def test_a_lamp_that_did_not_follow_the_last_time_is_learnt_anew(home: Home) -> None:
    """It left the group, and a person who came at the same time turned it on."""
    group = await put_group(home, area="hall", room="hall")
    await command_in_turn(group, 4)
    home.behaviours["group"] = obey
    await command_in_turn(group, 2)
    await group.command("on_off", True)
    home.later(0.5, "left", "on_off", True)
    await anyio.sleep(30)
    assert await told(home, "left") == ["unknown"] * 3 + ["command", "unknown"]


async def test_a_change_against_a_command_near_by_is_unknown_and_not_learnt(home: Home) -> None:
    group = await put_group(home, area="hall", room="hall")
    await home.report("left", "on_off", True)
    await anyio.sleep(30)
    home.behaviours["group"] = obey
    for number in range(5):
        await group.command("on_off", True)
        home.later(1.0, "left", "on_off", False)
        await anyio.sleep(30 + 10 * number)  # what is regular is done by a program
        await home.report("left", "on_off", True)
        await group.command("on_off", False)
        await anyio.sleep(30)
    assert await told(home, "left") == ["person", *["unknown", "person"] * 5]


@pytest.mark.parametrize(("room", "cause"), [("hall", "unknown"), ("attic", "person"), ("", "person")])
async def test_only_the_room_of_a_command_is_near(home: Home, room: str, cause: str) -> None:
    group = await put_group(home, area="hall", room=room)
    await group.command("on_off", True)
    assert await told(home, "left") == [cause]


async def test_a_person_in_the_room_some_seconds_after_a_command_is_named(home: Home) -> None:
    group = await put_group(home, area="hall", room="hall", delay=3.5)
    await group.command("on_off", True)
    await anyio.sleep(5)
    assert await told(home, "left") == ["person"]


@pytest.mark.parametrize("is_alone_at_first", [False, True])
async def test_two_parts_of_one_relay_are_learnt_however_slowly_it_answers(
    home: Home, *, is_alone_at_first: bool
) -> None:
    relay = simple_part("switch", settable=("on_off",))
    parts = tuple(relay.model_copy(update={"id": one}) for one in ("relay", "light"))
    if is_alone_at_first:
        home.gateway.devices.put(GatewayDevice("plug", "Plug", parts[:1]), "it was found")
        await (await home.handle(Handle, "plug")).command("on_off", True)
    home.gateway.devices.put(GatewayDevice("plug", "Plug", parts), "it was found")
    for one in parts:
        await home.gateway.devices.report("plug", {"on_off": False}, one.id)
    await anyio.sleep(1)

    async def answer(home: Home, command: Command) -> None:
        async def tell() -> None:
            await anyio.sleep(5)
            for one in ("light", "relay"):
                await home.gateway.devices.report("plug", {"on_off": command.value.plain()}, one)

        home.tasks.start_soon(tell)

    home.behaviours["plug"] = answer
    for number in range(4):
        settings = (Setting.of("on_off", number % 2 == 0),)
        request = CommandRequest(device="plug", part="relay", settings=settings, issuer="/app")
        await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=60)
        await anyio.sleep(30)
    await anyio.sleep(1)
    entries = [one for one in (await home.read()).entries if one.part == "light"]
    assert [one.cause for one in entries] == ["unknown"] * 3 + ["command"]


async def test_a_part_that_was_alone_at_first_changes_with_one_that_came_later(home: Home) -> None:
    relay = simple_part("switch", settable=("on_off",))
    parts = tuple(relay.model_copy(update={"id": one}) for one in ("relay", "light"))
    home.gateway.devices.put(GatewayDevice("plug", "Plug", parts[:1]), "it was found")
    await home.gateway.devices.report("plug", {"on_off": False}, "relay")
    await (await home.handle(Handle, "plug")).command("on_off", False)
    home.gateway.devices.put(GatewayDevice("plug", "Plug", parts), "it was found")
    await home.gateway.devices.report("plug", {"on_off": False}, "light")
    await anyio.sleep(30)

    async def answer(home: Home, command: Command) -> None:
        for one in ("light", "relay"):
            await home.gateway.devices.report("plug", {"on_off": command.value.plain()}, one)

    home.behaviours["plug"] = answer
    request = CommandRequest(device="plug", part="light", settings=(Setting.of("on_off", True),), issuer="/app")
    await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=60)
    await anyio.sleep(1)
    assert [one.cause for one in (await home.read()).entries if one.part == "relay"][-1] == "unknown"


async def test_the_commands_to_a_device_of_one_part_are_forgotten_with_its_reports(home: Home) -> None:
    """No change of another part can belong to them; 300 lamps kept 40 MB."""
    lamp = await home.new(Light, "lonely", "on_off")
    for number in range(4):
        await lamp.command("on_off", number % 2 == 0)
        await anyio.sleep(durations.REMEMBERED + 1)
    gc.collect()
    known = [one for one in gc.get_objects() if type(one) is CommandProgress and one.order.place[0] == lamp.device.id]
    assert len(known) == 1


async def test_lamps_that_change_with_a_scene_of_their_room_are_learnt(home: Home) -> None:
    home.put("scene", "x_scene", "scene", area="hall", is_silent=True)
    home.put("lamp", "light", "on_off", area="hall")
    await home.report("lamp", "on_off", False)
    home.behaviours["scene"] = report_lamp
    scene = await home.handle(Handle, "scene")
    for _ in range(4):
        await scene.command("scene", True)
        await anyio.sleep(30)
        await home.report("lamp", "on_off", False)
        await anyio.sleep(30)
    assert (await told(home, "lamp"))[::2] == ["unknown"] * 3 + ["command"]


async def report_lamp(home: Home, _: Command) -> None:
    home.later(1.0, "lamp", "on_off", True)


async def test_an_empty_room_stays_empty_when_an_app_commands_a_group(open_home: OpenHome) -> None:
    async with open_home(presence_guard={"absent_after": 1200.0}) as home:
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        for value in (True, False):
            await home.report("motion", "occupancy", value)
            await anyio.sleep(1)
        group = await put_group(home, "id:left", room="hall")
        await anyio.sleep(1300)
        await group.command("on_off", True)
        await anyio.sleep(30)
        lamp = await home.handle(Light, "left")
        assert isinstance(await lamp.turn_off(), Confirmed)
        await home.report("left", "on_off", True)
        await anyio.sleep(1)
        assert isinstance(await lamp.turn_off(), Refused)


async def test_a_lamp_that_blinks_with_its_group_may_not_be_switched_once_more(open_home: OpenHome) -> None:
    async with open_home(rate_limit={"changes": 2, "seconds": 60}) as home:
        group = await put_group(home, *(f"id:{name}" for name in LAMPS))
        for value in (True, False, True):
            assert (await group.command("on_off", value)).succeeded
        refused = await (await home.handle(Handle, "left")).command("on_off", False)
        assert isinstance(refused, Refused)
        assert refused.policy == "rate_limit"


async def test_a_press_of_a_member_is_no_effect_of_an_earlier_press_of_its_group(home: Home) -> None:
    for name in LAMPS:
        home.gateway.devices.put(_device(name, simple_part("switch", settable=("push",)), ""), "it was found")
    group = simple_part("switch", settable=("push",)).model_copy(
        update={"members": tuple(f"id:{one}" for one in LAMPS)}
    )
    home.gateway.devices.put(_device("group", group, ""), "it was found")
    outcome = await (await home.handle(Handle, "group")).command("push", True)
    assert isinstance(outcome, Confirmed)
    await anyio.sleep(durations.UNREAD + 1.0)
    await home.report("left", "push", True)
    left = (await home.handle(Handle, "left")).device.id
    known = await home.app.create_client(GetCauses, GET_CAUSES).call(GetCausesRequest(devices=(left,)))
    assert [(one.capability, one.may_be_person) for one in known.causes] == [("push", True)]


async def test_a_restart_does_not_forget_who_commanded_the_members_of_a_group(open_home: OpenHome) -> None:
    """The command is in the journal of the group alone."""
    store, known = KeptStore(), []
    for is_first in (True, False):
        async with open_home(store=store) as home:
            group = await put_group(home, *(f"id:{name}" for name in LAMPS))
            if is_first:
                await group.command("on_off", True)
            await anyio.sleep(15)
            client = home.app.create_client(GetCauses, GET_CAUSES)
            known.append((await client.call(GetCausesRequest(devices=LAMPS, from_journal=True))).causes)
    before, after = known
    assert [cause.may_be_person for cause in before] == [False, False]
    assert after == before
