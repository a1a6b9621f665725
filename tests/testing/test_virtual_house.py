"""A house where time is virtual: it moves when told, a day is short, and the same seed is the same day."""

import asyncio
import json
import os
import runpy
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
from tests.simulated.families import FAMILIES
from tests.sizes import nightly, size

from homebot import App
from homebot.devices import DEVICE_CHANGES as CHANGES
from homebot.errors import UsageError
from homebot.house import SimulatedLamp, WindowMotor, World, thesis_world
from homebot.house.devices import SimulatedDoorLock
from homebot.house.rooms import Room, Rooms
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.simulated_device import Placed
from homebot.mqtt.broker import BrokerLimits
from homebot.testing import EventLog, VirtualTimeLoop, virtual_house_of
from homebot.testing.event_log import MAX_EVENTS, house_report

pytestmark = pytest.mark.virtual_time

A_DAY = Path(__file__).with_name("a_day.py")


def said(log: EventLog, topic: str) -> list[str]:
    return [event.text for event in log.events if event.name == topic]


@pytest.mark.no_cover
async def test_time_moves_when_told() -> None:
    async with virtual_house_of() as house:
        assert house.now == datetime(2026, 1, 1, tzinfo=UTC)
        await house.run_for("8h")
        assert house.now.hour == 8
        await house.run_until("22:00")
        await house.run_until("22:00")
        assert house.now == datetime(2026, 1, 2, 22, tzinfo=UTC)
        await house.run_until("2026-01-03 07:30")
        await house.run_for(0.5)
        assert house.now == datetime(2026, 1, 3, 7, 30, 0, 500_000, tzinfo=UTC)
        with pytest.raises(UsageError, match="2026-01-01 00:00:00 is in the past: the house is at 2026-01-03 07:30:00"):
            await house.run_until("2026-01-01")


class Chatty(App):
    """Logs as soon as it runs."""

    async def run(self) -> None:
        self.log.info("the first line")


async def test_the_log_has_the_lines_of_an_app_from_its_start() -> None:
    async with virtual_house_of(f"{__name__}:Chatty") as house, EventLog.of(house) as log:
        assert [json.loads(text)["msg"] for text in said(log, "/rosout")].count("the first line") == 1


async def test_the_report_has_the_cause_of_the_first_change_as_well() -> None:
    """The journal, and with it its topic, begins with that."""
    async with virtual_house_of(world=World.of(SimulatedLamp("hall"))) as house, EventLog.of(house):
        await house.press("hall", "on")
        await house.run_for(2)
        assert house_report(house).split()[-4:] == ["lights/hall", "on", "by", "hand"]


@pytest.mark.rooms("esphome", "thesis")
async def test_measurements_leave_room_in_the_report_for_what_was_done() -> None:
    async with virtual_house_of(world=World.of(SimulatedLamp("hall"))) as house, EventLog.of(house):
        await house.press("hall", "on")
        for lux in range(50):
            await house.says("home425/light_levels/lux/out", f"{lux}")
            await house.run_for(2)
        _, left_out, *lines = house_report(house).splitlines()
        assert (left_out.startswith("("), [line.split()[1] for line in lines]) == (True, ["lights/hall"])


async def test_what_is_due_at_the_end_has_happened() -> None:
    async with virtual_house_of(world=World.of(WindowMotor("w", travel_time=3.0))) as house, EventLog.of(house) as log:
        await house.says("home425/windows/w/in", "open")
        await house.run_for(2.999)
        assert said(log, "home425/windows/w/out") == ["opening"]
        await house.run_for(0.001)
        assert said(log, "home425/windows/w/out") == ["opening", "open"]


@nightly
@pytest.mark.no_cover
async def test_a_device_that_falls_silent_is_stale_after_an_hour_and_gone_a_week_later() -> None:
    async with virtual_house_of() as house, EventLog.of(house) as log:
        await house.run_for("1h")
        await house.says("home425/lights/quiet/out", "off")
        spoke_at = house.clock.now()
        await house.run_for("8d")
    changes = [(event.at - spoke_at, json.loads(event.text)["kind"]) for event in log.events if event.name == CHANGES]
    assert changes == [(0.0, "appeared"), (3_600.0, "stale"), (608_400.0, "removed")]


async def test_silence_is_told_at_once_and_costs_virtual_time_only() -> None:
    async with virtual_house_of("light_service") as house:
        with pytest.raises(TimeoutError, match="nothing came on home425/lights/b/in within 60 s"):
            await house.hears("home425/lights/b/in", within=60)
        assert house.now.minute == 1


@pytest.mark.no_cover
async def test_a_day_of_the_thesis_house_passes_with_every_heartbeat_in_it() -> None:
    async with virtual_house_of("light_service", world=thesis_world()) as house:
        await house.run_for(timedelta(days=1).total_seconds())
        assert house.broker.stats.messages_received > 3 * 24 * 3600 / 300


@pytest.mark.parametrize("bad", [{"start": "noon"}, {"heartbeat": "often"}, {"heartbeat": 0}, {"world": "villa.toml"}])
async def test_what_cannot_be_is_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(UsageError):
        async with virtual_house_of(**bad):
            pass


async def test_hands_work_a_device_and_all_that_follows_at_once_has_happened() -> None:
    """The light service has the lamp off again before the test looks."""
    async with (
        virtual_house_of("light_service", world=World.of(SimulatedLamp("hall"))) as house,
        EventLog.of(house) as log,
    ):
        await house.press("hall", "on")
        assert house.world.device("hall").state() == "off"
        assert said(log, "home425/lights/hall/out")[-2:] == ["on", "off"]
        with pytest.raises(UsageError, match="there is no device 'door'; in the house are: hall"):
            await house.press("door", "open")


