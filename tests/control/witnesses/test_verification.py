"""Sensors confirm what commands do, and contradict devices that only say so; in virtual time."""

from __future__ import annotations

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, obey, obey_after
from tests.control.witnesses.rooms import REPORTED, WITNESSED, dark_room, room, shining, telling_changes, toggle

from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle, Light, WindowCovering
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, Outcome, Superseded
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time


async def test_a_sensor_is_trusted_after_five_observations_in_each_direction(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        assert await toggle(lamp, 16) == [REPORTED] * 10 + [WITNESSED] * 6
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Confirmed)
        assert outcome.text == "confirmed after 0.2 s (witnessed by Lux)"


async def test_a_lamp_that_only_says_that_it_is_on_is_contradicted(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = obey  # the lamp says so, and the room stays dark
        began = anyio.current_time()
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Contradicted)
        assert (outcome.witness, outcome.text) == ("Lux", "contradicted: Lux measured no change")
        assert anyio.current_time() - began < 3


async def test_a_lamp_that_lies_is_not_believed_when_it_is_told_again(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = obey
        assert isinstance(await lamp.turn_on(), Contradicted)
        home.commands.clear()
        await anyio.sleep(10)
        assert isinstance(await lamp.turn_on(), Contradicted)  # and not AlreadySo
        assert home.commands
        home.behaviours["lamp"] = shining("lux", 150.0)
        await anyio.sleep(10)
        assert isinstance(await lamp.turn_on(), Confirmed)
        assert isinstance(await lamp.turn_on(), AlreadySo)


async def test_a_lamp_that_stays_on_is_contradicted(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 13)
        home.behaviours["lamp"] = obey
        assert isinstance(await lamp.turn_off(), Contradicted)


async def test_a_silent_sensor_contradicts_nobody(open_home: OpenHome) -> None:
    """Its battery may be empty."""
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lux"] = ignore
        home.behaviours["lamp"] = obey
        assert await toggle(lamp, 1) == [REPORTED]


async def test_a_sensor_that_reports_only_changes_contradicts_after_sixteen_in_a_row(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await dark_room(home, telling_changes())
        await toggle(lamp, 14)
        home.behaviours["lamp"] = obey
        assert await toggle(lamp, 2) == [REPORTED] * 2  # not for sure yet, and nothing is learnt from it
        home.behaviours["lamp"] = telling_changes()
        await toggle(lamp, 20)
        home.behaviours["lamp"] = obey
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Contradicted)
        assert outcome.witness == "Lux"


async def test_a_sensor_that_reports_only_changes_and_missed_one_has_to_show_it_again(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await dark_room(home, telling_changes())
        await toggle(lamp, 14)
        home.behaviours["lamp"] = obey
        await toggle(lamp, 2)  # it may be the lamp, or the sensor
        home.behaviours["lamp"] = telling_changes()
        await toggle(lamp, 14)
        home.behaviours["lamp"] = obey
        assert await toggle(lamp, 1) == [REPORTED]


async def test_a_sensor_that_reports_only_changes_and_is_unreachable_contradicts_nobody(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await dark_room(home, telling_changes())
        await toggle(lamp, 20)
        home.gateway.devices.report_reachable("lux", reachable=False)
        home.behaviours["lamp"] = obey
        assert await toggle(lamp, 1) == [REPORTED]


async def test_a_coarse_sensor_contradicts_in_the_dark_and_not_by_light(open_home: OpenHome) -> None:
    """The sun may have risen unreported while the lamp was on: what a fall then leaves is less than it reports."""
    async with open_home() as home:
        lamp = await dark_room(home, telling_changes())
        await toggle(lamp, 21)
        home.behaviours["lamp"] = obey
        outcome = await lamp.turn_off()
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED
        await home.report("lux", "illuminance", 0.0)
        await anyio.sleep(40)
        assert isinstance(await lamp.turn_on(), Contradicted)


async def test_a_lamp_that_a_witness_saw_obey_is_no_echo(open_home: OpenHome) -> None:
    """Although it goes back soon, again and again."""
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)

        async def obey_for_a_while(home: Home, command: Command) -> None:
            await shining("lux", 150.0)(home, command)
            home.later(1.5, "lamp", "on_off", False)
            home.later(1.5, "lux", "illuminance", 0.0)

        home.behaviours["lamp"] = obey_for_a_while
        for _ in range(5):
            outcome = await lamp.turn_on()
            assert isinstance(outcome, Confirmed)
            assert (outcome.witness, outcome.evidence) == WITNESSED
            await anyio.sleep(40)
        assert [one.result.outcome for one in home.events] == ["reverted"] * 5


async def test_a_lamp_that_shines_by_daylight_is_not_contradicted(open_home: OpenHome) -> None:
    """Its light is too little of what the sensor measures."""
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = obey
        await home.report("lux", "illuminance", 400.0)
        await anyio.sleep(100)
        assert await toggle(lamp, 2) == [REPORTED] * 2


async def test_another_lamp_in_the_room_makes_it_unclear(open_home: OpenHome) -> None:
    """Whether its light came or went in the same seconds, the sensor cannot tell whose it was."""
    async with open_home() as home:
        lamp = await room(home, other=shining("lux", 150.0))
        other = await home.handle(Light, "other")
        await toggle(lamp, 12)
        outcomes: list[Outcome] = []

        async def turn_on(one: Light) -> None:
            outcomes.append(await one.turn_on())

        home.behaviours["lamp"] = obey
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(turn_on, lamp)
            tasks.start_soon(turn_on, other)
        assert [one.evidence for one in outcomes if isinstance(one, Confirmed)] == [Evidence.REPORTED] * 2


async def test_a_lamp_switched_by_hand_makes_it_unclear(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home, other=obey)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = obey
        home.later(1.0, "other", "on_off", True)
        assert await toggle(lamp, 1) == [REPORTED]


async def test_what_always_happens_together_teaches_nothing(open_home: OpenHome) -> None:
    """A scene switches two lamps, and one of them gives the light."""
    async with open_home() as home:
        lamp = await room(home, lamp=obey, other=shining("lux", 150.0))
        other = await home.handle(Light, "other")
        for number in range(16):
            async with anyio.create_task_group() as tasks:
                for one in (lamp, other):
                    tasks.start_soon(one.turn_off if number % 2 else one.turn_on)
            await anyio.sleep(40)
        assert await toggle(lamp, 2) == [REPORTED] * 2


async def test_a_sensor_in_another_room_is_no_witness(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        home.put("lux", "light_sensor", readable=("illuminance",), area="Attic")
        assert await toggle(lamp, 14) == [REPORTED] * 14


async def test_the_owner_names_a_sensor_wherever_it_is(open_home: OpenHome) -> None:
    async with open_home(witnesses={"light in hall": "LUX"}) as home:
        lamp = await room(home)
        home.put("lux", "light_sensor", readable=("illuminance",), area="Attic")
        assert await toggle(lamp, 12) == [REPORTED] * 10 + [WITNESSED] * 2


async def test_the_owner_may_name_none(open_home: OpenHome) -> None:
    async with open_home(witnesses={"light in hall": ""}) as home:
        assert await toggle(await room(home), 14) == [REPORTED] * 14


async def test_a_contact_sees_a_blind_open(open_home: OpenHome) -> None:
    async with open_home() as home:
        home.put("blind", "window_covering", "movement", area="Hall")
        home.put("contact", "contact_sensor", readable=("contact",), area="Hall")
        home.behaviours["blind"] = follow_with_contact
        await home.report("blind", "movement", "closed")
        await home.report("contact", "contact", False)
        blind = await home.handle(WindowCovering, "blind")
        grades = []
        for number in range(14):
            outcome = await (blind.close() if number % 2 else blind.open())
            assert isinstance(outcome, Confirmed)
            grades.append(outcome.witness)
            await anyio.sleep(60)
        assert grades[-2:] == ["Contact"] * 2


async def follow_with_contact(home: Home, command: Command) -> None:
    """Move for a second; the contact senses it."""
    wanted = command.value.plain()
    home.later(1.0, "blind", "movement", wanted)
    home.later(0.9, "contact", "contact", wanted == "open")


async def test_a_witness_makes_up_for_a_lost_report(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)

        async def shine(home: Home, command: Command) -> None:
            await home.report("lux", "illuminance", 150.0)

        home.behaviours["lamp"] = shine
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Confirmed)
        assert (outcome.witness, outcome.evidence) == WITNESSED
        assert outcome.latency < 1


async def test_a_newer_command_ends_the_wait_for_a_witness(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = obey
        outcomes: list[Outcome] = []

        async def turn_on() -> None:
            outcomes.append(await lamp.turn_on())

        home.tasks.start_soon(turn_on)
        await anyio.sleep(1)
        await lamp.turn_off()
        assert [type(one) for one in outcomes] == [Superseded]


async def test_a_command_without_a_witness_waits_no_longer(open_home: OpenHome) -> None:
    """Also beside a sensor that is not trusted yet, or sees nothing of it."""
    async with open_home() as home:
        lamp = await room(home, lamp=obey_after(0.5))
        for number in range(12):
            began = anyio.current_time()
            await (lamp.turn_off() if number % 2 else lamp.turn_on())
            assert round(anyio.current_time() - began, 3) == 0.5
            await anyio.sleep(40)


async def test_a_deaf_lamp_is_as_before(open_home: OpenHome) -> None:
    async with open_home() as home:
        lamp = await room(home)
        await toggle(lamp, 12)
        home.behaviours["lamp"] = ignore
        assert not (await lamp.turn_on()).succeeded


@pytest.mark.parametrize(
    ("kind", "capability", "words", "sensor"),
    [
        ("water_valve", "valve", ("open", "closed"), "flow"),
        ("door_lock", "lock", ("unlocked", "locked"), "unlocked"),
    ],
)
async def test_a_valve_has_a_flow_meter_and_a_lock_a_bolt_sensor_for_a_witness(
    open_home: OpenHome,
    kind: str,
    capability: str,
    words: tuple[str, str],
    sensor: str,
) -> None:
    opened, closed = words
    readings: dict[str, tuple[PlainValue, PlainValue]] = {"flow": (9.0, 0.0), "unlocked": (True, False)}

    async def act(home: Home, command: Command) -> None:
        await obey(home, command)
        home.later(0.3, "sensor", sensor, readings[sensor][command.value.plain() == closed])

    async with open_home(always_ask=False) as home:
        home.put("thing", kind, capability, area="Hall")
        home.put("sensor", "contact_sensor", readable=(sensor,), area="Hall")
        home.behaviours["thing"] = act
        await home.report("thing", capability, closed)
        await home.report("sensor", sensor, readings[sensor][1])
        thing = await home.handle(Handle, "thing")
        found = []
        for number in range(21):
            settings = {capability: closed if number % 2 else opened}
            outcome = await thing.commands(settings)
            assert isinstance(outcome, Confirmed), outcome
            found.append(outcome.witness)
            await anyio.sleep(60)
        assert found[-2:] == ["Sensor"] * 2
        home.behaviours["thing"] = obey
        assert isinstance(await thing.commands({capability: closed}), Contradicted)
