"""The causes of changes: all that ask are told the same, also after a restart; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome
from tests.control.kept_store import KeptStore

from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.handles import Light
from homebot.devices.journal_messages import GetCauses, GetCausesRequest
from homebot.devices.names import GET_CAUSES
from homebot.devices.trigger import Trigger
from homebot.devices.value import Value

pytestmark = pytest.mark.virtual_time


async def causes(home: Home) -> dict[str, tuple[object, str, bool]]:
    """Return value, issuer and whether it may be a person's doing, of the newest change of each capability."""
    client = home.app.create_client(GetCauses, GET_CAUSES)
    answer = await client.call(GetCausesRequest(devices=("lamp",), from_journal=True))
    return {one.capability: (one.value.plain(), one.issuer, one.may_be_person) for one in answer.causes}


async def test_causes_are_known_after_a_restart(open_home: OpenHome) -> None:
    store = KeptStore()
    async with open_home(store=store) as home:
        home.put("lamp", "light", "on_off", "level")
        await home.report("lamp", "on_off", False)
        await home.report("lamp", "level", 20.0)
        await anyio.sleep(60)
        lamp = await home.handle(Light, "lamp")
        await lamp.turn_on()
        await anyio.sleep(60)
        await home.report("lamp", "level", 70.0)
        await anyio.sleep(60)
        known = await causes(home)
        assert known == {"on_off": (True, "/app", False), "level": (70.0, "", True)}
    async with open_home(store=store) as home:
        home.put("lamp", "light", "on_off", "level")
        await home.report("lamp", "on_off", True)
        assert await causes(home) == known


@pytest.mark.parametrize("trigger", [Trigger(), Trigger(scene="Film"), Trigger(kind="program", text="a script")])
async def test_what_a_client_commands_is_a_persons_doing_if_no_scene_or_program_led_to_it(
    open_home: OpenHome, trigger: Trigger
) -> None:
    """A lamp that somebody turned off on the page was turned on again by the app of the guide to manual override."""
    is_of_person, store = trigger == Trigger(), KeptStore()
    async with open_home(store=store) as home:
        home.put("lamp", "light", "on_off")
        await home.report("lamp", "on_off", False)
        await anyio.sleep(60)
        switched = Setting(capability="on_off", value=Value.of(True))
        issued = CommandRequest(device="lamp", settings=(switched,), issuer="client:owner", trigger=trigger)
        await home.control.perform(issued)
        await anyio.sleep(60)
        assert await causes(home) == {"on_off": (True, "client:owner", is_of_person)}
    async with open_home(store=store) as home:
        home.put("lamp", "light", "on_off")
        await home.report("lamp", "on_off", True)
        assert await causes(home) == {"on_off": (True, "client:owner", is_of_person)}


async def test_all_changes_of_one_moment_have_causes_though_no_command_had_begun_a_timeline(
    open_home: OpenHome,
) -> None:
    async with open_home() as home:
        home.put("lamp", "light", "on_off", "color_temperature", "level")
        for capability, value in (("on_off", False), ("color_temperature", 3000.0), ("level", 20.0)):
            await home.report("lamp", capability, value)
        await anyio.sleep(1000)
        for capability, value in (("on_off", True), ("level", 60.0), ("on_off", False)):
            await home.report("lamp", capability, value)
            await anyio.sleep(0.1)
        await anyio.sleep(1)
        assert await causes(home) == {"on_off": (False, "", True), "level": (60.0, "", True)}