async def test_hands_cannot_do_what_the_device_does_not_know() -> None:
    """A misspelt word used to be silence, and the test looked elsewhere for what was wrong."""
    world = World.of(SimulatedLamp("hall"), SimulatedDoorLock("door"), LuxSensor("lux"))
    async with virtual_house_of(world=world) as house:
        with pytest.raises(UsageError, match=r"hall does not know 'onn'; it takes: on, off, 0 to 1, \d+ K to \d+ K"):
            await house.press("hall", "onn")
        with pytest.raises(UsageError, match="door does not know 'open'; it takes: lock, unlock"):
            await house.press("door", "open")
        with pytest.raises(UsageError, match="lux does not know 'dark'; it takes: a number, measure"):
            await house.press("lux", "dark")
        for word in ("on", "0.5", "3000 K"):
            await house.press("hall", word)


async def test_hands_work_sensors_too() -> None:
    """As docs/house.md says of them; a meter shows what a test says until it measures again."""
    sensors = (MotionSensor("motion"), SimulatedContactSensor("door"), PowerMeter("meter"), LuxSensor("lux"))
    async with virtual_house_of(world=World.of(*sensors, SimulatedLamp("hall", rated_watts=8))) as house:

        def states() -> list[str]:
            return [house.world.device(one.device_id).state() for one in sensors]

        for name, word in (("motion", "motion"), ("door", "open"), ("meter", "1500"), ("lux", "12.5")):
            await house.press(name, word)
        assert states() == ["motion", "open", "1500", "12.5"]
        await house.press("hall", "on")
        await house.run_for("10m")
        assert states() == ["clear", "open", "1500", "12.5"]
        for name, word in (("door", "close"), ("meter", "measure"), ("lux", "measure")):
            await house.press(name, word)
        _, door, watts, lux = states()
        assert (door, watts) == ("closed", "8")
        assert float(lux) > 12.5
        with pytest.raises(UsageError, match="motion does not know 'clear'; it takes: motion"):
            await house.press("motion", "clear")
        with pytest.raises(UsageError, match="door does not know 'ajar'; it takes: open, close"):
            await house.press("door", "ajar")


async def test_the_world_is_at_the_time_of_the_house() -> None:
    """Also between two things that happen, and from the middle of a day."""
    async with virtual_house_of(world=World.of(SimulatedLamp("hall")), start="2026-07-01 06:30") as house:
        assert house.world.now == 6.5 * 3600
        await house.run_for("17s")
        assert house.world.now == 6.5 * 3600 + 17


@pytest.mark.no_cover
async def test_a_night_without_broker_is_survived() -> None:
    async with virtual_house_of("light_service", world=thesis_world()) as house:
        await house.run_until("00:10")
        await house.broker.stop(abrupt=True)
        await house.run_for(f"{size(1, 6)}h")
        await house.broker.start()
        await house.run_for("1m")
        await house.says("home425/lights/roomlights405/out", "on")
        assert await house.hears("home425/lights/roomlights405/in") == "off"


@pytest.mark.rooms("esphome", "thesis")
async def test_a_device_that_needs_a_network_is_refused_by_the_name_of_its_family() -> None:
    world = World(Rooms({"hall": Room()}, []), [Placed(SimulatedLamp("hall"), "hall", dialect=FAMILIES["esphome"])])
    with pytest.raises(UsageError, match=r"world: .*EsphomeFamily needs a network"):
        async with virtual_house_of(world=world):
            pass


@pytest.mark.real_time
async def test_a_real_loop_is_refused_with_the_way_out() -> None:
    with pytest.raises(UsageError, match=r"asyncio\.Runner\(loop_factory=VirtualTimeLoop\)"):
        async with virtual_house_of():
            pass


async def test_a_failed_test_shows_its_own_error() -> None:
    """Not a group with the error in it."""
    with pytest.raises(AssertionError, match="mine"):
        async with virtual_house_of("light_service") as house, EventLog.of(house):
            raise AssertionError("mine")


@pytest.mark.no_cover
async def test_the_log_is_bounded_and_counts_what_went() -> None:
    async with virtual_house_of() as house:
        log = EventLog(house.clock)
        for number in range(MAX_EVENTS + 2):
            log.record("mqtt", "t", str(number))
        assert log.lost == 2
        assert str(log).startswith("2026-01-01 00:00:00.000 mqtt t 2\n")


@pytest.mark.no_cover
def test_one_seed_is_one_day_byte_for_byte_and_another_is_another() -> None:
    """Also in a process of its own, whose sets are in another order."""
    command = [sys.executable, str(A_DAY), "thesis", "1"]
    environment = os.environ | {"PYTHONHASHSEED": "1"}
    first = subprocess.run(command, stdout=subprocess.PIPE, env=environment, timeout=120, check=True).stdout.decode()
    thesis = runpy.run_path(str(A_DAY))["thesis"]

    def lived(seed: int) -> str:
        with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
            day: str = runner.run(thesis(seed))
            return day

    assert first == lived(1) != lived(2)
    assert first.count("\n") > 700
    assert "mqtt home425/lights/roomlights405/in off" in first


async def test_every_device_of_a_big_house_has_room_at_the_broker() -> None:
    async with virtual_house_of(world=World.of(*(SimulatedLamp(f"lamp{number}") for number in range(3)))) as house:
        limits = house.broker._limits
        assert limits.max_connections == BrokerLimits().max_connections + 3
        assert limits.max_sessions == BrokerLimits().max_sessions + 6
