"""Window and heating in a simulated flat in virtual time: no heating out of the window, and warm again afterwards."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random

import anyio
import pytest
from structlog.testing import capture_logs
from tests.apps.houses import Table, flat

from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.house import World
from homebot.house.devices import SimulatedThermostat
from homebot.house.faults import unwrap
from homebot.mqtt.client import MqttSubscription
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


def airing(**more: object) -> World:
    """A study with a window and a heating of 21 °C, and a hall with a heating of its own."""
    heat: Table = {"kind": "thermostat", "room": "study", "target": 21.0}
    return flat(
        study_window={"kind": "window", "room": "study"},
        study_heat=heat | more,
        hall_heat={"kind": "thermostat", "room": "hall", "target": 20.0},
    )


def target(world: World, device: str = "study_heat") -> float:
    thermostat = unwrap(world.devices[device].device)
    assert isinstance(thermostat, SimulatedThermostat)
    return thermostat.target


@pytest.mark.parametrize("faults", [{}, {"lossy": {"share": 0.3}}])
async def test_the_heating_is_lowered_while_a_window_is_open_and_restored_after_it(faults: Table) -> None:
    """In its own room alone; commands without an answer are sent again."""
    world = airing(faults=faults)
    async with virtual_house_of("window_heating", world=world) as house:
        await house.run_for("10m")
        await house.press("study_window", "open")
        await house.run_for("5m")
        assert (target(world), target(world, "hall_heat")) == (12.0, 20.0)
        await house.press("study_window", "close")
        await house.run_for("5m")
        assert (target(world), target(world, "hall_heat")) == (21.0, 20.0)


async def test_a_door_that_somebody_goes_through_changes_nothing() -> None:
    """Its contact is open for seconds only."""
    world = flat(
        ("08:00", "study"),
        study_door={"kind": "contact", "room": "study", "door": "hall"},
        study_heat={"kind": "thermostat", "room": "study", "target": 21.0},
    )
    async with virtual_house_of("window_heating", world=world) as house:
        await house.run_until("09:00")
    assert "study_door says open" in world.event_log.text()
    assert "study_heat told" not in world.event_log.text()


async def test_the_times_and_the_setpoint_can_be_set() -> None:
    world = airing()
    config = {"apps": {"window_heating": {"open_for": 300, "lowered_to": 16}}}
    async with virtual_house_of(world=world, config=config) as house:
        await house.press("study_window", "open")
        await house.run_for("4m")
        assert target(world) == 21.0
        await house.run_for("2m")
        assert target(world) == 16.0


async def test_a_setpoint_that_somebody_changed_meanwhile_is_kept() -> None:
    world = airing()
    async with virtual_house_of("window_heating", world=world) as house:
        await house.press("study_window", "open")
        await house.run_for("5m")
        await house.press("study_heat", "18")
        await house.press("study_window", "close")
        await house.run_for("5m")
        assert target(world) == 18.0


async def test_a_deaf_thermostat_is_told_about() -> None:
    world = airing(faults={"deaf": {}})
    with capture_logs() as lines:
        async with virtual_house_of("window_heating", world=world) as house:
            await house.press("study_window", "open")
            await house.run_for("5m")
            assert target(world) == 21.0
    told = [line["message"] for line in lines if line["event"] == "control.command"]
    assert told == ["study_heat → heating setpoint 12 °C, by window_heating: no answer within 10 s"]


async def test_what_was_lowered_stays_so_when_its_run_ends() -> None:
    """The next run restores it."""
    world = airing()
    async with virtual_house_of("window_heating", world=world) as house:
        await house.press("study_window", "open")
        await house.run_for("5m")
    assert target(world) == 12.0


WINDOW = {"device_class": "window", "state_topic": "window"}
HEAT = {"temperature_command_topic": "heat/set", "temperature_state_topic": "heat", "modes": ["off", "heat"]}
MODE = {"mode_command_topic": "mode/set", "mode_state_topic": "mode"}


@dataclass
class Study:
    """A window and a thermostat on a broker, with all setpoints that this had."""

    field: MqttConnection
    broker: MemoryBroker
    index: Path
    setpoints: list[str]

    async def tell(self, **values: str) -> None:
        for topic, payload in values.items():
            await self.field.publish(topic, payload.encode(), retain=True)

    async def obey(self) -> None:
        while True:
            for message in await self.field.receive():
                self.setpoints.append(message.payload.decode())
                await self.field.publish("heat", message.payload, retain=True)

    @asynccontextmanager
    async def run(self) -> AsyncIterator[None]:
        """Run homebot inside the block, and for two minutes before it ends."""
        apps = {"window_heating": {"act": "thermostat"}}
        config = parse_config({"gateways": {"mqtt": {"act": True}}, "apps": apps}, "test")
        services, clock = [HostedBroker.in_memory(self.broker)], LoopClock()
        async with Runtime(config, with_door=False, clock=clock, services=services, index_file=self.index):
            yield
            await anyio.sleep(120)


@asynccontextmanager
async def study(folder: Path) -> AsyncIterator[Study]:
    clock, random = LoopClock(), Random(0)  # noqa: S311 - a test has no secrets
    async with MemoryBroker(clock=clock, random=random) as broker, anyio.create_task_group() as tasks:
        options = MqttOptions(host=broker.host, port=broker.port, client_id="field")
        async with MqttConnection(options, broker.make_client, status_topic=None, clock=clock, random=random) as field:
            room = Study(field, broker, folder / "index.sqlite", ["21.0"])
            await field.wait_connected()
            await field.subscribe(MqttSubscription("heat/set"))
            tasks.start_soon(room.obey)
            for kind, table in ("binary_sensor", WINDOW), ("climate", {**HEAT, **MODE}):
                device = {"identifiers": [kind], "name": kind, "suggested_area": "study"}
                described = json.dumps({**table, "name": None, "unique_id": kind, "device": device})
                await field.publish(f"homeassistant/{kind}/a/config", described.encode(), retain=True)
            yield room
            tasks.cancel_scope.cancel()


async def test_a_window_that_is_closed_while_homebot_is_off_gets_its_setpoint_back(tmp_path: Path) -> None:
    async with study(tmp_path) as room:
        await room.tell(heat="21.0", mode="heat", window="ON")
        async with room.run():
            pass
        assert room.setpoints == ["21.0", "12.0"]
        await room.tell(window="OFF")
        async with room.run():
            pass
        assert room.setpoints == ["21.0", "12.0", "21.0"]


async def test_a_thermostat_that_is_off_gets_no_setpoint_until_it_is_on(tmp_path: Path) -> None:
    """A setpoint would turn many of them on."""
    async with study(tmp_path) as room, room.run():
        for setpoints, told in (
            (["21.0"], {"heat": "21.0", "mode": "off", "window": "ON"}),
            (["21.0", "12.0"], {"mode": "heat"}),
            (["21.0", "12.0"], {"mode": "off"}),
            (["21.0", "12.0"], {"window": "OFF"}),
            (["21.0", "12.0", "21.0"], {"mode": "heat"}),
        ):
            await room.tell(**told)
            await anyio.sleep(120)
            assert room.setpoints == setpoints
