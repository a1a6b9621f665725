"""The presence guard: what apps may not do where somebody is, or where that is unknown; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, refusal
from tests.control.kept_store import KeptStore
from tests.set_clock import SetClock

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light, WindowCovering
from homebot.devices.health import HealthRequest
from homebot.devices.names import ROBOT_POSES
from homebot.devices.outcomes import Confirmed, NoAnswer, Refused
from homebot.devices.robot_messages import RobotPose
from homebot.devices.value import Value
from homebot.errors import ConfigError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.graph import Node, qos_profile_latched
from homebot.journal.store import LearntRow
from homebot.messages import Time

pytestmark = pytest.mark.virtual_time

GUARD = {"absent_after": 300}
"""Five minutes in place of twenty."""


@pytest.fixture
def home_settings() -> dict[str, object]:
    return {"presence_guard": GUARD}


def put_hall(home: Home) -> None:
    home.put("lamp", "light", "on_off", "level", area="Hall")
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")


@pytest.fixture
async def lamp(home: Home) -> Light:
    """A lamp in the hall, where a motion sensor is."""
    put_hall(home)
    return await home.handle(Light, "lamp")


async def leave(home: Home) -> None:
    """Let there be motion, and then none for as long as it takes to be sure."""
    await detect(home)
    await home.report("motion", "occupancy", False)
    await anyio.sleep(301)


async def detect(home: Home) -> None:
    """Let there be motion, until it is known."""
    await anyio.sleep(0.01)
    await home.report("motion", "occupancy", True)
    await anyio.sleep(0.01)


async def test_a_lamp_is_not_turned_off_over_somebody(home: Home) -> None:
    put_hall(home)
    await home.report("motion", "occupancy", True)
    outcome = await (await home.handle(Light, "lamp")).turn_off()
    assert isinstance(outcome, Refused)
    assert (outcome.policy, outcome.reason) == (
        "presence_guard",
        "somebody is in Hall: occupancy of motion is on",
    )
    assert home.commands == []


async def test_a_lamp_is_not_turned_off_before_a_robot_on_its_way_until_it_is_there(home: Home, lamp: Light) -> None:
    await leave(home)
    async with Node(home.graph, "robots") as robots:
        poses = robots.create_publisher(RobotPose, ROBOT_POSES, qos_profile_latched)
        for way, outcome in ((("Study", "hall"), Refused), ((), Confirmed), (("hall",), Refused)):
            poses.publish(RobotPose(robot="rosie", way=way, received_at=Time.from_seconds(0), limit=5.0))
            await anyio.sleep(0.1)
            assert isinstance(await lamp.turn_off(), outcome)
        assert await refusal(lamp.turn_off()) == "the robot rosie is on its way in Hall or to it"
        await anyio.sleep(60)  # nothing is heard of it
        assert (await lamp.turn_off()).succeeded


async def test_a_refusal_names_the_sensor_without_the_id_of_its_part(home: Home) -> None:
    home.put("lamp", "light", "on_off", area="Hall")
    part = simple_part("occupancy_sensor", readable=("occupancy",)).model_copy(update={"id": "pir"})
    home.gateway.devices.put(GatewayDevice("motion", "Motion", (part,), area="Hall"), "the test says so")
    lamp = await home.handle(Light, "lamp")
    for occupied, reason in (
        (None, "it is unknown whether anybody is in Hall: no current occupancy of motion"),
        (False, "it is unknown whether anybody is in Hall: motion has never detected anybody; walk past it once"),
        (True, "somebody is in Hall: occupancy of motion is on"),
    ):
        if occupied is not None:
            await home.gateway.devices.report("motion", {"occupancy": occupied}, "pir")
            await anyio.sleep(0.01)
        assert await refusal(lamp.turn_off()) == reason


async def test_level_0_is_off(home: Home, lamp: Light) -> None:
    await home.report("motion", "occupancy", True)
    assert isinstance(await lamp.set_level(0), Refused)


async def test_it_may_be_turned_on_and_dimmed(home: Home, lamp: Light) -> None:
    await home.report("motion", "occupancy", True)
    assert (await lamp.turn_on()).succeeded
    assert (await lamp.set_level(20)).succeeded


async def test_somebody_who_sits_still_is_there_for_a_while(home: Home, lamp: Light) -> None:
    await detect(home)
    await home.report("motion", "occupancy", False)
    await anyio.sleep(299)
    assert "somebody was in Hall 299 s ago" in await refusal(lamp.turn_off())
    await anyio.sleep(2)
    assert (await lamp.turn_off()).succeeded


def put_radar(home: Home, tag: str, name: str = "motion") -> None:
    part = simple_part("occupancy_sensor", readable=("occupancy",)).model_copy(update={"tag": tag})
    home.gateway.devices.put(GatewayDevice(name, name.title(), (part,), area="Hall"), "the test says so")


@pytest.mark.parametrize(("tag", "seconds"), [("presence", 60), ("occupancy", 1200), ("motion", 1200), ("", 1200)])
async def test_a_presence_sensor_sees_sooner_that_nobody_is_there(
    open_home: OpenHome, tag: str, seconds: float
) -> None:
    async with open_home(presence_guard=True) as home:
        home.put("lamp", "light", "on_off", area="Hall")
        put_radar(home, tag)
        lamp = await home.handle(Light, "lamp")
        await detect(home)
        await home.report("motion", "occupancy", False)
        await anyio.sleep(1200)
        await detect(home)
        await home.report("motion", "occupancy", False)
        await anyio.sleep(seconds - 2)
        assert "somebody was in Hall" in await refusal(lamp.turn_off())
        await anyio.sleep(3)
        assert (await lamp.turn_off()).succeeded


@pytest.mark.parametrize("said", [(True, False), (False,), (True,), ()])
async def test_where_a_presence_sensor_sees_nobody_motion_sensors_are_not_waited_for(
    open_home: OpenHome, said: tuple[bool, ...]
) -> None:
    """Unless it has never seen anybody, still does, or says nothing: then it may be broken."""
    async with open_home(presence_guard=True) as home:
        put_hall(home)
        put_radar(home, "presence", "radar")
        lamp = await home.handle(Light, "lamp")
        await detect(home)
        await home.report("motion", "occupancy", False)
        await anyio.sleep(1500)
        await detect(home)
        for one in said:
            await home.report("radar", "occupancy", one)
            await anyio.sleep(0.01)
        await home.report("motion", "occupancy", False)
        await anyio.sleep(61)
        assert (await lamp.turn_off()).succeeded is (said == (True, False))


@pytest.mark.parametrize(
    ("written", "motion", "presence"),
    [(1200, 1200, 60), (30, 30, 60), ("8s", 8, 60), ({"presence": 120}, 1200, 120), ({"motion": 600}, 600, 60)],
)
def test_the_time_is_given_by_kind_or_as_that_of_motion_sensors(
    written: object, motion: float, presence: float
) -> None:
    settings = ControlSettings.model_validate({"presence_guard": {"absent_after": written}}).presence_guard
    assert settings is not None
    assert (settings.absent_after.motion, settings.absent_after.presence) == (motion, presence)


@pytest.mark.parametrize("by", [-1e9, -400.0, 400.0, 1e9])
async def test_a_computer_whose_clock_is_set_forgets_nobody(open_home: OpenHome, by: float) -> None:
    clock = SetClock(1.8e9)
    async with open_home(clock=clock, presence_guard=GUARD) as home:
        put_hall(home)
        lamp = await home.handle(Light, "lamp")
        await detect(home)
        await home.report("motion", "occupancy", False)
        await anyio.sleep(100)
        clock.wall += by
        assert isinstance(await lamp.turn_off(), Refused)
        await anyio.sleep(299)
        assert isinstance(await lamp.turn_off(), Refused)
        await anyio.sleep(302)
        assert (await lamp.turn_off()).succeeded


async def test_a_hand_at_the_switch_is_somebody_although_no_sensor_tells(home: Home) -> None:
    """It is faster than the sensor, which may not see the switch at all."""
    put_hall(home)
    await home.report("lamp", "on_off", False)
    await leave(home)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(100)
    lamp = await home.handle(Light, "lamp")
    assert (
        await refusal(lamp.turn_off()) == "somebody may be in Hall: lamp changed 100 s ago, and no command explains it"
    )
    await anyio.sleep(200)
    assert isinstance(await lamp.turn_off(), Confirmed)


async def test_the_first_report_after_a_start_is_no_hand(home: Home, lamp: Light) -> None:
    """A lamp that says how it is may have been so for long."""
    await leave(home)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(10)
    await home.report("lamp", "on_off", True)
    assert isinstance(await lamp.turn_off(), Confirmed)


@pytest.mark.parametrize(("told_for", "is_hand"), [(590.0, False), (700.0, True)])
async def test_the_first_level_of_a_lamp_that_was_told_to_be_on_for_long_is_a_hand(
    home: Home, lamp: Light, told_for: float, *, is_hand: bool
) -> None:
    """A text such as ``0.5`` of a lamp that said nothing but ``on`` before; soon after a start all is told."""
    await leave(home)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(told_for)
    await home.report("lamp", "level", 50.0)
    assert isinstance(await lamp.turn_off(), Refused if is_hand else Confirmed)


async def test_what_a_command_did_is_no_hand(home: Home, lamp: Light) -> None:
    await leave(home)
    home.behaviours["lamp"] = report_both
    assert (await lamp.turn_on()).succeeded
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_off(), Confirmed)


async def test_a_lamp_that_is_off_has_no_colour_and_that_is_no_hand(home: Home) -> None:
    """Home Assistant lists each attribute of a light that is off without a value."""
    home.put("lamp", "light", "on_off", "level", "color_temperature", area="Hall")
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
    await report_all(home, is_on=True)
    await leave(home)
    home.behaviours["lamp"] = lambda its, command: report_all(its, is_on=command.value.plain() is True)
    lamp = await home.handle(Light, "lamp")
    assert isinstance(await lamp.turn_off(), Confirmed)
    await anyio.sleep(10)
    assert isinstance(await lamp.turn_on(), Confirmed)
    await anyio.sleep(10)
    assert isinstance(await lamp.turn_off(), Confirmed)


async def report_all(home: Home, *, is_on: bool) -> None:
    await home.report("lamp", "on_off", is_on)
    await home.report("lamp", "level", 70.0 if is_on else 0.0)
    await home.report("lamp", "color_temperature", 2700.0 if is_on else None)


async def report_both(home: Home, command: Command) -> None:
    """Report what is commanded, and the brightness that comes with it."""
    await home.report(command.key, "on_off", command.value.plain())
    await home.report(command.key, "level", 70.0 if command.value.plain() else 0.0)


async def test_what_undoes_a_command_is_a_hand(home: Home, lamp: Light) -> None:
    await leave(home)
    assert (await lamp.turn_off()).succeeded
    await anyio.sleep(5)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_off(), Refused)


async def test_a_room_without_a_sensor_is_unknown_which_means_no(home: Home) -> None:
    reason = await refusal((await home.new(Light, "lamp", "on_off", area="attic")).turn_off())
    assert "attic" in reason
    assert "no motion sensor" in reason


async def test_a_device_without_a_room_is_not_turned_off(home: Home) -> None:
    assert "the room of the device is unknown" in await refusal((await home.lamp("on_off")).turn_off())


async def test_a_sensor_that_reported_nothing_tells_nothing(home: Home, lamp: Light) -> None:
    assert "no current occupancy of motion" in await refusal(lamp.turn_off())


async def test_a_sensor_that_never_detected_anybody_tells_nothing(home: Home, lamp: Light) -> None:
    """It may look at a wall."""
    await home.report("motion", "occupancy", False)
    await anyio.sleep(301)
    assert await refusal(lamp.turn_off()) == (
        "it is unknown whether anybody is in Hall: motion has never detected anybody; walk past it once"
    )
    await leave(home)
    assert (await lamp.turn_off()).succeeded


async def test_the_health_of_the_home_names_the_sensors_that_never_detected_anybody(home: Home) -> None:
    put_hall(home)
    home.put("elsewhere", "occupancy_sensor", readable=("occupancy",))
    await anyio.sleep(1)
    assert (await home.control.health(HealthRequest())).notes == (
        "1 motion sensor has never detected anybody, so apps turn nothing off there; walk past: Motion",
    )
    await detect(home)
    assert (await home.control.health(HealthRequest())).notes == ()


async def test_one_of_two_sensors_that_never_detected_anybody_makes_the_room_unknown(home: Home, lamp: Light) -> None:
    home.put("other", "occupancy_sensor", readable=("occupancy",), area="hall")
    await home.report("other", "occupancy", False)
    await leave(home)
    assert isinstance(await lamp.turn_off(), Refused)


async def test_a_sensor_that_was_removed_has_to_detect_somebody_again(home: Home) -> None:
    put_hall(home)
    await leave(home)
    home.gateway.devices.remove("motion", "the test says so")
    await anyio.sleep(1)
    put_hall(home)
    await home.report("motion", "occupancy", False)
    await anyio.sleep(301)
    assert "walk past it once" in await refusal((await home.handle(Light, "lamp")).turn_off())


async def test_which_sensors_detect_people_is_known_after_a_restart(open_home: OpenHome) -> None:
    store = KeptStore()
    async with open_home(presence_guard=GUARD, store=store) as home:
        put_hall(home)
        await leave(home)
    async with open_home(presence_guard=GUARD, store=store) as home:
        put_hall(home)
        await home.report("motion", "occupancy", False)
        lamp = await home.handle(Light, "lamp")
        await anyio.sleep(100)
        reason = await refusal(lamp.turn_off())
        assert reason == "it is unknown whether anybody is in Hall: motion has been heard for only 100 s"
        await anyio.sleep(201)
        assert (await lamp.turn_off()).succeeded


async def test_a_guard_that_a_reload_turns_on_knows_them_too(open_home: OpenHome) -> None:
    """The rows were read with the first command, when no policy wanted them."""
    store = KeptStore()
    store.learn(LearntRow("detection", "motion", '{"version":1}', 0.0))
    async with open_home(store=store) as home:
        assert (await (await home.lamp("on_off")).turn_on()).succeeded
        home.control.update_policies(ControlSettings.model_validate({"presence_guard": GUARD}))
        assert await home.control.detected() == ("motion",)


async def test_what_commands_taught_is_kept_beside_it(open_home: OpenHome) -> None:
    """Each reads its own rows, and neither drops those of the other."""
    store = KeptStore()
    store.learn(LearntRow("profile", "plug", '{"target":"plug","echoes":{"on_off":[true]}}', 0.0))
    async with open_home(presence_guard=GUARD, store=store) as home:
        put_hall(home)
        await leave(home)
        assert (await (await home.handle(Light, "lamp")).turn_off()).succeeded
    assert {(kind, name) for kind, name in store.rows} == {("profile", "plug"), ("detection", "motion")}


async def test_one_of_two_sensors_that_went_silent_makes_the_room_unknown(home: Home, lamp: Light) -> None:
    home.put("other", "occupancy_sensor", readable=("occupancy",), area="hall")
    await leave(home)
    assert isinstance(await lamp.turn_off(), Refused)


async def test_a_person_at_a_client_of_the_door_may(home: Home, lamp: Light) -> None:
    await home.report("motion", "occupancy", True)
    off = Setting(capability="on_off", value=Value.of(plain=False))
    request = CommandRequest(device=lamp.device.id, part="", settings=(off,), issuer="client:phone")
    assert (await home.control.perform(request)).succeeded


async def test_a_repetition_is_not_sent_to_somebody_who_came_meanwhile(home: Home, lamp: Light) -> None:
    await leave(home)
    home.behaviours["lamp"] = ignore
    home.later(1.0, "motion", "occupancy", True)
    assert isinstance(await lamp.turn_off(), NoAnswer)
    assert len(home.commands) == 1


async def test_a_blind_may_be_raised_and_not_lowered(home: Home) -> None:
    put_hall(home)
    home.put("blind", "window_covering", "position", area="hall")
    await home.report("motion", "occupancy", True)
    await home.report("blind", "position", 20.0)
    blind = await home.handle(WindowCovering, "blind")
    assert (await blind.set_position(50)).succeeded
    assert isinstance(await blind.set_position(40), Refused)
    assert (await blind.set_position(70)).succeeded


async def test_a_blind_that_was_sent_up_and_has_not_reported_may_not_be_lowered(home: Home) -> None:
    put_hall(home)
    home.put("blind", "window_covering", "position", "movement", area="hall")
    await detect(home)
    await home.report("blind", "position", 0.0)
    blind = await home.handle(WindowCovering, "blind")
    home.behaviours["blind"] = ignore
    home.tasks.start_soon(blind.open)
    await anyio.sleep(0.1)
    assert isinstance(await blind.set_position(0), Refused)
    assert isinstance(await blind.set_position(30), Refused)
    assert [one.value.plain() for one in home.commands] == ["open"]


async def test_which_commands_is_up_to_the_owner(open_home: OpenHome) -> None:
    async with open_home(presence_guard={**GUARD, "commands": ["turn on lights in hall"]}) as home:
        put_hall(home)
        await home.report("motion", "occupancy", True)
        lamp = await home.handle(Light, "lamp")
        assert isinstance(await lamp.turn_on(), Refused)
        assert isinstance(await lamp.turn_off(), Confirmed)


def test_a_verb_that_is_none_is_an_error_of_the_configuration() -> None:
    table = {"presence_guard": {"commands": ["switch off lights"]}}
    with pytest.raises(ConfigError, match="'switch off lights' is not a command") as raised:
        parse_settings(ControlSettings, table, "homebot.toml", "control")
    assert raised.value.key == "control.presence_guard.commands"


async def test_a_hand_that_undoes_a_command_and_repeats_it_is_somebody(home: Home, lamp: Light) -> None:
    """The lamp is as it was commanded within the last minute, but it was not all the time."""
    await leave(home)
    assert (await lamp.turn_on()).succeeded
    home.later(20.0, "lamp", "on_off", False)
    home.later(22.0, "lamp", "on_off", True)
    await anyio.sleep(30)
    assert await refusal(lamp.turn_off()) == "somebody may be in Hall: lamp changed 8 s ago, and no command explains it"


async def test_a_command_that_is_given_again_still_explains_what_it_did(home: Home, lamp: Light) -> None:
    await leave(home)
    assert (await lamp.turn_on()).succeeded
    await home.report("lamp", "on_off", False)
    await anyio.sleep(400)
    assert (await lamp.turn_on()).succeeded
    for _ in range(2):
        await anyio.sleep(65)
        assert (await lamp.turn_on()).succeeded
    assert (await lamp.turn_off()).succeeded


async def test_a_hand_before_the_newest_command_is_not_forgotten(home: Home, lamp: Light) -> None:
    """The lamp is as that command wanted, but somebody was at its switch a moment before."""
    await home.report("lamp", "on_off", True)
    await leave(home)
    await home.report("lamp", "on_off", False)
    await anyio.sleep(10)
    assert (await lamp.turn_on()).succeeded
    await anyio.sleep(10)
    assert (
        await refusal(lamp.turn_off()) == "somebody may be in Hall: lamp changed 20 s ago, and no command explains it"
    )
    await anyio.sleep(300)
    assert (await lamp.turn_off()).succeeded


async def test_a_hand_after_a_lamp_was_dimmed_is_somebody(home: Home, lamp: Light) -> None:
    await home.report("lamp", "on_off", False)
    await leave(home)

    async def light_up(home: Home, command: Command) -> None:
        await home.gateway.devices.report("lamp", {"on_off": True, "level": command.value.plain()})

    home.behaviours["lamp"] = light_up
    assert (await lamp.set_level(40.0)).succeeded
    home.later(20.0, "lamp", "on_off", False)
    home.later(25.0, "lamp", "on_off", True)
    await anyio.sleep(30)
    assert isinstance(await lamp.turn_off(), Refused)
