"""A device that a witness contradicted is not believed until a witness agrees; in virtual time."""

from __future__ import annotations

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import Home, OpenHome, ignore, obey
from tests.control.kept_store import KeptStore
from tests.control.witnesses.rooms import REPORTED, WITNESSED, dark_room, room, shining, telling_changes, toggle

from homebot.clock import LoopClock
from homebot.devices.approval_messages import BelieveDevice, BelieveDeviceRequest
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import BELIEVE_DEVICE
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, NoAnswer, Outcome

pytestmark = pytest.mark.virtual_time

CANNOT_TELL = "contradicted: Lux measured no change before, and cannot tell now"


async def liar(home: Home) -> Light:
    """Return a lamp that a sensor witnessed, was told to turn on and only says so."""
    lamp = await room(home, other=shining("lux", 150.0))
    await toggle(lamp, 12)
    home.behaviours["lamp"] = obey
    assert isinstance(await lamp.turn_on(), Contradicted)
    return lamp


async def test_a_liar_that_is_told_again_at_once_is_contradicted_each_time(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        home.commands.clear()
        outcomes = [await lamp.turn_on() for _ in range(5)]
        assert [one.text for one in outcomes] == ["contradicted: Lux measured no change"] * 5
        assert len(home.commands) == 5


@pytest.mark.parametrize("gap", [0.0, 3.0, 15.0, 30.0, 55.0, 70.0, 600.0])
async def test_a_liar_is_contradicted_however_soon_it_is_told_again(open_home: OpenHome, gap: float) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        for _ in range(4):
            await anyio.sleep(gap)
            assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_liar_that_is_turned_off_and_on_is_contradicted(open_home: OpenHome) -> None:
    """That it is off is true."""
    async with open_home() as home:
        lamp = await liar(home)
        for gap in (0.0, 5.0, 40.0):
            assert isinstance(await lamp.turn_off(), Confirmed)
            await anyio.sleep(gap)
            assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_lamp_that_obeys_when_it_is_told_again_is_witnessed(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        home.behaviours["lamp"] = shining("lux", 150.0)
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Confirmed)
        assert (outcome.witness, outcome.evidence) == WITNESSED
        assert outcome.latency < 1
        assert isinstance(await lamp.turn_on(), AlreadySo)


async def test_a_lie_teaches_nothing_of_the_witness(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        for _ in range(20):
            await lamp.turn_on()
            await anyio.sleep(15)
        home.behaviours["lamp"] = shining("lux", 150.0)
        assert await toggle(lamp, 2) == [WITNESSED] * 2
        home.behaviours["lamp"] = obey
        assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_lamp_whose_light_comes_later_than_ever_is_believed_again(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = shining("lux", 150.0, after=6.0)
        with capture_logs() as lines:
            assert isinstance(await lamp.turn_on(), Contradicted)
            await anyio.sleep(20)
        (line,) = [one for one in lines if one["event"] == "control.seen_late"]
        assert line["message"] == "Lux saw Lamp obey after all, later than ever"
        assert (await lamp.turn_on()).succeeded
        await lamp.turn_off()
        await anyio.sleep(60)
        assert (await lamp.turn_on()).succeeded  # it has learnt how late it may be


async def test_a_lamp_that_is_turned_on_by_hand_is_believed_again(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        await lamp.turn_off()
        await anyio.sleep(100)
        await home.report("lux", "illuminance", 150.0)
        await home.report("lamp", "on_off", True)
        await anyio.sleep(1)
        assert isinstance(await lamp.turn_on(), AlreadySo)


async def test_a_device_that_repeats_its_lie_is_not_believed(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        for _ in range(4):
            await anyio.sleep(40)
            await home.report("lamp", "on_off", True)
        assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_liar_is_not_believed_while_the_sensor_cannot_tell(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        await anyio.sleep(100)
        await home.report("lux", "illuminance", 900.0)  # the sun
        await anyio.sleep(100)
        assert (await lamp.turn_on()).text == CANNOT_TELL


async def test_a_liar_is_not_believed_while_another_lamp_is_switched(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp, other = await liar(home), await home.handle(Light, "other")
        await anyio.sleep(100)
        outcomes: dict[str, Outcome] = {}

        async def turn_on(one: Light) -> None:
            outcomes[one.name] = await one.turn_on()

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(turn_on, lamp)
            tasks.start_soon(turn_on, other)
        assert outcomes["Other"].succeeded
        assert outcomes["Lamp"].text == CANNOT_TELL


async def believe(home: Home, device: str) -> tuple[str, ...]:
    """Say what ``homebot believe`` says; return the names of the witnesses."""
    client = home.app.create_client(BelieveDevice, BELIEVE_DEVICE)
    return (await client.call(BelieveDeviceRequest(device=device))).witnesses


async def notes(home: Home) -> str:
    health = await home.app.create_client(GetHealth, "/control/health").call(HealthRequest())
    return "\n".join(health.notes)


async def test_a_lamp_whose_owner_says_that_it_was_repaired_is_believed_in_the_sun(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        assert "`homebot believe DEVICE`): lamp (Lux)" in await notes(home)
        await anyio.sleep(100)
        await home.report("lux", "illuminance", 900.0)
        await anyio.sleep(100)
        assert (await lamp.turn_on()).text == CANNOT_TELL
        assert await believe(home, "other") == ()
        assert await believe(home, "lamp") == ("Lux",)
        assert "homebot believe" not in await notes(home)
        await lamp.turn_off()
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED


async def test_a_liar_that_its_owner_believes_is_contradicted_again(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        assert await believe(home, "lamp") == ("Lux",)
        await lamp.turn_off()
        await anyio.sleep(100)
        assert isinstance(await lamp.turn_on(), Contradicted)


async def test_an_owner_can_say_so_right_after_a_restart(open_home: OpenHome) -> None:
    store, clock = KeptStore(), LoopClock()
    async with open_home(store=store, clock=clock) as home:
        await liar(home)
    for witnesses in (("Lux",), ()):
        async with open_home(store=store, clock=clock) as home:
            assert await believe(home, "lamp") == witnesses


async def test_a_lamp_without_its_witness_is_believed_again(open_home: OpenHome) -> None:
    """Nothing can tell any more, and so it is graded by its report."""
    async with open_home() as home:
        lamp = await liar(home)
        home.gateway.devices.report_reachable("lux", reachable=False)
        await anyio.sleep(1)
        assert await toggle(lamp, 1) == [REPORTED]


async def test_a_lamp_whose_witness_moved_to_another_room_is_believed_again(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        home.put("lux", "light_sensor", readable=("illuminance",), area="Attic")
        await anyio.sleep(1)
        assert await toggle(lamp, 1) == [REPORTED]


def put_back(home: Home) -> None:
    """The lamp and the sensor are there again."""
    home.put("lamp", "light", "on_off", area="Hall")
    home.put("lux", "light_sensor", readable=("illuminance",), area="Hall")


async def test_a_liar_is_not_believed_after_a_restart(open_home: OpenHome) -> None:
    store, clock = KeptStore(), LoopClock()
    async with open_home(store=store, clock=clock) as home:
        await liar(home)
    async with open_home(store=store, clock=clock) as home:
        put_back(home)
        home.behaviours["lamp"] = obey
        await home.report("lamp", "on_off", True)  # as it said before: that is no hand
        lamp = await home.handle(Light, "lamp")
        assert (await lamp.turn_on()).text == CANNOT_TELL
        assert (await lamp.turn_on()).text == CANNOT_TELL


async def test_a_first_report_after_a_restart_is_no_hand(open_home: OpenHome) -> None:
    store, clock = KeptStore(), LoopClock()
    async with open_home(store=store, clock=clock) as home:
        await liar(home)
    async with open_home(store=store, clock=clock) as home:
        put_back(home)
        home.behaviours["lamp"] = ignore
        await home.report("lux", "illuminance", 0.0)
        lamp = await home.handle(Light, "lamp")
        assert isinstance(await lamp.turn_on(), NoAnswer)
        await anyio.sleep(100)
        await home.report("lamp", "on_off", True)
        await anyio.sleep(1)
        home.behaviours["lamp"] = obey
        assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_lamp_that_is_believed_again_is_believed_after_a_restart(open_home: OpenHome) -> None:
    store, clock = KeptStore(), LoopClock()
    async with open_home(store=store, clock=clock) as home:
        lamp = await liar(home)
        home.behaviours["lamp"] = shining("lux", 150.0)
        await lamp.turn_on()
        await anyio.sleep(1)
    assert {kind for kind, _ in store.rows} == {"profile", "witness"}


async def test_a_sensor_that_died_without_a_word_contradicts_an_honest_lamp_four_times(open_home: OpenHome) -> None:
    """One that reports only changes may be dead, and its battery empty: it is forgotten."""
    async with open_home() as home:
        lamp = await dark_room(home, telling_changes())
        await toggle(lamp, 20)
        home.behaviours["lamp"] = obey  # it shines, and the sensor tells nobody
        with capture_logs() as lines:
            outcomes = []
            for _ in range(6):
                outcomes.append((await lamp.turn_on()).succeeded)
                await anyio.sleep(40)
                await lamp.turn_off()
                await anyio.sleep(40)
        assert outcomes == [False] * 4 + [True] * 2
        (line,) = [one for one in lines if one["event"] == "control.witness_forgotten"]
        assert line["message"] == "Lux reported nothing at all at 4 commands: it is no witness any more"


async def test_a_sensor_that_died_is_forgotten_although_homebot_is_restarted(open_home: OpenHome) -> None:
    store, clock = KeptStore(), LoopClock()
    async with open_home(store=store, clock=clock) as home:
        lamp = await dark_room(home, telling_changes())
        await toggle(lamp, 20)
        home.behaviours["lamp"] = obey
        assert isinstance(await lamp.turn_on(), Contradicted)
    found = []
    for _ in range(5):
        async with open_home(store=store, clock=clock) as home:
            home.put("lamp", "light", "on_off", area="Cellar")
            home.put("lux", "light_sensor", readable=("illuminance",), area="Cellar")
            lamp = await home.handle(Light, "lamp")
            await anyio.sleep(80)
            found.append((await lamp.turn_on()).succeeded)
    assert found == [False] * 3 + [True] * 2


async def test_two_lamps_that_lie_at_once_are_both_believed(open_home: OpenHome) -> None:
    """The sensor is stuck, rather, until it changes again."""
    async with open_home() as home:
        lamp = await room(home, other=shining("lux", 150.0))
        other = await home.handle(Light, "other")
        await toggle(lamp, 12)
        await toggle(other, 12)
        home.behaviours["lamp"] = home.behaviours["other"] = obey
        assert isinstance(await lamp.turn_on(), Contradicted)
        await anyio.sleep(60)
        with capture_logs() as lines:
            assert await toggle(other, 1) == [REPORTED]
        assert [one["message"] for one in lines if one["event"] == "control.witness_stuck"] == [
            "Lux measured no change of two devices: it is no witness until its illuminance changes"
        ]
        await lamp.turn_off()
        await anyio.sleep(60)
        assert await toggle(lamp, 1, gap=60) == [REPORTED]
        home.behaviours["other"] = shining("lux", 150.0)
        await other.turn_off()
        await anyio.sleep(60)
        await toggle(other, 2, gap=60)  # it moves again
        await lamp.turn_off()
        await anyio.sleep(60)
        assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_lamp_that_said_that_it_is_off_is_not_believed_either(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 13)
        home.behaviours["lamp"] = obey
        assert isinstance(await lamp.turn_off(), Contradicted)
        assert isinstance(await lamp.turn_off(), Contradicted)

        async def go_dark(home: Home, command: Command) -> None:
            await obey(home, command)
            home.later(0.2, "lux", "illuminance", 0.0)

        home.behaviours["lamp"] = go_dark
        assert isinstance(await lamp.turn_off(), Confirmed)


async def test_a_device_that_does_not_answer_is_no_liar(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await liar(home)
        home.behaviours["lamp"] = ignore
        assert isinstance(await lamp.turn_on(), NoAnswer)
