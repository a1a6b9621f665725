"""Raw texts are no way around policies, leases and the journal."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome
from tests.control.test_groups import put_group
from tests.control.test_journal import kinds

from homebot.devices import Device
from homebot.devices.handles import DoorLock, Light
from homebot.devices.outcomes import Superseded
from homebot.errors import LinkError, RefusedError
from homebot.graph import Node

pytestmark = pytest.mark.virtual_time


async def lamp_in_hall(home: Home, *, somebody_is_there: bool) -> Device:
    """Return a lamp that is on, in a room where a sensor tells whether somebody is there."""
    home.put("lamp", "light", "on_off", "level", area="Hall")
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="Hall")
    await anyio.sleep(1)
    await home.report("lamp", "on_off", True)
    await home.report("motion", "occupancy", True)
    await anyio.sleep(1)
    await home.report("motion", "occupancy", somebody_is_there)
    await anyio.sleep(1)
    return (await home.handle(Light, "lamp")).device


@pytest.mark.parametrize("text", ["off", "OFF", " off ", "0"])
async def test_a_text_that_turns_a_lamp_off_is_refused_where_somebody_is(open_home: OpenHome, text: str) -> None:
    async with open_home(presence_guard=True) as home:
        lamp = await lamp_in_hall(home, somebody_is_there=True)
        with pytest.raises(RefusedError, match=r"somebody is in Hall: .* \(presence_guard\)"):
            await home.devices.tell(lamp, text)
        assert home.commands == []
        found = await home.read()
        assert kinds(found)[-3:] == ["requested", "judged", "outcome"]
        assert found.entries[-1].results[0].policy == "presence_guard"
        assert len({one.command for one in found.entries[-3:]}) == 1


@pytest.mark.parametrize("text", ["on", "0.4"])
async def test_a_text_that_does_not_is_sent(open_home: OpenHome, text: str) -> None:
    async with open_home(presence_guard=True) as home:
        lamp = await lamp_in_hall(home, somebody_is_there=True)
        await home.devices.tell(lamp, text)
        await anyio.sleep(1)
        assert len(home.commands) == 1


async def test_in_an_empty_room_it_is_sent_and_its_chain_is_whole(open_home: OpenHome) -> None:
    async with open_home(presence_guard={"absent_after": 1}) as home:
        lamp = await lamp_in_hall(home, somebody_is_there=False)
        await anyio.sleep(5)
        await home.devices.tell(lamp, "off")
        await anyio.sleep(1)
        found = await home.read()
        assert kinds(found)[-4:] == ["requested", "judged", "published", "reported"]
        assert len({one.command for one in found.entries[-4:]}) == 1
        assert {one.issuer for one in found.entries[-4:-1]} == {"/app"}


async def test_what_cannot_be_read_is_a_use_of_the_device(open_home: OpenHome) -> None:
    quiet = [{"start": "00:00", "end": "23:59:59.999", "commands": ["use lights"]}]
    async with open_home(quiet_hours=quiet) as home:
        lamp = (await home.lamp("on_off")).device
        with pytest.raises(RefusedError, match="quiet_hours"):
            await home.devices.tell(lamp, "dance")


async def test_what_cannot_be_read_is_left_to_the_device_where_no_policy_minds(open_home: OpenHome) -> None:
    async with open_home(presence_guard=True) as home:
        lamp = (await home.lamp("on_off")).device
        await home.devices.tell(lamp, "dance")
        assert kinds(await home.read()) == ["requested", "published"]


async def test_a_lock_takes_a_text_of_who_has_a_right_that_names_it(open_home: OpenHome) -> None:
    async with open_home({"/app": ("read", "act: door lock")}) as home:
        lock = await home.new(DoorLock, "lock", "lock")
        await home.devices.tell(lock.device, "unlock")
        await anyio.sleep(1)
        assert [one.value.plain() for one in home.commands] == ["unlocked"]
        with pytest.raises(RefusedError, match="it always asks, and this text cannot be decoded"):
            await home.devices.tell(lock.device, "open sesame")


async def test_a_lock_takes_no_text_of_others_but_to_lock(home: Home) -> None:
    lock = await home.new(DoorLock, "lock", "lock")
    with pytest.raises(RefusedError, match="needs a right that names it"):
        await home.devices.tell(lock.device, "unlock")
    await home.devices.tell(lock.device, "lock")
    await anyio.sleep(1)
    assert [one.value.plain() for one in home.commands] == ["locked"]


async def test_an_app_tells_only_what_it_is_granted(open_home: OpenHome) -> None:
    async with open_home({"/app": ("read", "act: plug")}) as home:
        lamp = await home.lamp("on_off")
        with pytest.raises(RefusedError, match="grants"):
            await home.devices.tell(lamp.device, "on")


async def test_what_somebody_holds_is_not_changed_by_a_text(home: Home) -> None:
    lamp = await home.lamp("on_off")
    async with lamp.hold("on", by="robot"):
        with pytest.raises(RefusedError, match=r"held on by robot for \d+ s more \(lease\)"):
            await home.devices.tell(lamp.device, "off")
        await home.devices.tell(lamp.device, "on")


async def test_what_somebody_holds_is_not_changed_by_a_text_to_its_group(home: Home) -> None:
    """As by a command to the group: a text went past the leases, rights and policies of the members."""
    group = await put_group(home, "id:left", "id:right")
    async with (await home.handle(Light, "left")).hold("on", by="robot"):
        with pytest.raises(RefusedError, match=r"its member left is refused it: held on by robot .* \(lease\)"):
            await home.devices.tell(group.device, "off")
        sent = len(home.commands)
        await home.devices.tell(group.device, "on")
        await anyio.sleep(1)
        assert len(home.commands) == sent + 1


async def test_texts_are_limited_in_their_rate(open_home: OpenHome) -> None:
    async with open_home(rate_limit={"changes": 2, "seconds": 10}) as home:
        lamp = (await home.lamp("on_off")).device
        for text in ("on", "off", "on"):
            await home.devices.tell(lamp, text)
        with pytest.raises(RefusedError, match="rate_limit"):
            await home.devices.tell(lamp, "off")


async def test_a_text_takes_the_place_of_a_command_under_way(home: Home) -> None:
    async with anyio.create_task_group() as tasks:
        lamp = await home.lamp("on_off")
        outcomes: list[object] = []

        async def turn_on() -> None:
            outcomes.append(await lamp.turn_on())

        async def ignore(_home: Home, _command: object) -> None:
            """Do nothing."""

        home.behaviours["lamp"] = ignore
        tasks.start_soon(turn_on)
        await anyio.sleep(1)
        await home.devices.tell(lamp.device, "off")
        await anyio.sleep(1)
        (outcome,) = outcomes
        assert isinstance(outcome, Superseded)
        assert [one.value.plain() for one in home.commands] == [True, False]


async def test_beside_a_runtime_nothing_is_sent_while_the_control_layer_is_away(home: Home) -> None:
    async with Node(home.graph, "homebot"):
        lamp = (await home.lamp("on_off")).device
        control = home.graph.get_node("/control")
        assert control is not None
        control.close()
        with pytest.raises(LinkError, match="the control layer is not running"):
            await home.devices.tell(lamp, "on")
